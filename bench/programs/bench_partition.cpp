// Computes the speed-up that the partition into bands and parts allows on more threads than a machine may have. Every band,
// cut as for so many threads, is timed alone on one thread, and so are parts of the other stages.
//
// Free threads claim bands in ascending order. No thread runs further ahead of the first unfinished band than placement
// allows (engine/slicing/result/layer_target.hpp). Every other stage takes as long as its slowest part. Work of one thread
// is added in full. The model assumes that a core, with its memory, is as fast among many as alone.
#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <queue>
#include <vector>

#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "measure.hpp"
#include "slicing/bands/bands.hpp"
#include "slicing/buckets/mesh_source.hpp"
#include "slicing/buckets/triangle_source.hpp"
#include "slicing/planes/plane_set.hpp"
#include "slicing/slice_layers.hpp"
#include "slicing/sweep/band_sweep.hpp"

namespace lamella::bench {

namespace {

constexpr int most_threads = 128;

constexpr int repetitions = 3;  // of which the least counts

template <class Work>
double least_of(const Work& work) {
    double least = seconds_of(work);
    for (int i = 1; i < repetitions; ++i) {
        least = std::min(least, seconds_of(work));
    }
    return least;
}

/// The stages of slice() on one thread, callable one by one, with the memory that they reuse.
class Stages {
public:
    Stages(const MeshView& mesh, const Plan& plan) : plan_(plan) {
        narrow_to(mesh);
        const Status begun = guarded([&]() -> Status {
            frame_ = choose_frame(source_->measure(0), source_->info.number, {}, {});
            plan_planes();
            return {};
        });
        if (!begun) {
            fail(begun.error().message);
        }
    }

    void plan_planes() {
        planes_.build(plan_.options, plan_.tuning.random_heights, frame_, std::numeric_limits<std::uint64_t>::max());
    }
    void count() { source_->count(frame_.unit.mm); }
    /// Cuts bands as for this number of threads. scatter() and find_seeds() must follow.
    void cut_bands_for(int threads) { bands_.cut(buckets_, planes_.size(), 0, threads); }
    void scatter() { reaching_ = source_->scatter(bands_.band_end, bands_.reaching.span(), false); }
    /// Once after scatter(): may release the notes that it made.
    void find_seeds() { bands_.find_seeds(planes_.size(), reaching_, {}); }
    void sweep(const Band& band) {
        output_.begin({output_.buffer.data(), output_.buffer.capacity()});
        const auto number = static_cast<std::size_t>(&band - bands_.bands.data());
        (void)sweep_.run(band, bands_.seeds_of(number), buckets_, planes_, ContourForm::swept, {}, output_);
    }

    /// Makes look_at_bounds(), count(), cut_bands_for() and scatter() use `part` only, on the planes of the whole mesh.
    void narrow_to(const MeshView& part) {
        source_.emplace(part, Placing{}, nullptr, SourceTools{parallel_, planes_, buckets_});
    }
    /// The first read, of which only the table of blocks is kept.
    void look_at_bounds() { (void)source_->measure(0); }

    const auto& bands() const noexcept { return bands_.bands; }

private:
    Plan plan_;
    Parallel parallel_{Context{.threads = 1}};
    SharedFrame frame_{};
    PlaneSet planes_{nullptr};
    Buckets buckets_{nullptr};
    std::optional<SoupSource> source_;
    BandPlan bands_{nullptr};
    std::size_t reaching_ = 0;  // entries of bands_.reaching
    BandSweep sweep_{nullptr};
    BandOutput output_{nullptr};
};

/// Seconds of bounds, count and scatter for the `part`-th of `parts` equal ranges of triangles.
std::array<double, 3> time_part(const Prepared& of, std::size_t part, std::size_t parts) {
    const std::size_t all = of.mesh->triangles();
    const std::size_t begin = all * part / parts;
    const std::size_t end = std::max(begin + 1, all * (part + 1) / parts);
    Stages stages(of.mesh->view(), of.plan);
    stages.narrow_to(MeshView::soup(of.mesh->soup.span().subspan(9 * begin, 9 * (end - begin))));
    std::array<double, 3> least;
    least.fill(std::numeric_limits<double>::infinity());
    for (int i = 0; i < repetitions; ++i) {
        least[0] = std::min(least[0], seconds_of([&] { stages.look_at_bounds(); }));
        least[1] = std::min(least[1], seconds_of([&] { stages.count(); }));
        stages.cut_bands_for(1);
        least[2] = std::min(least[2], seconds_of([&] { stages.scatter(); }));
    }
    return least;
}

/// Seconds of all bands on so many threads.
double scheduled(const std::vector<double>& bands, std::size_t threads) {
    constexpr std::size_t lead_per_thread = 2;  // bands; Placement::begin()
    std::priority_queue<double, std::vector<double>, std::greater<>> free_at(std::greater<>(),
                                                                             std::vector<double>(threads, 0.0));
    std::vector<double> all_done{0};  // by b: when the first b bands are done
    for (std::size_t band = 0; band < bands.size(); ++band) {
        const std::size_t lead = lead_per_thread * threads;
        const double start = std::max(free_at.top(), band > lead ? all_done[band - lead] : 0);
        free_at.pop();
        free_at.push(start + bands[band]);
        all_done.push_back(std::max(all_done.back(), start + bands[band]));
    }
    return all_done.back();
}

/// The slowest of the parts by stage, summed up. Parts differ only in how many of their triangles are crossed. Four
/// represent all: the first, the last and two between.
double time_parts(const Prepared& of, std::size_t parts) {
    std::array<double, 3> slowest{};
    for (const std::size_t part : std::set<std::size_t>{0, parts / 3, parts * 2 / 3, parts - 1}) {
        const std::array<double, 3> stages = time_part(of, part, parts);
        for (std::size_t i = 0; i < slowest.size(); ++i) {
            slowest[i] = std::max(slowest[i], stages[i]);
        }
    }
    return slowest[0] + slowest[1] + slowest[2];
}

/// Seconds that the stages take on so many threads.
double allowed_seconds(const Prepared& of, Stages& stages, int threads, double serial_per_part) {
    const double copied_per_s = copy_bandwidth(1);
    double seconds = std::numeric_limits<double>::infinity();
    for (int i = 0; i < repetitions; ++i) {
        stages.count();
        const double cut = seconds_of([&] { stages.cut_bands_for(threads); });
        stages.scatter();
        seconds = std::min(seconds, cut + seconds_of([&] { stages.find_seeds(); }));
    }
    std::vector<double> bands;
    bands.reserve(stages.bands().size());
    for (const Band& band : stages.bands()) {
        // Every band but the first unfinished one goes through a buffer.
        const double moved = threads > 1 ? 2.0 * sizeof(Point) * static_cast<double>(band.segments) : 0;
        bands.push_back(least_of([&] { stages.sweep(band); }) + moved / copied_per_s);
    }
    seconds += scheduled(bands, static_cast<std::size_t>(threads));
    seconds += least_of([&] { stages.plan_planes(); });
    seconds += time_parts(of, static_cast<std::size_t>(threads)) + (threads - 1) * serial_per_part;
    // All threads place the contours, then one counts them.
    const double contours = 2 * sizeof(Contour) * static_cast<double>(of.info.contours) / copied_per_s;
    return seconds + contours / threads + contours / 2;
}

void run_partition(benchmark::State& state, Prepared& of) {
    Stages stages(of.mesh->view(), of.plan);
    const double serial_per_part = time_part(of, 0, of.mesh->triangles())[1];
    const double alone = allowed_seconds(of, stages, 1, 0);
    Figures figures{{"accounted_for", alone / least_of([&] { of.slice(1); })}};
    for (int threads = 1; threads <= most_threads; threads *= 2) {
        figures["speedup_" + std::to_string(threads)] =
            threads == 1 ? 1 : alone / allowed_seconds(of, stages, threads, serial_per_part);
    }
    report(state, figures);
}

}  // namespace

void add_partition(const Options& options, const Case& wanted) {
    add_benchmark("partition/" + wanted.name + "/allowed", 1, options, [=](benchmark::State& state) {
        run_partition(state, prepared(wanted));
    })->Repetitions(1);
}

}  // namespace lamella::bench
