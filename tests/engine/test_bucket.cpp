// Bounds, planes, counting, scattering and bands: vector code and tables must find what a loop over triangles and planes
// finds, and all of it must hold for very many triangles.
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <tuple>

#include "engine/counting_memory.hpp"
#include "engine/slicing.hpp"
#include "oracle/compare.hpp"
#include "slicing/bands/bands.hpp"
#include "slicing/buckets/triangle_source.hpp"
#include "slicing/planes/plane_set.hpp"

using namespace lamella;

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
    SliceOptions options;
    std::optional<RandomHeights> random{};
};

/// A few planes far apart and many close together, so that some cells of the table hold a hundred.
Plan crowded_plan() {
    std::vector<double> heights_mm = {-30, -19.5, -3};
    for (int i = 0; i < 200; ++i) {
        heights_mm.push_back(1 + i * 0x1p-16);
    }
    heights_mm.insert(heights_mm.end(), {7.5, 19, 40});
    return {{.heights_mm = heights_mm}};
}

constexpr double mebibyte = 1 << 20;

/// Upper bound for the memory that slicing may hold besides the input.
double allowance(const SliceResult& result) {
    const std::size_t arrays = result.layers.size() * sizeof(Layer) + result.contours.size() * sizeof(Contour) +
                               result.points.size() * sizeof(Point);
    return 48 * static_cast<double>(result.info.crossed) + 1.2 * static_cast<double>(arrays) + 64 * mebibyte;
}

/// Buckets of which each plane has so many segments, all of triangles that begin at it or, if `listed` is less, below.
Buckets counted(const std::vector<std::uint32_t>& segments, std::uint32_t listed) {
    Buckets buckets(nullptr);
    buckets.segments.resize_discarding(segments.size());
    std::copy(segments.begin(), segments.end(), buckets.segments.begin());
    buckets.list_begin.resize_discarding(segments.size() + 1);
    std::fill(buckets.list_begin.begin(), buckets.list_begin.end(), listed);
    buckets.list_begin[0] = 0;
    buckets.segment_count = std::accumulate(segments.begin(), segments.end(), std::uint64_t{0});
    return buckets;
}

TEST_CASE("slices of soups of every kind are those of the oracle, at every stride, in every band", "[engine][bucket]") {
    const double unit_mm = default_grid_mm;
    // The last: some two hundred planes 4 units apart, each of which rounding moves by a large part of a step.
    const std::tuple<const char*, Plan, std::vector<float>> samples[] = {
        {"uniform", {uniform(0.5)}, random_soup(1000, 1.5F, 1, 5)},
        {"tall", {uniform(0.5)}, random_soup(700, 6, 1, 11)},
        {"most lie between planes", {uniform(3)}, random_soup(1000, 0.05F, 1, 5)},
        {"irregular", {{}, RandomHeights{0.1, 0.5}}, random_soup(1000, 1, 1, 5)},
        {"crowded", crowded_plan(), random_soup(1000, 2, 1, 5)},
        {"fine", {uniform(4.5 * unit_mm)}, flattened(random_soup(500, 0x1p-12F, 1, 9), 0x1p-10F)},
        {"few", {uniform(0.1)}, random_soup(15, 1, 1, 3)},
        {"a block and one", {uniform(0.5)}, random_soup(65, 0.1F, 0.1F, 3)},
        {"one", {uniform(0.1)}, random_soup(1, 1, 1, 3)}};
    const std::vector<Way> all_ways = ways();
    std::size_t turn = 0;
    for (const auto& [name, plan, soup] : samples) {
        const std::vector<double> wide(soup.begin(), soup.end());
        std::vector<std::uint32_t> corners(soup.size() / 3);
        std::iota(corners.begin(), corners.end(), 0U);
        const std::vector<std::byte> spaced = shapes::records(soup, 9, 50);
        const std::vector<std::byte> spaced_wide = shapes::records(wide, 9, 91);
        const std::size_t triangles = soup.size() / 9;
        const MeshView views[] = {MeshView::soup(soup),
                                  MeshView::indexed(soup, corners),
                                  {.vertices = spaced.data() + 1, .triangle_count = triangles, .vertex_stride = 50},
                                  {.vertices = spaced_wide.data() + 1,
                                   .triangle_count = triangles,
                                   .vertex_stride = 91,
                                   .vertex_type = Number::f64}};
        for (const double grid_mm : {0.0, 0.005}) {
            for (const MeshView& view : views) {
                const Way& way = all_ways[(turn + turn / 8) % all_ways.size()];
                ++turn;
                Tuning tuning = way.tuning;
                tuning.random_heights = plan.random;
                SliceOptions options = plan.options;
                options.frame.grid_mm = plan.options.layer_height_mm < 0.001 ? 0 : grid_mm;
                INFO(name << ", view " << &view - views << ", grid " << grid_mm << ", " << way);
                const SliceResult result = sliced(view, options, way.context, tuning);
                const auto facets = oracle::quantise(wide, result.info.grid_mm);
                REQUIRE_THAT(oracle::difference(result, facets), Catch::Equals(""));
                CHECK(result.info.degenerate == triangles - facets.size());
            }
        }
    }
}

TEST_CASE("the table finds the first plane above a vertex", "[engine][bucket][planes]") {
    const Bounds bounds{{-20, -20, -20}, {20, 20, 20}};
    for (const Plan& plan : {Plan{uniform(0.25)}, {uniform(0x1p-18)}, {{}, RandomHeights{0.01, 0.03}}, crowded_plan()}) {
        const bool fine = plan.options.layer_height_mm < 0.001;
        const Bounds box = fine ? Bounds{{0, 0, 0}, {1, 1, 0x1p-8}} : bounds;
        PlaneSet planes(nullptr);
        planes.build(plan.options, plan.random, {box, {default_grid_mm, 0}, Number::f32}, no_limit);
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
        check(-grid_limit);
        check(grid_limit);
    }
}

TEST_CASE("bands hold no more segments than asked for, unless seeds would outnumber the triangles", "[engine][bucket]") {
    std::mt19937 random(3);
    std::vector<std::uint32_t> segments(2000);
    std::generate(segments.begin(), segments.end(), [&] { return static_cast<std::uint32_t>(random() % 700); });
    BandPlan bands{nullptr};
    for (const std::uint64_t most : {std::uint64_t{1}, std::uint64_t{500}, std::uint64_t{5000}, no_limit}) {
        bands.cut(counted(segments, 200), 2000, 0, 1, most);
        PlaneIndex next = 0;
        for (const Band& band : bands.bands) {
            CHECK(band.first == next);
            CHECK((band.last == band.first + 1 || band.segments <= most));
            next = band.last;
        }
        CHECK(next == 2000);
    }
    // Of triangles that all planes cut, bands of one plane would have 63 times as many seeds: more than 2^21.
    constexpr std::uint32_t cut = 100'000;
    bands.cut(counted(std::vector<std::uint32_t>(64, cut), cut), 64, 0, 1, cut);
    REQUIRE(bands.bands.size() > 1);
    CHECK((bands.bands.size() - 1) * cut <= std::size_t{1} << 21);
    CHECK((2 * bands.bands.size() - 1) * cut > std::size_t{1} << 21);
}

TEST_CASE("a band ends above a wide base, and not where a few edges end", "[engine][bucket]") {
    for (const std::uint32_t base : {40'000U, 400U}) {
        std::vector<std::uint32_t> segments(60'000, 10);
        std::fill_n(segments.begin(), 3, base);
        BandPlan bands{nullptr};
        bands.cut(counted(segments, base), 60'000, 0, 1);
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
    SliceOptions options = uniform(200, 1.0);
    CHECK(sliced(MeshView::soup(soup), options).info.degenerate == 64);
    options.frame.grid_mm = default_grid_mm * 4;
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

TEST_CASE("a tall prism of 400,000 facets is not copied once per band", "[engine][scale]") {
    constexpr int quarters = 25'000;
    const shapes::Soup prism = shapes::prism(quarters, 50, 100);
    REQUIRE(prism.size() == 9 * std::size_t{16 * quarters - 4});
    std::uint64_t expected = 0;
    for (const std::int64_t band : {0, 1, 3}) {
        CountingMemory memory;
        Slicer slicer;
        SliceResult result(&memory);
        value_of(slice_tuned(slicer, result, view_of(prism), uniform(5), {.band_planes = band},
                             {.threads = 2, .memory = &memory}));
        if (band == 1) {
            CHECK(result.info.bands == 10);  // bands of one plane each would have 3.8 million seeds
        }
        expected = band == 0 ? result.hash() : expected;
        CHECK(result.hash() == expected);
        CHECK(static_cast<double>(memory.peak()) < allowance(result));
        REQUIRE(result.layers.size() == 20);
        for (const LayerView layer : result) {
            REQUIRE(layer.contour_count == 1);
            CHECK(layer.contours[0].segments == 8 * quarters);
            CHECK(layer.area_mm2() == Approx(std::acos(-1.0) * 2500).epsilon(1e-6));
        }
    }
}

TEST_CASE("an edge map that grows keeps its entries", "[engine][scale]") {
    // The number of edges exceeds half the ends. First come single facets, then pairs that share their short edge: the
    // first faces of all pairs, then the second. The map grows between the first and the second faces.
    constexpr int count = 20'000;
    shapes::Soup soup;
    const auto add = [&soup](int first, int end, const shapes::Soup& facet) {
        for (int i = first; i < end; ++i) {
            shapes::append(soup, shapes::moved(facet, {4.0 * (i % 200), 4.0 * (i / 200), 0}));
        }
    };
    add(0, count, shapes::triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 2}));
    add(count, 2 * count, shapes::triangle({0, 0, 0}, {1, 0, 2}, {0, 1, 4}));
    add(count, 2 * count, shapes::triangle({1, 0, 2}, {0, 0, 0}, {2, 2, 3}));
    const SliceResult result = sliced(soup, at_heights({1}));
    CHECK(result.info.segments == 3 * count);
    CHECK(result.info.open_contours == 2 * count);
}

}  // namespace
