// Bounds, planes, counting and scattering alone: vector code and tables must find what a loop over triangles and planes
// finds.
#include <algorithm>
#include <cstring>
#include <limits>
#include <numeric>
#include <optional>
#include <random>
#include <tuple>
#include <vector>

#include <catch2/catch.hpp>

#include "base/guard.hpp"
#include "engine/slicing.hpp"
#include "slicing/bands/bands.hpp"
#include "slicing/buckets/mesh_source.hpp"
#include "slicing/grid/bounds.hpp"

using lamella::BandPlan;
using lamella::Buckets;
using lamella::MeshView;
using lamella::PlaneIndex;
using lamella::PlaneSet;

namespace {

constexpr std::uint64_t no_limit = std::numeric_limits<std::uint64_t>::max();

/// Triangles of height up to `rise` and width up to `width`. Some are degenerate, some level.
std::vector<float> random_soup(std::size_t triangles, float rise, float width, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> place(-20, 20);
    std::uniform_real_distribution<float> part(0, 1);
    std::vector<float> soup;
    for (std::size_t t = 0; t < triangles; ++t) {
        const float at[3] = {place(random), place(random), place(random)};
        for (int i = 0; i < 9; ++i) {
            soup.push_back(at[i % 3] + part(random) * (i % 3 == 2 ? rise : width));
        }
        float* v = soup.data() + 9 * t;
        if (t % 17 == 3) {
            std::copy_n(v, 3, v + 6);
        } else if (t % 11 == 5) {
            v[5] = v[2];
        }
    }
    return soup;
}

/// With all heights brought to under `height`.
std::vector<float> flattened(std::vector<float> soup, float height) {
    for (std::size_t i = 2; i < soup.size(); i += 3) {
        soup[i] = std::abs(std::remainder(soup[i], height));
    }
    return soup;
}

/// Where planes lie.
struct Plan {
    lamella::SliceOptions options;
    std::optional<lamella::RandomHeights> random{};

    void build(PlaneSet& planes, const lamella::Bounds& box, double unit_mm, lamella::Number number) const {
        planes.build(options, random, {box, {unit_mm, 0}, number}, no_limit);
    }
};

Plan uniform_plan(double height_mm) {
    return {{.layer_height_mm = height_mm}};
}

Plan random_plan(double least_mm, double most_mm) {
    return {{}, lamella::RandomHeights{least_mm, most_mm}};
}

/// A few planes far apart and many close together, so that some cells of the table hold a hundred.
Plan crowded_plan() {
    std::vector<double> heights_mm = {-30, -19.5, -3};
    for (int i = 0; i < 200; ++i) {
        heights_mm.push_back(1 + i * 0x1p-16);
    }
    heights_mm.insert(heights_mm.end(), {7.5, 19, 40});
    return {{.heights_mm = heights_mm}};
}

/// The results of bounds, planes, counting, bands and scattering.
struct Bucketed {
    PlaneSet planes{nullptr};
    Buckets buckets{nullptr};
    BandPlan bands{nullptr};

    Bucketed(const MeshView& mesh, const Plan& plan, double unit_mm, int threads, int band_planes) {
        const lamella::Parallel parallel({.threads = threads});
        lamella::SoupSource source(mesh, {}, nullptr, {parallel, planes, buckets});
        plan.build(planes, source.measure(unit_mm), unit_mm, mesh.vertex_type);
        source.count(unit_mm);
        bands.cut(buckets, planes.size(), band_planes, threads);
        const std::size_t reaching = source.scatter(bands.band_end, bands.reaching.span(), false);
        bands.find_seeds(planes.size(), reaching, {});
    }

    using Row =
        std::tuple<std::uint32_t, lamella::GridVertex, lamella::GridVertex, lamella::GridVertex, std::uint32_t, PlaneIndex>;
    /// The list of each plane, in the order of the input.
    std::vector<std::vector<Row>> lists() const {
        std::vector<std::vector<Row>> all(planes.size());
        for (PlaneIndex plane = 0; plane < planes.size(); ++plane) {
            for (std::uint32_t r = buckets.list_begin[plane]; r < buckets.list_begin[plane + 1]; ++r) {
                const lamella::CrossedTriangle& t = buckets.records[r];
                all[plane].push_back({t.triangle, t.lower, t.middle, t.upper, t.middle_and_source, t.last});
            }
            std::sort(all[plane].begin(), all[plane].end());
        }
        return all;
    }
};

/// Compares the result with the definitions, plane by plane.
void check_by_definition(const Bucketed& found, const MeshView& mesh, double unit_mm) {
    const lamella::GeneralReader read(mesh, {}, unit_mm);
    std::uint64_t degenerate = 0;
    std::uint64_t segments = 0;
    std::vector<std::uint32_t> list_size(found.planes.size());
    for (std::size_t t = 0; t < mesh.triangle_count; ++t) {
        const lamella::GridTriangle v = read(t);
        if (lamella::is_degenerate(v)) {
            ++degenerate;
            continue;
        }
        const auto [low, high] = std::minmax({v[0].z, v[1].z, v[2].z});
        bool is_first = true;
        for (PlaneIndex plane = 0; plane < found.planes.size(); ++plane) {
            if (low < found.planes.z(plane) && found.planes.z(plane) < high) {
                list_size[plane] += is_first ? 1U : 0U;
                is_first = false;
                ++segments;
            }
        }
    }
    CHECK(found.buckets.degenerate == degenerate);
    CHECK(found.buckets.segment_count == segments);
    const auto lists = found.lists();
    for (PlaneIndex plane = 0; plane < found.planes.size(); ++plane) {
        CHECK(lists[plane].size() == list_size[plane]);
    }
}

}  // namespace

TEST_CASE("boxes of blocks of a float soup are those of the same numbers as doubles", "[engine][bucket]") {
    const lamella::Parallel parallel({.threads = 2});
    for (const std::size_t triangles : {1U, 15U, 64U, 65U, 200U, 1000U}) {
        const std::vector<float> soup = random_soup(triangles, 0.1F, 0.1F, 3);
        const std::vector<double> doubles(soup.begin(), soup.end());
        for (const std::size_t stride : {36U, 50U}) {
            std::vector<std::byte> bytes(triangles * stride - (stride - 36));  // no spare bytes after the last triangle
            for (std::size_t t = 0; t < triangles; ++t) {
                std::memcpy(bytes.data() + t * stride, soup.data() + 9 * t, 36);
            }
            const MeshView floats{.vertices = bytes.data(), .triangle_count = triangles, .vertex_stride = stride};
            for (const double unit_mm : {0x1p-20, 0.005}) {
                lamella::BlockTable found(nullptr);
                lamella::BlockTable expected(nullptr);
                const lamella::Bounds box = lamella::require(measure_bounds(floats, {}, unit_mm, parallel, found));
                const lamella::Bounds other =
                    lamella::require(measure_bounds(MeshView::soup(doubles), {}, unit_mm, parallel, expected));
                CHECK(std::equal(box.min_mm, box.min_mm + 3, other.min_mm));
                CHECK(std::equal(box.max_mm, box.max_mm + 3, other.max_mm));
                REQUIRE(found.blocks.size() == lamella::block_count(triangles));
                for (std::size_t b = 0; b < found.blocks.size(); ++b) {
                    CHECK(found.blocks[b].low_mm == expected.blocks[b].low_mm);
                    CHECK(found.blocks[b].high_mm == expected.blocks[b].high_mm);
                    CHECK(found.blocks[b].near == expected.blocks[b].near);
                }
            }
        }
    }
}

TEST_CASE("the table finds the first plane above a vertex", "[engine][bucket][planes]") {
    const lamella::Bounds bounds{{-20, -20, -20}, {20, 20, 20}};
    for (const Plan& plan : {uniform_plan(0.25), uniform_plan(0x1p-18), random_plan(0.01, 0.03), crowded_plan()}) {
        const bool fine = plan.options.layer_height_mm < 0.001;
        const lamella::Bounds box = fine ? lamella::Bounds{{0, 0, 0}, {1, 1, 0x1p-8}} : bounds;
        PlaneSet planes(nullptr);
        plan.build(planes, box, lamella::default_grid_mm, lamella::Number::f32);
        REQUIRE(planes.size() > 100);
        const auto check = [&](std::int32_t z) {
            const std::int32_t* end = planes.heights() + planes.size();
            const auto expected = static_cast<PlaneIndex>(std::upper_bound(planes.heights(), end, z) - planes.heights());
            CHECK(planes.by_table(z) == expected);
            CHECK(planes.first_above(z) == expected);
        };
        for (PlaneIndex plane = 0; plane < planes.size(); ++plane) {
            check(planes.z(plane) - 1);
            check(planes.z(plane) + 1);
        }
        check(-lamella::grid_limit);
        check(lamella::grid_limit);
    }
}

TEST_CASE("buckets hold the crossed triangles for every kind of input and thread count", "[engine][bucket]") {
    const double unit_mm = lamella::default_grid_mm;
    struct Sample {
        const char* name;
        Plan plan;
        std::vector<float> soup;
    };
    // The last: some two hundred planes 4 units apart, each of which rounding moves by a large part of a step.
    const Sample samples[] = {{"uniform", uniform_plan(0.5), random_soup(1000, 1.5F, 1, 5)},
                              {"most lie between planes", uniform_plan(3), random_soup(1000, 0.05F, 1, 5)},
                              {"irregular", random_plan(0.1, 0.5), random_soup(1000, 1, 1, 5)},
                              {"crowded", crowded_plan(), random_soup(1000, 2, 1, 5)},
                              {"fine", uniform_plan(4.5 * unit_mm), flattened(random_soup(500, 0x1p-12F, 1, 9), 0x1p-10F)}};
    for (const Sample& sample : samples) {
        INFO(sample.name);
        const std::vector<float>& soup = sample.soup;
        const MeshView view = MeshView::soup(soup);
        const Bucketed found(view, sample.plan, unit_mm, 1, 3);
        check_by_definition(found, view, unit_mm);
        const std::vector<double> wide(soup.begin(), soup.end());
        std::vector<std::uint32_t> corners(soup.size() / 3);
        std::iota(corners.begin(), corners.end(), 0U);
        const auto lists = found.lists();
        // Indexed input, then two threads.
        CHECK(Bucketed(MeshView::indexed(soup, corners), sample.plan, unit_mm, 1, 3).lists() == lists);
        CHECK(Bucketed(view, sample.plan, unit_mm, 2, 3).lists() == lists);
        // Planes for doubles are placed with double precision, so they may lie one unit elsewhere.
        check_by_definition(Bucketed(MeshView::soup(wide), sample.plan, unit_mm, 1, 3), MeshView::soup(wide), unit_mm);
    }
}

TEST_CASE("seeds of a band are the triangles from below that its first plane cuts", "[engine][bucket]") {
    const std::vector<float> soup = random_soup(700, 6, 1, 11);
    const MeshView view = MeshView::soup(soup);
    for (const int band_planes : {1, 4}) {
        for (const int threads : {1, 3}) {
            const Bucketed found(view, uniform_plan(0.5), lamella::default_grid_mm, threads, band_planes);
            REQUIRE(found.bands.bands.size() > 5);
            for (std::size_t b = 0; b < found.bands.bands.size(); ++b) {
                const PlaneIndex first = found.bands.bands[b].first;
                std::vector<std::uint32_t> expected;
                for (std::uint32_t r = 0; r < found.buckets.list_begin[first]; ++r) {
                    if (found.buckets.records[r].last > first) {
                        expected.push_back(r);
                    }
                }
                const auto seeds = found.bands.seeds_of(b);
                std::vector<std::uint32_t> sorted(seeds.begin(), seeds.end());
                std::sort(sorted.begin(), sorted.end());
                CHECK(sorted == expected);
            }
        }
    }
}

TEST_CASE("bands hold no more segments than asked for, unless seeds would outnumber the triangles", "[engine][bucket]") {
    // Few triangles, each cut by all planes: from every band on to the next they are seeds.
    const shapes::Soup tall = shapes::prism(64, 10, 20);
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 4);
    for (const shapes::Soup& soup : {tall, ball}) {
        const Bucketed found(view_of(soup), uniform_plan(0.01), 0x1p-20, 2, 0);
        BandPlan bands{nullptr};
        for (const std::uint64_t most : {std::uint64_t{1}, std::uint64_t{500}, std::uint64_t{5000}, no_limit}) {
            bands.cut(found.buckets, found.planes.size(), 0, 1, most);
            PlaneIndex next = 0;
            for (const lamella::Band& band : bands.bands) {
                CHECK(band.first == next);
                CHECK((band.last == band.first + 1 || band.segments <= most));
                next = band.last;
            }
            CHECK(next == found.planes.size());
        }
        CHECK(bands.bands.size() <= found.bands.bands.size());
    }
    // Of triangles that all planes cut, bands of one plane would have 63 times as many seeds: more than 2^21.
    Buckets counted{nullptr};
    constexpr PlaneIndex planes = 64;
    constexpr std::uint32_t cut = 100'000;
    counted.segments.resize_discarding(planes);
    std::fill(counted.segments.begin(), counted.segments.end(), cut);
    counted.list_begin.resize_discarding(planes + 1);
    std::fill(counted.list_begin.begin(), counted.list_begin.end(), cut);
    counted.list_begin[0] = 0;
    counted.segment_count = std::uint64_t{cut} * planes;
    BandPlan bands{nullptr};
    bands.cut(counted, planes, 0, 1, cut);
    REQUIRE(bands.bands.size() > 1);
    CHECK((bands.bands.size() - 1) * cut <= std::size_t{1} << 21);
    CHECK((2 * bands.bands.size() - 1) * cut > std::size_t{1} << 21);
}

TEST_CASE("a band ends above a wide base, and not where a few edges end", "[engine][bucket]") {
    constexpr PlaneIndex planes = 60'000;
    Buckets counted{nullptr};
    counted.segments.resize_discarding(planes);
    counted.list_begin.resize_discarding(planes + 1);
    for (const std::uint32_t base : {40'000U, 400U}) {
        std::fill(counted.segments.begin(), counted.segments.end(), 10U);
        std::fill_n(counted.segments.begin(), 3, base);
        std::fill(counted.list_begin.begin(), counted.list_begin.end(), base);
        counted.list_begin[0] = 0;
        counted.segment_count = 3 * base + 10 * (planes - 3);
        BandPlan bands{nullptr};
        bands.cut(counted, planes, 0, 1);
        REQUIRE(bands.bands.size() > 2);
        CHECK((bands.bands[1].last < 10) == (base > 1000));
    }
}

TEST_CASE("degenerate triangles that no plane cuts are counted", "[engine][bucket]") {
    // All but one triangle lie below the only plane. In every tenth, two vertices are equal on a grid of 1 mm, but not on
    // a finer one.
    std::vector<float> soup;
    for (int t = 0; t < 640; ++t) {
        const auto x = static_cast<float>(4 * t);
        const float width = t % 10 == 0 ? 0.5F : 8.0F;
        soup.insert(soup.end(), {x, 0, 0, x + width, 0, 0, x, 8, t == 77 ? 200.0F : 2.0F});
    }
    lamella::SliceOptions options = uniform(200, 1.0);
    CHECK(sliced(MeshView::soup(soup), options).info.degenerate == 64);
    options.frame.grid_mm = lamella::default_grid_mm * 4;
    CHECK(sliced(MeshView::soup(soup), options).info.degenerate == 0);
}

TEST_CASE("a grid coarser than requested makes more triangles degenerate", "[engine][bucket]") {
    // Beyond 1,024 mm the default unit doubles, but the blocks were measured for the smaller unit.
    const float far = 500'000;
    std::vector<float> soup{0, 0, 0, far, 0, 0, 0, far, far};
    for (int t = 0; t < 100; ++t) {
        const auto z = static_cast<float>(t);
        soup.insert(soup.end(), {1, 2, z, 1 + 0x1p-13F, 2, z, 100, 100, z + 1});
    }
    CHECK(sliced(MeshView::soup(soup), uniform(1000)).info.degenerate == 100);
}
