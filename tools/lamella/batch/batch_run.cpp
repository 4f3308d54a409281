#include "batch/batch.hpp"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <system_error>
#include <thread>
#include <utility>

#include <sys/stat.h>
#include <unistd.h>

#include "batch/admission.hpp"
#include "files/mesh_input.hpp"
#include "processes/workers.hpp"
#include "terminal/console.hpp"

namespace lamella::cli::batch {

namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::seconds between_lines{30};  ///< of a status without a terminal

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

/// True if another process of this number runs this program.
bool runs_here(const std::string& process) {
    if (process == std::to_string(::getpid())) {
        return false;
    }
    std::error_code unknown;
    const std::filesystem::path own = std::filesystem::read_symlink("/proc/self/exe", unknown);
    const std::filesystem::path other = std::filesystem::read_symlink("/proc/" + process + "/exe", unknown);
    return !unknown && own == other;
}

/// Removes the files aside that killed processes left beside a target, unless a process of that number runs this program on
/// this machine after `patience`: one that is being killed is still listed for a moment. Nothing else is touched. The caller
/// holds the lock by which only one batch works on the targets.
void remove_leftovers(const std::vector<std::string>& targets, std::chrono::milliseconds patience) {
    constexpr std::size_t longest_stem = 180;  // of a target in the name of its file aside: io/write/output_file.cpp
    static const std::regex aside(R"(\.([^]+)\.([0-9]+)-[0-9]+\.part)");  // ".NAME.PID-TIME.part", as named there
    std::map<std::filesystem::path, std::set<std::string>> names;
    for (const std::string& target : targets) {
        const std::filesystem::path path(target);
        names[path.has_parent_path() ? path.parent_path() : "."].insert(path.filename().string().substr(0, longest_stem));
    }
    const auto until = Clock::now() + patience;
    for (const auto& [folder, wanted] : names) {
        std::error_code ignored;
        for (const std::filesystem::directory_entry& entry : entries_of(folder, ignored)) {
            const std::string name = entry.path().filename().string();
            std::smatch parts;
            if (!std::regex_match(name, parts, aside) || !wanted.contains(parts.str(1))) {
                continue;
            }
            while (runs_here(parts.str(2)) && Clock::now() < until) {
                std::this_thread::sleep_for(std::chrono::milliseconds(10));
            }
            if (!runs_here(parts.str(2))) {
                std::filesystem::remove(entry.path(), ignored);
            }
        }
    }
}

struct BatchCounts {
    std::size_t items = 0;             ///< of the batch
    std::size_t unchanged = 0;         ///< done before
    std::size_t done = 0;              ///< now
    std::size_t failed = 0;            ///< now
    std::size_t of_older_version = 0;  ///< done before, by a version of lamella with other defaults
    double triangles = 0;              ///< of those done
    double cost = 0;                   ///< of those that ended, as estimated
    double all_cost = 0;               ///< of those to do

    std::size_t ended() const noexcept { return unchanged + done + failed; }
};

constexpr std::size_t most_listed = 20;  ///< of meshes that failed

/// "35 s", "12 min", "3.4 h"
std::string duration_text(double seconds) {
    constexpr double minute = 60;
    constexpr double hour = 60 * minute;
    if (seconds < 2 * minute) {
        return rounded(seconds, seconds < 10 ? 1 : 0) + " s";
    }
    return seconds < 2 * hour ? rounded(seconds / minute, 0) + " min" : rounded(seconds / hour, 1) + " h";
}

/// "1.2 M triangles/s"
std::string rate_text(double triangles_per_s) {
    constexpr double million = 1e6;
    return triangles_per_s >= million ? rounded(triangles_per_s / million, 1) + " M triangles/s"
                                      : rounded(triangles_per_s / 1e3, 1) + " k triangles/s";
}

/// How far it is after so many seconds, on one line.
std::string batch_status(const BatchCounts& counts, double seconds) {
    std::string text = grouped(counts.ended()) + " of " + counted(counts.items, "mesh", "meshes");
    text += when(counts.triangles > 0, ", " + rate_text(counts.triangles / std::max(seconds, 1e-3)));
    if (counts.cost > 0 && counts.all_cost > counts.cost) {
        text += ", " + duration_text(seconds * (counts.all_cost / counts.cost - 1)) + " left";
    }
    return counts.failed == 0 ? text : text + ", " + grouped(counts.failed) + " failed";
}

class BatchRun {
public:
    BatchRun(std::vector<Item> items, const LedgerName& name, const BatchArguments& options, Interrupt& interrupt)
        : items_(std::move(items)),
          options_(options),
          interrupt_(interrupt),
          stop_(interrupt.defer()),
          ledger_(name),
          admission_(options.jobs, options.memory_bytes),
          bar_(options.slice.progress),
          next_status_(Clock::now() + (bar_.shown() ? Clock::duration(0) : between_lines)),
          attempts_(items_.size()),
          output_inodes_(items_.size()),
          pool_(options.timeout_s) {}

    std::size_t run() {
        clean(std::chrono::milliseconds(2000));
        choose_items();
        start_what_fits();
        while (pool_.running() > 0) {
            const std::vector<WorkerEnd> ended = pool_.wait(std::chrono::milliseconds(100));
            stop_if_asked();
            for (const WorkerEnd& end : ended) {
                admission_.ended(end.item, end.peak_bytes);
            }
            start_what_fits();  // before the disk is waited for
            for (const WorkerEnd& end : ended) {
                take(end);
            }
            show_status();
            start_what_fits();  // what is tried again
        }
        stop_if_asked();
        bar_.wipe();
        clean(std::chrono::milliseconds(0));
        ledger_.finish(items_);
        interrupt_.end_deferring();
        print(summary());
        return failed_.size();
    }

private:
    void clean(std::chrono::milliseconds patience) const {
        std::vector<std::string> targets = {ledger_.path()};
        for (const Item& item : items_) {
            const std::vector<std::string> files = item.all_files();
            targets.insert(targets.end(), files.begin(), files.end());
        }
        remove_leftovers(targets, patience);
    }

    void choose_items() {
        counts_.items = items_.size();
        for (std::size_t i = 0; i < items_.size(); ++i) {
            if (is_unchanged(i)) {
                ++counts_.unchanged;
                continue;
            }
            admission_.add(i, estimate_mesh(items_[i].mesh, bytes_of(i)), items_[i].threads);
            counts_.all_cost += cost_of(i);
            stop_if_asked();
        }
        admission_.sort();
    }

    bool is_unchanged(std::size_t i) {
        Item& item = items_[i];
        const ResultLine* const line = ledger_.find(item.key());
        const bool by_content = line != nullptr && line->json.at("inputs").at(0).contains("sha256");
        item.inputs.push_back(fact_of(item.mesh, options_.hash || by_content, stop_));
        for (const std::string& path : item.option_files) {
            item.inputs.push_back(fact_of(path, options_.hash || by_content, stop_));
        }
        if (options_.force || line == nullptr) {
            return false;
        }
        counts_.of_older_version += line->done() && is_of_older_version(*line) ? 1 : 0;
        return is_done(item, *line);
    }

    void start_what_fits() {
        while (const std::optional<Admitted> admitted = admission_.next()) {
            start(*admitted);
        }
    }

    void start(const Admitted& admitted) {
        const std::size_t i = admitted.item;
        const Item& item = items_[i];
        if (const std::string reason = why_not_in_memory(i); !reason.empty()) {
            admission_.ended(i, 0);
            return fail(i, reason);
        }
        for (const std::string& file : item.all_files()) {
            make_folder_of(file);
        }
        output_inodes_[i] = inodes_of(item.files);
        ++attempts_[i];
        pool_.start(i, {"slice", words_of(item, admitted)});
    }

    /// Slice cuts a mesh larger than all of the memory in ranges, unless some option needs the whole mesh.
    std::string why_not_in_memory(std::size_t i) const {
        if (!admission_.is_too_large(i)) {
            return {};
        }
        const Item& item = items_[i];
        for (const std::string& name : options_.names_without_memory) {
            const auto is_given = [&](const std::string& word) { return word == name || word.starts_with(name + "="); };
            if (std::any_of(item.words.begin(), item.words.end(), is_given) ||
                (name == "--report" && !item.report.empty())) {
                return "needs about " + file_size_text(static_cast<std::uint64_t>(admission_.need_of(i))) +
                       " of memory, more than --memory has, as " + name + " needs the whole mesh";
            }
        }
        return {};
    }

    std::vector<std::string> words_of(const Item& item, const Admitted& admitted) const {
        std::vector<std::string> words = item.words;
        if (admission_.is_too_large(admitted.item)) {
            words.push_back("--memory=" + std::to_string(options_.memory_bytes));
        } else {
            words.insert(words.end(), item.plain.begin(), item.plain.end());
        }
        words.insert(words.end(), item.writes.begin(), item.writes.end());
        words.insert(words.end(), {"--threads=" + std::to_string(admitted.threads), "--progress=never", "--", item.mesh});
        return words;
    }

    void take(const WorkerEnd& end) {
        const Item& item = items_[end.item];
        if (!end.failure.empty()) {
            if (end.may_retry && attempts_[end.item] <= options_.retries) {
                remove_new_outputs(end.item);
                return admission_.add_again(end.item, end.lacked_memory);
            }
            return fail(end.item, reason_of(end.failure, item.mesh));
        }
        ledger_.append(result_of(item, "", end.facts));
        ++counts_.done;
        counts_.cost += cost_of(end.item);
        counts_.triangles += end.facts.value("triangles", 0.0);
    }

    void fail(std::size_t i, const std::string& reason) {
        const Item& item = items_[i];
        remove_new_outputs(i);
        bar_.wipe();
        complain(item.mesh + ": " + reason);
        ledger_.append(result_of(item, reason, Json::object()));
        ++counts_.failed;
        counts_.cost += cost_of(i);
        failed_.emplace(i, reason);
    }

    std::uint64_t bytes_of(std::size_t i) const { return items_[i].inputs.at(0).at("bytes").get<std::uint64_t>(); }
    double cost_of(std::size_t i) const { return process_bytes + static_cast<double>(bytes_of(i)); }

    /// None of several outputs of a mesh that failed stays; those of an earlier batch do.
    void remove_new_outputs(std::size_t i) const {
        const std::vector<std::string>& files = items_[i].files;
        const std::vector<std::uint64_t> inodes = inodes_of(files);
        for (std::size_t f = 0; f < output_inodes_[i].size(); ++f) {
            if (inodes[f] != 0 && inodes[f] != output_inodes_[i][f]) {
                std::error_code ignored;
                std::filesystem::remove(files[f], ignored);
            }
        }
    }

    /// On a terminal by the bar, else by a line from time to time.
    void show_status() {
        const Clock::time_point now = Clock::now();
        if (now < next_status_ || options_.slice.progress == ProgressBar::When::never) {
            return;
        }
        const std::string status = batch_status(counts_, watch_.ms() / 1000);
        if (bar_.shown()) {
            next_status_ = now + std::chrono::milliseconds(200);
            bar_.show(status, counts_.all_cost > 0 ? counts_.cost / counts_.all_cost : 0);
        } else {
            next_status_ = now + between_lines;
            complain(status);
        }
    }

    /// The pool ends its processes as this ends.
    void stop_if_asked() const {
        if (stop_()) {
            throw Failure(bad_input, "cancelled");
        }
    }

    /// Some lines for people, each a keyword and what there is to say.
    std::string summary() const {
        const double seconds = watch_.ms() / 1000;
        std::string text = "meshes    " + grouped(counts_.items) + ": " + grouped(counts_.done) + " done, " +
                           grouped(counts_.unchanged) + " unchanged, " + grouped(failed_.size()) + " failed\n";
        text += when(counts_.triangles > 0, "sliced    " + grouped(static_cast<std::uint64_t>(counts_.triangles)) +
                                                " triangles in " + duration_text(seconds) + ", " +
                                                rate_text(counts_.triangles / std::max(seconds, 1e-3)) + "\n");
        text +=
            when(counts_.of_older_version > 0, "again     " + counted(counts_.of_older_version, "mesh", "meshes") +
                                                   " that an older version of lamella sliced, whose defaults were others\n");
        text += "results   " + printable(ledger_.path()) + "\n";
        std::size_t listed = 0;
        for (const auto& [item, reason] : failed_) {
            text +=
                when(listed++ < most_listed, "failed    " + printable(items_[item].mesh) + ": " + printable(reason) + "\n");
        }
        if (failed_.size() > most_listed) {
            text += "          and " + grouped(failed_.size() - most_listed) + " more, which " + printable(ledger_.path()) +
                    " names\n";
        }
        return failed_.empty() ? text : text + "retry     the same command again slices those that failed, and no other\n";
    }

    std::vector<Item> items_;
    const BatchArguments& options_;
    Interrupt& interrupt_;
    Callback<bool()> stop_;
    Ledger ledger_;
    Admission admission_;
    ProgressBar bar_;
    Stopwatch watch_;
    Clock::time_point next_status_;
    BatchCounts counts_;
    std::vector<int> attempts_;                              ///< by item
    std::vector<std::vector<std::uint64_t>> output_inodes_;  ///< by item: of its outputs, when it began
    std::map<std::size_t, std::string> failed_;              ///< by item: why
    WorkerPool pool_;  ///< the last member: its processes end before what they are recorded in
};

}  // namespace

std::size_t run_batch(std::vector<Item> items, const LedgerName& name, const BatchArguments& options, Interrupt& interrupt) {
    return BatchRun(std::move(items), name, options, interrupt).run();
}

}  // namespace lamella::cli::batch
