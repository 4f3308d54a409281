// Placement of bands in the result, in whatever order they finish.
#include <random>
#include <utility>

#include <catch2/catch.hpp>

#include "base/parallel.hpp"
#include "engine/rounds.hpp"
#include "slicing/result/layer_target.hpp"

using namespace lamella;

TEST_CASE("bands with more or fewer points than segments are placed in order", "[engine][placement][threads]") {
    // Mostly as many points as segments; else one fewer (repeats) or a few more (open polylines, points of a fill rule).
    const auto seed = GENERATE(range(1U, 1 + rounds(399)));
    std::mt19937 random(seed);
    const auto draw = [&](std::uint32_t below) { return static_cast<std::uint32_t>(random() % below); };
    const bool outgrow = draw(2) == 0;
    const bool with_origins = draw(2) == 0;
    std::vector<Band> bands;
    std::vector<std::uint32_t> counts;
    std::vector<Point> expected;
    std::uint64_t segments = 0;
    for (std::uint32_t b = 0; b < 24; ++b) {
        bands.push_back({b, b + 1, 1 + draw(24), false});
        segments += bands[b].segments;
        const auto usual = static_cast<std::uint32_t>(bands[b].segments);
        const std::uint32_t kind = draw(8);
        counts.push_back(kind == 0 ? usual - 1 : (kind == 1 && outgrow ? usual + 1 + draw(5) : usual));
        for (std::uint32_t c = 0; c < counts[b]; ++c) {
            expected.push_back({static_cast<std::int32_t>(b), static_cast<std::int32_t>(c)});
        }
    }
    // Often too little room, since a result has 64 points more than segments are expected: what it does not hold is kept
    // until all is done.
    constexpr std::size_t threads = 3;
    const Parallel parallel({.threads = threads});
    OutputScratch scratch(nullptr);
    SliceResult result;
    const auto layer_at = [](PlaneIndex) { return Layer{}; };
    const OutputPlan plan{.layers = static_cast<PlaneIndex>(bands.size()),
                          .layer_at = layer_at,
                          .segments = draw(2) == 0 ? segments : 1 + draw(static_cast<std::uint32_t>(segments) / 2),
                          .cutting = 0,
                          .bands = bands,
                          .parallel = parallel,
                          .scratch = scratch,
                          .origins = with_origins,
                          .info = result.info};
    ResultTarget placement(result);
    placement.begin(plan);

    // One interleaving of `threads` threads. A step begins the next band, reserves space for a point, writes it, or
    // submits.
    struct Begun {
        std::size_t band;
        BandOutput* output;
        std::uint32_t written = 0;
        Point* room = nullptr;
    };
    std::vector<Begun> begun;
    std::size_t next = 0;
    std::size_t first_unfinished = 0;
    std::vector<bool> done(bands.size(), false);
    while (first_unfinished < bands.size()) {
        const bool may_begin = next < bands.size() && begun.size() < threads && next <= first_unfinished + 2;
        if (begun.empty() || (may_begin && draw(3) == 0)) {
            begun.push_back({next, placement.acquire(next)});
            ++next;
            continue;
        }
        const std::size_t chosen = draw(static_cast<std::uint32_t>(begun.size()));
        Begun& band = begun[chosen];
        if (band.written < counts[band.band]) {
            if (band.room == nullptr) {
                band.room = band.output->reserve_points(1);
                continue;
            }
            if (with_origins) {
                band.output->origins[band.output->point_count] = {band.written, static_cast<std::uint16_t>(band.band)};
            }
            *std::exchange(band.room, nullptr) = {static_cast<std::int32_t>(band.band),
                                                  static_cast<std::int32_t>(band.written++)};
            ++band.output->point_count;
            continue;
        }
        band.output->layer_contours.push_back(0);
        placement.submit(band.band);
        done[band.band] = true;
        begun.erase(begun.begin() + static_cast<std::ptrdiff_t>(chosen));
        while (first_unfinished < bands.size() && done[first_unfinished]) {
            ++first_unfinished;
        }
    }
    placement.finish();
    REQUIRE(result.info.points == expected.size());
    CHECK(std::vector<Point>(result.points.begin(), result.points.end()) == expected);
    REQUIRE(result.origins.size() == (with_origins ? expected.size() : 0));
    for (std::size_t i = 0; i < expected.size() && with_origins; ++i) {
        CHECK(result.origins[i] ==
              PointOrigin{static_cast<std::uint32_t>(expected[i].y), static_cast<std::uint16_t>(expected[i].x)});
    }
}
