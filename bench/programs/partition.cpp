// Times every band and every part of the other stages, alone on one thread, as the engine divides them for 1 to 128
// threads. Prints the times as JSON; scripts/partition.py makes schedules from them.
#include <algorithm>
#include <cstddef>
#include <iostream>
#include <limits>
#include <optional>
#include <vector>

#include <nlohmann/json.hpp>

#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "catalogue.hpp"
#include "prepared.hpp"
#include "slicing/bands/bands.hpp"
#include "slicing/buckets/mesh_source.hpp"
#include "slicing/buckets/triangle_source.hpp"
#include "slicing/planes/plane_set.hpp"
#include "slicing/slice_layers.hpp"
#include "slicing/sweep/band_sweep.hpp"
#include "timing.hpp"

namespace lamella::bench {

namespace {

using Json = nlohmann::ordered_json;

constexpr int repetitions = 3;

/// The stages of slice() on one thread, callable one by one, with the memory that they reuse.
class Stages {
public:
    Stages(const MeshView& mesh, const Plan& plan) : plan_(plan) { narrow_to(mesh); }

    /// Finds box, unit and planes.
    Status begin() {
        return guarded([&]() -> Status {
            frame_ = choose_frame(source_->measure(0), source_->info.number, {}, {});
            plan_planes();
            return {};
        });
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
    void sweep_band(std::size_t band) {
        output_.begin({output_.buffer.data(), output_.buffer.capacity()});
        (void)sweep_.run(bands_.bands[band], bands_.seeds_of(band), buckets_, planes_, ContourForm::swept, {}, output_);
    }

    /// Makes look_at_bounds(), count(), cut_bands_for() and scatter() use `part` only, on the planes of the whole mesh.
    void narrow_to(const MeshView& part) {
        source_.emplace(part, Placing{}, nullptr, SourceTools{parallel_, planes_, buckets_});
    }
    /// The first read, of which only the table of blocks is kept.
    void look_at_bounds() { (void)source_->measure(0); }

    const PlaneSet& planes() const noexcept { return planes_; }
    const BandPlan& bands() const noexcept { return bands_; }

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

void keep_least(double& least, double value) {
    least = least == 0 ? value : std::min(least, value);
}

/// Times bounds, count and scatter for the `part`-th of `parts` equal ranges of triangles.
Json time_part(const Prepared& prepared, std::size_t part, std::size_t parts) {
    const std::size_t all = prepared.mesh().triangles();
    const std::size_t begin = all * part / parts;
    const std::size_t end = std::max(begin + 1, all * (part + 1) / parts);
    const float* first = prepared.mesh().soup.data() + 9 * begin;
    Stages whole(prepared.mesh().view(), prepared.plan());
    double bounds = 0;
    double count = 0;
    double scatter = 0;
    // The planes are those of the whole mesh, so they are made before the view is narrowed to a part.
    if (!whole.begin()) {
        return {};
    }
    whole.narrow_to(MeshView::soup(std::span<const float>(first, 9 * (end - begin))));
    for (int i = 0; i < repetitions; ++i) {
        keep_least(bounds, seconds_of([&] { whole.look_at_bounds(); }));
        keep_least(count, seconds_of([&] { whole.count(); }));
        whole.cut_bands_for(1);
        keep_least(scatter, seconds_of([&] { whole.scatter(); }));
    }
    return {{"bounds", bounds}, {"count", count}, {"scatter", scatter}};
}

/// Times every band alone.
std::vector<double> time_bands(Stages& stages) {
    std::vector<double> least(stages.bands().bands.size(), 0);
    for (int i = 0; i < repetitions; ++i) {
        for (std::size_t band = 0; band < least.size(); ++band) {
            keep_least(least[band], seconds_of([&] { stages.sweep_band(band); }));
        }
    }
    return least;
}

Json time_partition(const Prepared& prepared, Stages& stages, int threads) {
    double plan_bands = 0;
    for (int i = 0; i < repetitions; ++i) {
        stages.count();
        const double cut = seconds_of([&] { stages.cut_bands_for(threads); });
        stages.scatter();
        keep_least(plan_bands, cut + seconds_of([&] { stages.find_seeds(); }));
    }
    Json json{{"threads", threads}, {"plan_bands", plan_bands}, {"bands", time_bands(stages)}};
    std::vector<std::uint64_t> segments;
    for (const Band& band : stages.bands().bands) {
        segments.push_back(band.segments);
    }
    json["band_segments"] = segments;
    // Parts differ only in how many of their triangles are crossed. Four represent all: the first, the last and two
    // between.
    const auto parts = static_cast<std::size_t>(threads);
    std::vector<std::size_t> sampled{0, parts / 3, parts * 2 / 3, parts - 1};
    sampled.erase(std::unique(sampled.begin(), sampled.end()), sampled.end());
    for (const std::size_t part : sampled) {
        json["parts"].push_back(time_part(prepared, part, parts));
    }
    return json;
}

Json time_case(Prepared& prepared) {
    Stages stages(prepared.mesh().view(), prepared.plan());
    if (!stages.begin()) {
        return {};
    }
    Json json{{"triangles", prepared.mesh().triangles()},
              {"planes", stages.planes().size()},
              {"segments", prepared.info().segments},
              {"contours", prepared.info().contours},
              {"copy_bytes_per_s", copy_bandwidth(1)}};
    double planes = 0;
    double end_to_end = 0;
    for (int i = 0; i < repetitions; ++i) {
        keep_least(planes, seconds_of([&] { stages.plan_planes(); }));
        keep_least(end_to_end, seconds_of([&] { prepared.slice(1); }));
    }
    json["plan_planes"] = planes;
    json["end_to_end_1_thread"] = end_to_end;
    json["serial_per_part"] = time_part(prepared, 0, prepared.mesh().triangles())["count"];
    for (int threads = 1; threads <= 128; threads *= 2) {
        json["partitions"].push_back(time_partition(prepared, stages, threads));
    }
    return json;
}

bool is_wanted(const Case& each) {
    return each.measured.partition || each.name.find("_planes") != std::string::npos;
}

void run(const std::vector<std::string>& words) {
    Options options;
    for (const std::string& word : words) {
        if (!take_option(word, options)) {
            fail("unknown option " + word);
        }
    }
    if (options.quick) {
        set_copy_size(std::size_t{16} << 20);
    }
    Preparer preparer;
    Json all;
    for (const Case& each : make_catalogue(options)) {
        if (is_wanted(each)) {
            std::cerr << each.name << '\n';
            all[each.name] = time_case(preparer.get(each));
        }
    }
    std::cout << all.dump(1) << '\n';
}

}  // namespace

}  // namespace lamella::bench

int main(int count, char** words) {
    return lamella::bench::run_program(count, words, 0, 4, "[--cache=DIR] [--shared=DIR] [--quick] [--max-threads=N]",
                                       lamella::bench::run);
}
