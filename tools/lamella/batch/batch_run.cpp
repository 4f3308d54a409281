#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <filesystem>
#include <fstream>
#include <future>
#include <mutex>
#include <regex>
#include <set>
#include <system_error>
#include <thread>
#include <utility>

#include "base/system/file.hpp"
#include "batch/batch.hpp"
#include "files/mesh_input.hpp"
#include "processes/process.hpp"
#include "system/process.hpp"
#include "terminal/console.hpp"

namespace lamella::cli::batch {

namespace {

constexpr std::chrono::seconds between_lines{30};  ///< of a status without a terminal
constexpr std::size_t most_listed = 20;            ///< of meshes that failed

constexpr double process_bytes = 16e6;  ///< that slicing the smallest mesh takes

struct FormatCost {
    std::string_view end;     ///< of the name
    std::string_view marker;  ///< in the first bytes; empty: any
    double memory;            ///< bytes, for each byte of the file
};

/// The first row that fits holds. Each is the largest of what was measured.
constexpr std::array<FormatCost, 14> costs = {{
    {".stl.gz", "", 19},
    {".gz", "", 22},
    {".stl", "facet", 1.3},
    {".stl", "", 2.9},
    {".obj", "", 3.7},
    {".off", "", 3.7},
    {".ply", "format ascii", 3.5},
    {".ply", "", 7.2},
    {".vtk", "ASCII", 3.5},
    {".vtk", "", 6.4},
    {".vtp", "compressor=", 12.5},
    {".vtp", "", 6.9},
    {".3mf", "", 11.1},
    {"", "", 10},
}};

/// Memory that slicing a mesh is estimated to take, by the first bytes and the size of its file. O(1). A file that cannot be
/// read is estimated as empty. Peak resident sizes by format were measured with bench/scripts/commands.py batch-memory;
/// bench/README.md has the table.
double estimate_memory(const std::string& path, std::uint64_t file_bytes) {
    const std::string name = lower_case(path);
    std::array<char, 512> begin{};
    std::error_code unknown;
    if (std::filesystem::is_regular_file(path_of(path), unknown)) {  // A pipe could keep the batch waiting.
        std::ifstream(path_of(path), std::ios::binary).read(begin.data(), begin.size());
    }
    const auto* const cost = std::find_if(costs.begin(), costs.end(), [&](const FormatCost& row) {
        return name.ends_with(row.end) &&
               std::string_view(begin.data(), begin.size()).find(row.marker) != std::string_view::npos;
    });
    return process_bytes + static_cast<double>(file_bytes) * cost->memory;
}

/// Of each file, 0 where there is none.
std::vector<std::uint64_t> numbers_of(const std::vector<std::string>& paths) {
    std::vector<std::uint64_t> numbers;
    numbers.reserve(paths.size());
    for (const std::string& path : paths) {
        FileStatus file;
        numbers.push_back(status_of(path_of(path), file) == 0 ? file.number : 0);
    }
    return numbers;
}

/// Removes the files aside that killed processes left beside a target, unless a process of that number runs this program on
/// this machine after two seconds: one that is being killed is still listed for a moment. Nothing else is touched. The
/// caller holds the lock by which only one batch works on the targets.
void remove_leftovers(const std::vector<std::string>& targets) {
    constexpr std::size_t longest_stem = 180;  // of a target in the name of its file aside: io/write/output_file.cpp
    static const std::regex aside(R"(\.([^]+)\.([0-9]+)-[0-9]+\.part)");  // ".NAME.PID-TIME.part", as named there
    std::map<std::filesystem::path, std::set<std::string>> names;
    for (const std::string& target : targets) {
        const std::filesystem::path path = path_of(target);
        names[path.has_parent_path() ? path.parent_path() : "."].insert(path.filename().string().substr(0, longest_stem));
    }
    const auto until = Clock::now() + std::chrono::seconds(2);
    for (const auto& [folder, wanted] : names) {
        std::error_code ignored;
        for (const std::filesystem::directory_entry& entry : entries_of(folder, ignored)) {
            const std::string name = entry.path().filename().string();
            std::smatch parts;
            if (!std::regex_match(name, parts, aside) || !wanted.contains(parts.str(1))) {
                continue;
            }
            std::uint64_t process = 0;
            const std::string number = parts.str(2);
            (void)read_integer(std::string_view(number), process);
            while (runs_this_program(process) && Clock::now() < until) {
                std::this_thread::sleep_for(std::chrono::milliseconds(10));
            }
            if (!runs_this_program(process)) {
                std::filesystem::remove(entry.path(), ignored);
            }
        }
    }
}

/// An item that is to be sliced.
struct Job {
    std::size_t item = 0;
    double file_bytes = 0;
    double memory = 0;  ///< as estimated
    int attempts = 0;
    bool alone = false;                           ///< with nothing beside it, as it lacked memory
    std::vector<std::uint64_t> output_numbers{};  ///< of its outputs, when it began
    int threads = 0;                              ///< while it runs, as what follows
    double held_memory = 0;
    std::future<void> ending{};  ///< of its process, for which who drops it waits
};

class BatchRun {
public:
    BatchRun(std::vector<Item> items, const ResultsName& name, const BatchArguments& options, Interrupt& interrupt)
        : items_(std::move(items)),
          options_(options),
          interrupt_(interrupt),
          stop_(interrupt.defer()),
          results_(name),
          bar_(options.slice.progress),
          next_status_(Clock::now() + (bar_.shown() ? Clock::duration(0) : between_lines)) {}
    ~BatchRun() { over_ = true; }  // The threads wait for their processes, which that ends.
    BatchRun(const BatchRun&) = delete;
    BatchRun& operator=(const BatchRun&) = delete;

    void run() {
        clean();
        choose_items();
        start_what_fits();
        while (!running_.empty()) {
            for (auto& [item, end] : wait()) {
                Job job = std::move(running_.extract(item).mapped());
                held_memory_ -= job.held_memory;
                free_threads_ += job.threads;
                learn(job, end.peak_bytes);
                start_what_fits();  // before the disk is waited for
                take(std::move(job), end);
            }
            show_status();
            start_what_fits();  // what is tried again
        }
        stop_if_asked();
        bar_.wipe();
        clean();
        results_.finish(items_);
        interrupt_.end_deferring();
        print_words(summary(), false, options_.slice.quiet);
        refuse_if(!failed_.empty(), some_failed,
                  grouped(failed_.size()) + " of " + counted(items_.size(), "mesh", "meshes") + " failed");
    }

private:
    void clean() const {
        std::vector<std::string> targets = {results_.path()};
        for (const Item& item : items_) {
            const std::vector<std::string> files = item.all_files();
            targets.insert(targets.end(), files.begin(), files.end());
        }
        remove_leftovers(targets);
    }

    void choose_items() {
        for (std::size_t i = 0; i < items_.size(); ++i) {
            stop_if_asked();
            if (is_unchanged(items_[i])) {
                ++unchanged_;
                continue;
            }
            const auto bytes = items_[i].inputs.at(0).at("bytes").get<std::uint64_t>();
            waiting_.push_back(
                {.item = i, .file_bytes = static_cast<double>(bytes), .memory = estimate_memory(items_[i].mesh, bytes)});
            all_cost_ += cost_of(waiting_.back());
        }
        std::stable_sort(waiting_.begin(), waiting_.end(), [](const Job& a, const Job& b) { return a.memory > b.memory; });
    }

    bool is_unchanged(Item& item) {
        const ResultLine* const line = results_.find(item.key());
        const bool by_content = line != nullptr && line->json.at("inputs").at(0).contains("sha256");
        item.inputs.push_back(fact_of(item.mesh, options_.hash || by_content, stop_));
        for (const std::string& path : item.option_files) {
            item.inputs.push_back(fact_of(path, options_.hash || by_content, stop_));
        }
        if (options_.force || line == nullptr) {
            return false;
        }
        of_older_version_ += line->failure.empty() && line->is_of_older_version() ? 1U : 0U;
        return line->is_of(item);
    }

    /// Memory: the estimate, times how far the worst mesh so far went beyond its own.
    double need_of(const Job& job) const { return process_bytes + (job.memory - process_bytes) * factor_; }
    bool is_too_large(const Job& job) const { return need_of(job) > static_cast<double>(options_.memory_bytes); }
    bool is_alone(const Job& job) const { return job.alone || is_too_large(job); }

    bool fits(const Job& job) const {
        return running_.empty() || (!is_alone(running_.begin()->second) && !job.alone && free_threads_ > 0 &&
                                    held_memory_ + need_of(job) <= static_cast<double>(options_.memory_bytes));
    }

    /// All that are left where only few such meshes are left or fit into memory at once; else one or two for a small mesh.
    int threads_for(const Job& job) const {
        constexpr double small = 450e6;  // bytes: below, a second thread earns less than another mesh would
        if (items_[job.item].threads > 0) {
            return items_[job.item].threads;
        }
        if (is_alone(job)) {
            return options_.jobs;
        }
        const double at_once = std::min(static_cast<double>(options_.memory_bytes) / need_of(job),
                                        static_cast<double>(running_.size() + waiting_.size()));
        const int share = options_.jobs / static_cast<int>(std::clamp<double>(at_once, 1, options_.jobs));
        return std::clamp(job.memory < small ? std::min(share, 2) : share, 1, std::max(1, free_threads_));
    }

    /// The largest first.
    void start_what_fits() {
        for (auto at = waiting_.begin(); at != waiting_.end();) {
            if (!fits(*at)) {
                ++at;
                continue;
            }
            at->threads = threads_for(*at);
            Job job = std::move(*at);
            at = waiting_.erase(at);
            start(std::move(job));
        }
    }

    void start(Job job) {
        const Item& item = items_[job.item];
        for (const std::string& file : item.all_files()) {
            std::error_code problem;  // shows when slice writes there
            std::filesystem::create_directories(path_of(file).parent_path(), problem);
        }
        job.output_numbers = numbers_of(item.files);
        job.held_memory = need_of(job);
        held_memory_ += job.held_memory;
        free_threads_ -= job.threads;
        ++job.attempts;
        job.ending = std::async(std::launch::async, [this, i = job.item, words = words_of(job)] {
            ProcessEnd end;
            try {
                end = run_process(words, "", options_.timeout_s, [this] { return over_ || stop_(); });
            } catch (const std::exception& problem) {
                end.failure = problem.what();
            }
            const std::lock_guard lock(mutex_);
            ended_.emplace_back(i, std::move(end));
            some_ended_.notify_one();
        });
        running_.emplace(job.item, std::move(job));
    }

    /// The items whose processes have ended, after a tenth of a second at most.
    std::vector<std::pair<std::size_t, ProcessEnd>> wait() {
        std::unique_lock lock(mutex_);
        some_ended_.wait_for(lock, std::chrono::milliseconds(100), [this] { return !ended_.empty(); });
        stop_if_asked();
        return std::exchange(ended_, {});
    }

    /// Slice cuts a mesh larger than all of the memory in ranges, and refuses where something needs the whole mesh.
    std::vector<std::string> words_of(const Job& job) const {
        const Item& item = items_[job.item];
        std::vector<std::string> words = {"slice"};
        words.insert(words.end(), item.words.begin(), item.words.end());
        if (is_too_large(job)) {
            words.push_back("--memory=" + std::to_string(options_.memory_bytes));
        } else {
            words.insert(words.end(), item.plain.begin(), item.plain.end());
        }
        words.insert(words.end(), item.writes.begin(), item.writes.end());
        words.insert(words.end(), {"--threads=" + std::to_string(job.threads), "--progress=never", "--", item.mesh});
        return words;
    }

    void take(Job job, const ProcessEnd& end) {
        if (end.failure.empty()) {
            results_.append(ResultLine(items_[job.item], "", end.facts));
            ++done_;
            cost_ += cost_of(job);
            triangles_ += end.facts.value("triangles", 0.0);
        } else if (end.may_retry && job.attempts <= options_.retries) {
            remove_new_outputs(job);
            job.alone = end.lacked_memory;
            waiting_.push_back(std::move(job));
        } else {
            const Item& item = items_[job.item];
            const std::string need = file_size_text(static_cast<std::uint64_t>(need_of(job)));
            const std::string name = printable(item.mesh) + ": ";  // which stands beside the reason
            const std::string reason =
                when(is_too_large(job), "needs about " + need + " of memory, more than --memory has for all: ") +
                end.failure.substr(end.failure.starts_with(name) ? name.size() : 0);
            remove_new_outputs(job);
            bar_.wipe();
            complain(item.mesh + ": " + reason);
            results_.append(ResultLine(item, reason, Json::object()));
            cost_ += cost_of(job);
            failed_.emplace(job.item, reason);
        }
    }

    void learn(const Job& job, std::uint64_t peak_bytes) {
        constexpr double worth_learning = 64e6;
        constexpr double most = 8;
        const double over = static_cast<double>(peak_bytes) - process_bytes;
        if (over > worth_learning && !job.alone) {
            factor_ = std::clamp(over / std::max(worth_learning / most, job.memory - process_bytes), factor_, most);
        }
    }

    static double cost_of(const Job& job) { return process_bytes + job.file_bytes; }

    /// None of several outputs of a mesh that failed stays; those of an earlier batch do.
    void remove_new_outputs(const Job& job) const {
        const std::vector<std::string>& files = items_[job.item].files;
        const std::vector<std::uint64_t> numbers = numbers_of(files);
        for (std::size_t f = 0; f < job.output_numbers.size(); ++f) {
            if (numbers[f] != 0 && numbers[f] != job.output_numbers[f]) {
                std::error_code ignored;
                std::filesystem::remove(path_of(files[f]), ignored);
            }
        }
    }

    /// How far it is: on a terminal by the bar, else by a line from time to time.
    void show_status() {
        const Clock::time_point now = Clock::now();
        if (now < next_status_ || options_.slice.progress == ProgressBar::When::never) {
            return;
        }
        const double seconds = watch_.ms() / 1000;
        std::string status =
            grouped(unchanged_ + done_ + failed_.size()) + " of " + counted(items_.size(), "mesh", "meshes");
        status += when(triangles_ > 0, ", " + rate_text(triangles_, "triangles", seconds));
        status += when(cost_ > 0 && all_cost_ > cost_, ", " + duration_text(seconds * (all_cost_ / cost_ - 1)) + " left");
        status += when(!failed_.empty(), ", " + grouped(failed_.size()) + " failed");
        if (bar_.shown()) {
            next_status_ = now + std::chrono::milliseconds(200);
            bar_.show(status, all_cost_ > 0 ? cost_ / all_cost_ : 0);
        } else {
            next_status_ = now + between_lines;
            complain(status);
        }
    }

    void stop_if_asked() const { refuse_if(stop_(), bad_input, "cancelled"); }

    /// Some lines for people, each a keyword and what there is to say.
    std::string summary() const {
        const double seconds = watch_.ms() / 1000;
        std::string text = "meshes    " + grouped(items_.size()) + ": " + grouped(done_) + " done, " + grouped(unchanged_) +
                           " unchanged, " + grouped(failed_.size()) + " failed\n";
        text += when(triangles_ > 0, "sliced    " + grouped(static_cast<std::uint64_t>(triangles_)) + " triangles in " +
                                         duration_text(seconds) + ", " + rate_text(triangles_, "triangles", seconds) + "\n");
        text += when(of_older_version_ > 0, "again     " + counted(of_older_version_, "mesh", "meshes") +
                                                " that an older version of lamella sliced, whose defaults were others\n");
        text += "results   " + printable(results_.path()) + "\n";
        std::size_t listed = 0;
        for (const auto& [item, reason] : failed_) {
            text +=
                when(listed++ < most_listed, "failed    " + printable(items_[item].mesh) + ": " + printable(reason) + "\n");
        }
        text += when(listed > most_listed, "          and " + grouped(listed - most_listed) + " more, which " +
                                               printable(results_.path()) + " names\n");
        return text + when(listed > 0, "retry     the same command again slices those that failed, and no other\n");
    }

    std::vector<Item> items_;
    const BatchArguments& options_;
    Interrupt& interrupt_;
    Callback<bool()> stop_;
    ResultsFile results_;
    ProgressBar bar_;
    Stopwatch watch_;
    Clock::time_point next_status_;
    std::size_t unchanged_ = 0;         ///< done before
    std::size_t done_ = 0;              ///< now
    std::size_t of_older_version_ = 0;  ///< done before, by a version of lamella with other defaults
    double triangles_ = 0;              ///< of those done
    double cost_ = 0;                   ///< of those that ended, as estimated
    double all_cost_ = 0;               ///< of those to do
    double factor_ = 1;                 ///< see need_of()
    double held_memory_ = 0;            ///< of those running, as what follows
    int free_threads_ = options_.jobs;
    std::map<std::size_t, std::string> failed_;  ///< by item: why
    std::vector<Job> waiting_;
    std::atomic<bool> over_ = false;
    std::mutex mutex_;  ///< of what ended
    std::condition_variable some_ended_;
    std::vector<std::pair<std::size_t, ProcessEnd>> ended_;  ///< by item
    std::map<std::size_t, Job> running_;                     ///< by item; the last member: its threads use the others
};

}  // namespace

void run_batch(std::vector<Item> items, const ResultsName& name, const BatchArguments& options, Interrupt& interrupt) {
    BatchRun(std::move(items), name, options, interrupt).run();
}

}  // namespace lamella::cli::batch
