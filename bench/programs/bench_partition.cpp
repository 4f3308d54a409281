// Computes the speed-up that the partition into bands and shares allows on more threads than a machine has. The engine
// slices as for so many threads, but an executor runs all tasks on one thread, where their times are taken. A scheduler then
// hands them out as the engine does, on the machine that `--modelled` describes:
//
//     one thread    serial | measure 0 1 2 .. | serial | count 0 1 2 .. | serial | ...
//     T threads     serial | 0 2 4 ..  | serial | 0 2 ..  | ...
//                          | _ 1 3 ..  |        | _ 1 ..  |          _: woken later
#include <algorithm>
#include <bit>
#include <functional>
#include <limits>
#include <memory>
#include <numeric>
#include <queue>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/parallel.hpp"
#include "measure.hpp"
#include "slicing/slicer.hpp"

namespace lamella::bench {

namespace {

using Machine = decltype(Options::modelled);

/// One call of Parallel::run().
struct Run {
    int workers;
    double before;                ///< seconds of one thread since the run before
    std::vector<double> tasks{};  ///< seconds; where there is one worker, the last one counts to the next `before`
    std::string stage{};
    double bytes = 0;  ///< moved between memory and cores
    double fresh = 0;  ///< of pages that a first slice touches first

    std::size_t count() const noexcept { return tasks.size() + (workers == 1 ? 1 : 0); }
};

/// Takes the times of the tasks of slices. As an executor it calls one worker, which does them all; and Parallel reports the
/// progress of its stage whenever a task begins.
class Recorder {
public:
    static constexpr std::size_t most_runs = 1 << 16;  // of one stage

    void operator()(int workers, Callback<void()> body) noexcept {
        workers_ = workers;
        body();
        runs_.back().tasks.push_back(lap());
        workers_ = 1;
    }
    void operator()(double fraction) noexcept {
        constexpr double rounding = 1e-4;
        const double seconds = lap();
        const auto number = static_cast<std::uint64_t>(fraction * most_runs + rounding);
        if (std::exchange(number_, number) != number) {
            runs_.push_back({workers_, seconds});
        } else {
            runs_.back().tasks.push_back(seconds);
        }
    }

    template <class Work>
    std::vector<Run> runs_of(const Work& work) {
        runs_.clear();
        lap();
        work();
        runs_.push_back({1, lap()});
        return runs_;
    }

private:
    double lap() noexcept {
        const Clock::time_point now = Clock::now();
        return std::chrono::duration<double>(now - std::exchange(last_, now)).count();
    }

    std::vector<Run> runs_;
    Clock::time_point last_;
    std::uint64_t number_ = most_runs;  // none yet
    int workers_ = 1;
};

/// Three times, and for half a second.
template <class Work>
void repeat(const Work& work) {
    const Clock::time_point start = Clock::now();
    for (int i = 0; i < 3 || seconds_since(start) < 0.5; ++i) {
        work();
    }
}

/// The runs of a slice in their order: measure, count and sums over planes; for each tier scatter, seeds and sweep; layers
/// and contours.
void describe(std::vector<Run>& runs, const Prepared& of, const detail::SlicerImpl& kept) {
    std::size_t next = 0;
    const auto add = [&](const char* stage, std::uint64_t bytes, std::uint64_t fresh) {
        Run& run = runs[std::min(next++, runs.size() - 1)];  // one too many fails below
        run.stage = stage;
        run.bytes = static_cast<double>(bytes);
        run.fresh = static_cast<double>(fresh);
    };
    constexpr std::uint64_t triangle = 9 * sizeof(float);
    const Array<CrossedBlock>& blocks = kept.buckets.crossed;
    const auto is_read = [](const CrossedBlock& block) { return block.mask != 0; };
    add("measure", of.mesh->bytes(), 0);
    add("count",
        triangle * block_triangles * static_cast<std::uint64_t>(std::count_if(blocks.begin(), blocks.end(), is_read)), 0);
    add("count", 0, 0);
    add("count", 0, 0);
    for (const Tier& tier : kept.bands.tiers) {
        const std::uint64_t records = tier.records * sizeof(CrossedTriangle);
        const std::span<const Band> bands(kept.bands.bands.data() + tier.first_band, tier.last_band - tier.first_band);
        const auto add_up = [](std::uint64_t sum, const Band& band) { return sum + band.segments * sizeof(Point); };
        const std::uint64_t points = std::accumulate(bands.begin(), bands.end(), std::uint64_t{0}, add_up);
        add("scatter", tier.records * triangle + records, tier.planes.first == 0 ? records : 0);
        while (next < runs.size() && runs[next].count() != bands.size()) {
            add("scatter", 0, 0);
        }
        add("sweep", records + points, points);
    }
    const std::uint64_t made = of.info.layers * sizeof(Layer) + of.info.contours * sizeof(Contour);
    add("place", made + of.info.contours * sizeof(Contour), made);
    add("serial", 0, 0);
    if (next != runs.size()) {
        fail("a slice has other stages than the model: " + std::to_string(next) + " of " + std::to_string(runs.size()));
    }
}

/// The runs of a slice that is cut as for so many threads, with the least times of several slices.
std::vector<Run> record(Prepared& of, int threads) {
    Recorder recorder;
    const Context hooked{.threads = threads, .progress = recorder, .executor = recorder};
    const Context quiet{.threads = threads, .executor = recorder};  // the slice's own progress
    const auto slice_once = [&] {
        checked(slice_tuned(of.slicer, of.result, of.mesh->view(), of.plan.options, of.plan.tuning, quiet));
    };
    detail::SlicerImpl& kept = detail::SlicerImpl::of(of.slicer, hooked, of.plan.tuning);
    kept.parallel = std::make_unique<Parallel>(hooked);  // whose stage slices do not come to the end of
    kept.parallel->begin_stage(1, Recorder::most_runs);
    slice_once();  // warms; and of a stage's first run, not all is reported
    std::vector<Run> runs = recorder.runs_of(slice_once);
    repeat([&] {
        const std::vector<Run> again = recorder.runs_of(slice_once);
        for (std::size_t r = 0; r < runs.size(); ++r) {
            std::vector<double>& least = runs[r].tasks;
            runs[r].before = std::min(runs[r].before, again[r].before);
            std::transform(least.begin(), least.end(), again[r].tasks.begin(), least.begin(),
                           [](double a, double b) { return std::min(a, b); });
        }
    });
    describe(runs, of, kept);
    return runs;
}

/// Seconds until all tasks are done, each of which takes `stretch` times as long as measured. Free workers claim them in
/// ascending order, none further than `lead` beyond the first that is not done: LayerTarget::acquire().
double scheduled(const std::vector<double>& tasks, double stretch, int workers, std::size_t lead, double wake_s) {
    std::priority_queue<double, std::vector<double>, std::greater<>> free_at;
    for (unsigned worker = 0; worker < static_cast<unsigned>(workers); ++worker) {
        free_at.push(wake_s * (std::bit_width(worker + 1) - 1));  // each thread that is woken wakes two others
    }
    std::vector<double> all_done{0};  // by i: when the first i tasks are done
    for (std::size_t task = 0; task < tasks.size(); ++task) {
        const double start = std::max(free_at.top(), task > lead ? all_done[task - lead] : 0);
        free_at.pop();
        free_at.push(start + stretch * tasks[task]);
        all_done.push_back(std::max(all_done.back(), start + stretch * tasks[task]));
    }
    return all_done.back();
}

/// Seconds of each stage on at most so many threads of a machine, and of what one thread does between them.
Figures modelled(const std::vector<Run>& runs, const Machine& machine, int threads) {
    constexpr double giga = 1e9;
    const auto [most_gb_s, socket_gb_s, socket_cores, wake_us, fresh_gb_s] = machine;
    Figures times;
    for (const Run& run : runs) {
        const int workers = std::min(run.workers, threads);
        const double sum = std::accumulate(run.tasks.begin(), run.tasks.end(), 0.0);
        const double core_gb_s = std::min(most_gb_s, socket_gb_s / std::min<double>(workers, socket_cores));
        const double made = sum + run.fresh / fresh_gb_s / giga;
        const double moved = (run.bytes + run.fresh) / core_gb_s / giga;
        const std::size_t lead = run.stage == "sweep" ? 2 * static_cast<std::size_t>(run.workers) : run.tasks.size();
        times["serial"] += run.before;
        times[run.stage] += sum > 0 ? scheduled(run.tasks, std::max(made, moved) / sum, workers, lead, wake_us / 1e6) : 0;
    }
    return times;
}

double total(const Figures& times) {
    return std::accumulate(times.begin(), times.end(), 0.0, [](double sum, const auto& own) { return sum + own.second; });
}

Figures run_partition(Prepared& of, const Machine& machine) {
    constexpr int most_threads = 128;
    constexpr Machine free{1e9, 1e9, 1, 0, 1e9};
    double slice_s = std::numeric_limits<double>::infinity();
    repeat([&] { slice_s = std::min(slice_s, seconds_of([&] { of.slice(1); })); });
    const std::vector<Run> two = record(of, 2);
    const Figures alone = modelled(two, free, 1);
    // What the machine adds is known by stage for more than one thread.
    const double one_s = total(modelled(record(of, 1), free, 1)) + total(modelled(two, machine, 1)) - total(alone);
    Figures figures{{"accounted_for", total(alone) / slice_s}, {"serial_share", alone.at("serial") / total(alone)}};
    for (int threads = 2; threads <= most_threads; threads *= 2) {
        of.check(threads);
        const Figures times = modelled(threads == 2 ? two : record(of, threads), machine, threads);
        const std::string end = "_" + std::to_string(threads);
        figures["speedup" + end] = one_s / total(times);
        for (const auto& [stage, seconds] : times) {
            figures[stage + end] = 1e6 * seconds;
        }
    }
    return figures;
}

}  // namespace

void add_partition(const Options& options, const Case& wanted) {
    add_benchmark(options, "partition/" + wanted.name + "/modelled", 1,
                  [=](benchmark::State&) { return run_partition(prepared(wanted), options.modelled); });
}

}  // namespace lamella::bench
