#include "batch/batch_run.hpp"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include <sys/stat.h>

#include "batch/results/item_state.hpp"
#include "batch/results/leftovers.hpp"
#include "terminal/failure.hpp"

namespace lamella::cli::batch {

namespace {

constexpr std::chrono::milliseconds wake_up{100};

/// Without the mesh's name, which stands beside it.
std::string reason_of(const std::string& failure, const std::string& mesh) {
    const std::string before = printable(mesh) + ": ";
    return failure.starts_with(before) ? failure.substr(before.size()) : failure;
}

/// 0 where there is no such file.
std::vector<std::uint64_t> inodes_of(const std::vector<std::string>& paths) {
    std::vector<std::uint64_t> inodes;
    for (const std::string& path : paths) {
        struct stat file {};
        inodes.push_back(::stat(path.c_str(), &file) == 0 ? file.st_ino : 0);
    }
    return inodes;
}

void make_folder_of(const std::string& path) {
    const std::filesystem::path folder = std::filesystem::path(path).parent_path();
    std::error_code problem;
    if (!folder.empty()) {
        std::filesystem::create_directories(folder, problem);  // That it failed shows when slice writes there.
    }
}

LedgerName in_made_folder(const LedgerName& name) {
    make_folder_of(name.path());
    return name;
}

}  // namespace

BatchRun::BatchRun(std::vector<Item> items, const LedgerName& name, const RunOptions& options, Interrupt& interrupt)
    : items_(std::move(items)),
      options_(options),
      interrupt_(interrupt),
      stop_(interrupt.defer()),
      ledger_(in_made_folder(name)),
      admission_(options.jobs, options.memory_bytes),
      progress_(options.progress),
      attempts_(items_.size()),
      output_inodes_(items_.size()),
      pool_(options.timeout_s) {}

void BatchRun::clean(std::chrono::milliseconds patience) const {
    std::vector<std::string> targets = {ledger_.path()};
    for (const Item& item : items_) {
        targets.insert(targets.end(), item.files.begin(), item.files.end());
        if (!item.report.empty()) {
            targets.push_back(item.report);
        }
    }
    remove_leftovers(targets, patience);
}

void BatchRun::run() {
    clean(std::chrono::milliseconds(2000));
    choose_items();
    while (true) {
        start_what_fits();
        if (pool_.running() == 0) {
            break;
        }
        const std::vector<WorkerEnd> ended = pool_.wait(wake_up);
        stop_if_asked();
        for (const WorkerEnd& end : ended) {
            admission_.ended(end.item, end.peak_bytes);
        }
        start_what_fits();  // before the disk is waited for
        for (const WorkerEnd& end : ended) {
            take(end);
        }
        progress_.show(counts_);
    }
    stop_if_asked();
    progress_.wipe();
    clean(std::chrono::milliseconds(0));
    ledger_.finish(items_);
    interrupt_.end_deferring();
}

void BatchRun::start_what_fits() {
    while (const std::optional<Admitted> admitted = admission_.next()) {
        start(*admitted);
    }
}

void BatchRun::choose_items() {
    counts_.items = items_.size();
    for (std::size_t i = 0; i < items_.size(); ++i) {
        if (is_unchanged(i)) {
            ++counts_.unchanged;
            continue;
        }
        const std::uint64_t bytes = items_[i].inputs.front().bytes;
        admission_.add(i, estimate_mesh(items_[i].mesh, bytes), items_[i].threads);
        counts_.all_cost += process_bytes + static_cast<double>(bytes);
        stop_if_asked();
    }
    admission_.sort();
}

bool BatchRun::is_unchanged(std::size_t i) {
    Item& item = items_[i];
    const ResultLine* const line = ledger_.find(item.key());
    const bool by_content = line != nullptr && !line->inputs.empty() && !line->inputs.front().sha256.empty();
    try {
        item.inputs.push_back(fact_of(item.mesh, options_.hash || by_content, stop_));
        for (const std::string& path : item.option_files) {
            item.inputs.push_back(fact_of(path, options_.hash || by_content, stop_));
        }
    } catch (const Failure&) {
        stop_if_asked();
        throw;
    }
    if (options_.force || line == nullptr) {
        return false;
    }
    counts_.of_older_version += line->done() && is_of_older_version(*line) ? 1 : 0;
    return is_done(item, *line);
}

std::vector<std::string> BatchRun::words_of(const Item& item, const Admitted& admitted) const {
    std::vector<std::string> words = item.words;
    const bool in_ranges = admission_.is_too_large(admitted.item);
    if (!in_ranges) {
        words.insert(words.end(), item.plain.begin(), item.plain.end());
    }
    for (const std::string& output : item.outputs) {
        words.push_back("--output=" + output);
    }
    if (!item.to.empty()) {
        words.push_back("--to=" + item.to);
    }
    if (!item.report.empty()) {
        words.push_back("--report=" + item.report);
    }
    words.push_back("--threads=" + std::to_string(admitted.threads));
    words.emplace_back("--progress=never");
    if (in_ranges) {
        words.push_back("--memory=" + std::to_string(options_.memory_bytes));
    }
    words.insert(words.end(), {"--", item.mesh});
    return words;
}

/// Slice cuts a mesh larger than all of the memory in ranges, unless some option needs the whole mesh.
std::string BatchRun::why_not_in_memory(std::size_t i) const {
    if (!admission_.is_too_large(i)) {
        return {};
    }
    const Item& item = items_[i];
    for (const std::string& name : options_.names_without_memory) {
        const auto is_given = [&](const std::string& word) { return word == name || word.starts_with(name + "="); };
        if (std::any_of(item.words.begin(), item.words.end(), is_given) || (name == "--report" && !item.report.empty())) {
            return "needs about " + file_size_text(static_cast<std::uint64_t>(admission_.need_of(i))) +
                   " of memory, more than --memory has, as " + name + " needs the whole mesh";
        }
    }
    return {};
}

void BatchRun::start(const Admitted& admitted) {
    const std::size_t i = admitted.item;
    const Item& item = items_[i];
    if (const std::string reason = why_not_in_memory(i); !reason.empty()) {
        admission_.ended(i, 0);
        return fail(i, reason);
    }
    for (const std::string& file : item.files) {
        make_folder_of(file);
    }
    if (!item.report.empty()) {
        make_folder_of(item.report);
    }
    output_inodes_[i] = inodes_of(item.files);
    ++attempts_[i];
    pool_.start(i, {"slice", words_of(item, admitted)});
}

void BatchRun::take(const WorkerEnd& end) {
    const Item& item = items_[end.item];
    if (!end.failure.empty()) {
        if (end.may_retry && attempts_[end.item] <= options_.retries) {
            remove_new_outputs(item, end.item);
            return admission_.add_again(end.item, end.lacked_memory);
        }
        return fail(end.item, reason_of(end.failure, item.mesh));
    }
    ResultLine line{item.mesh, "", item.words, item.inputs, outputs_of(item), end.facts};
    ledger_.append(line);
    ++counts_.done;
    counts_.cost += process_bytes + static_cast<double>(item.inputs.front().bytes);
    counts_.triangles += end.facts ? static_cast<double>(end.facts->triangles) : 0;
}

void BatchRun::fail(std::size_t i, const std::string& reason) {
    const Item& item = items_[i];
    remove_new_outputs(item, i);
    ResultLine line{item.mesh, reason, item.words, item.inputs, {}, std::nullopt};
    for (const std::string& file : item.files) {
        line.outputs.push_back({file, std::nullopt});
    }
    progress_.tell(item.mesh + ": " + reason);
    ledger_.append(line);
    ++counts_.failed;
    counts_.cost += process_bytes + static_cast<double>(item.inputs.front().bytes);
    failed_.push_back({i, {item.mesh, reason}});
}

/// Of a mesh that failed, none of several outputs stays; those of an earlier batch do.
void BatchRun::remove_new_outputs(const Item& item, std::size_t i) const {
    if (output_inodes_[i].empty()) {
        return;
    }
    const std::vector<std::uint64_t> inodes = inodes_of(item.files);
    for (std::size_t f = 0; f < inodes.size(); ++f) {
        if (inodes[f] != 0 && inodes[f] != output_inodes_[i][f]) {
            std::error_code ignored;
            std::filesystem::remove(item.files[f], ignored);
        }
    }
}

void BatchRun::stop_if_asked() {
    if (stop_.stop_requested()) {
        progress_.wipe();
        pool_.end_all();
        interrupt_.die_if_interrupted();
    }
}

std::string BatchRun::summary() const {
    std::vector<std::pair<std::size_t, FailedItem>> ordered = failed_;
    std::sort(ordered.begin(), ordered.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<FailedItem> failed;
    failed.reserve(ordered.size());
    for (auto& [item, what] : ordered) {
        failed.push_back(std::move(what));
    }
    return batch_summary(counts_, progress_.seconds(), ledger_.path(), failed);
}

}  // namespace lamella::cli::batch
