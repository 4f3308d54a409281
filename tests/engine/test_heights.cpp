// Adaptive layers against their definition, facet by facet and step by step; and slabs of the host's, which a slice keeps.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <random>

#include "engine/c_handles.hpp"
#include "engine/calls.hpp"
#include "engine/slicing.hpp"
#include "lamella/heights.h"

using namespace lamella;
using c_handles::fresh;
using c_handles::Owned;

namespace {

using Heights = std::vector<int>;  // in steps, from the lowest slab up

std::vector<Slab> slabs_of(const Source& mesh, const AdaptiveOptions& options, const Context& context = {}) {
    const Array<Slab> slabs = value_of(adaptive_layers(mesh, options, context));
    return {slabs.begin(), slabs.end()};
}

/// Requires that slabs lie side by side from `low_mm` up, in whole steps.
Heights heights_in(const std::vector<Slab>& slabs, double low_mm, double step_mm) {
    Heights heights;
    double below = low_mm;
    for (const Slab& slab : slabs) {
        REQUIRE(slab.bottom_mm == below);
        const double steps = (slab.top_mm - slab.bottom_mm) / step_mm;
        REQUIRE(std::abs(steps - std::round(steps)) < 1e-6);
        heights.push_back(static_cast<int>(std::round(steps)));
        below = slab.top_mm;
    }
    return heights;
}

/// Four faces of 45 degrees over a square, 5 mm high.
shapes::Soup pyramid() {
    const shapes::Xyz a = {-5, -5, 0};
    const shapes::Xyz b = {5, -5, 0};
    const shapes::Xyz c = {5, 5, 0};
    const shapes::Xyz d = {-5, 5, 0};
    const shapes::Xyz top = {0, 0, 5};
    return shapes::joined({shapes::quad(a, d, c, b), shapes::triangle(a, b, top), shapes::triangle(b, c, top),
                           shapes::triangle(c, d, top), shapes::triangle(d, a, top)});
}

/// The definition, by a look at every facet for every step.
class Definition {
public:
    Definition(const shapes::Soup& soup, const AdaptiveOptions& options)
        : step_(options.step_mm),
          least_(steps_in(options.least_mm)),
          most_(steps_in(options.most_mm)),
          change_(options.most_change_mm > 0 ? steps_in(options.most_change_mm) : most_) {
        for (std::size_t i = 2; i < soup.size(); i += 3) {
            low_ = std::min(low_, soup[i]);
            high_ = std::max(high_, soup[i]);
        }
        const int steps = std::max(1, static_cast<int>(std::ceil((high_ - low_) / step_ - slack)));
        allowed_.assign(static_cast<std::size_t>(steps), most_);
        for (std::size_t t = 0; t < soup.size(); t += 9) {
            add_facet(soup.data() + t, options);
        }
        smooth(options.smoothing_mm);
    }

    double low_mm() const { return low_; }

    /// Each slab as high as any that some slabs could follow.
    Heights heights() {
        Heights heights;
        for (int at = 0, below = 0; at < size(); at += below) {
            int height = below == 0 ? most_ : std::min(most_, below + change_);
            while (!fits(at, height)) {
                --height;
            }
            REQUIRE((below == 0 || height >= below - change_));
            if (at > 0 && low_ + (at + height / 2.0) * step_ >= high_) {
                break;
            }
            heights.push_back(height);
            below = height;
        }
        return heights;
    }

private:
    static constexpr double slack = 0.01;

    int steps_in(double mm) const { return static_cast<int>(std::floor(mm / step_ + slack)); }
    int size() const { return static_cast<int>(allowed_.size()); }

    void add_facet(const double* v, const AdaptiveOptions& options) {
        const double ab[3] = {v[3] - v[0], v[4] - v[1], v[5] - v[2]};
        const double ac[3] = {v[6] - v[0], v[7] - v[1], v[8] - v[2]};
        const double x = ab[1] * ac[2] - ab[2] * ac[1];
        const double y = ab[2] * ac[0] - ab[0] * ac[2];
        const double z = ab[0] * ac[1] - ab[1] * ac[0];
        if (x == 0 && y == 0) {
            return;
        }
        const double angle = std::atan2(std::hypot(x, y), std::abs(z));
        double height = std::numeric_limits<double>::infinity();
        if (options.cusp_mm > 0) {
            height = std::min(height, options.cusp_mm / std::cos(angle));
        }
        if (const double d = options.deviation_mm; d > 0) {
            height = std::min({height, d / 0.184, 1.44 * d * std::sqrt(std::sin(angle) / std::cos(angle))});
        }
        if (options.slope_limit_mm > 0) {
            height = std::min(height, options.slope_limit_mm * std::tan(angle));
        }
        const int whole = std::clamp(static_cast<int>(std::min(height / step_ + slack, double(most_))), least_, most_);
        const auto [low, high] = std::minmax({v[2], v[5], v[8]});
        for (int s = 0; s < size(); ++s) {
            const double first = (low - low_) / step_ + slack;
            const double last = (high - low_) / step_ - slack;
            if ((first < s + 1 && last > s) || s == std::min(static_cast<int>(first), size() - 1)) {
                allowed_[static_cast<std::size_t>(s)] = std::min(allowed_[static_cast<std::size_t>(s)], whole);
            }
        }
    }

    void smooth(double mm) {
        const Heights all = allowed_;
        for (int s = 0; mm > 0 && s < size(); ++s) {
            const auto begin = all.begin() + std::max(0, s - steps_in(mm));
            const auto end = all.begin() + std::min(size(), s + steps_in(mm) + 1);
            const int mean = std::accumulate(begin, end, 0) / static_cast<int>(end - begin);
            allowed_[static_cast<std::size_t>(s)] = std::max(least_, std::min(allowed_[static_cast<std::size_t>(s)], mean));
        }
    }

    /// Every step allows it, and so does some slab above it.
    bool fits(int at, int height) {
        if (at >= size()) {
            return true;
        }
        const auto [known, fresh] = fits_.try_emplace({at, height}, false);
        if (fresh) {
            const auto begin = allowed_.begin() + at;
            const auto end = allowed_.begin() + std::min(size(), at + height);
            bool good = std::all_of(begin, end, [height](int allowed) { return allowed >= height; });
            bool followed = false;
            for (int next = std::max(least_, height - change_); good && next <= std::min(most_, height + change_); ++next) {
                followed = followed || fits(at + height, next);
            }
            good = good && followed;
            fits_[{at, height}] = good;
        }
        return fits_[{at, height}];
    }

    double step_;
    int least_;
    int most_;
    int change_;
    double low_ = std::numeric_limits<double>::infinity();
    double high_ = -std::numeric_limits<double>::infinity();
    Heights allowed_;
    std::map<std::pair<int, int>, bool> fits_;
};

double drawn(std::mt19937_64& random, double least, double most) {
    return least + (most - least) * static_cast<double>(random() >> 11) * 0x1p-53;
}

/// Each measure in half of the cases, and changes and smoothing in some.
AdaptiveOptions drawn_options(std::mt19937_64& random) {
    AdaptiveOptions options{.least_mm = 0.05 * static_cast<double>(1 + random() % 4), .step_mm = 0.05};
    options.most_mm = options.least_mm + 0.05 * static_cast<double>(random() % 20);
    const auto perhaps = [&random](double least, double most) { return random() % 2 == 0 ? drawn(random, least, most) : 0; };
    options.cusp_mm = perhaps(0.02, 0.6);
    options.deviation_mm = perhaps(0.02, 0.6);
    options.slope_limit_mm = perhaps(0.02, 2);
    options.most_change_mm = perhaps(0.05, 0.4);
    options.smoothing_mm = perhaps(0.05, 1);
    return options;
}

shapes::Soup drawn_mesh(std::mt19937_64& random) {
    const std::uint64_t seed = random();
    const shapes::Soup soups[] = {
        shapes::octasphere({0, 0, 0}, drawn(random, 0.1, 4), static_cast<int>(seed % 4)),
        shapes::random_tetrahedra(seed, 1 + static_cast<int>(seed % 6), 5),
        shapes::random_soup(seed, 1 + static_cast<int>(seed % 20), 6),
        shapes::joined({shapes::box({0, 0, 0}, {2, 2, 2}), shapes::moved(pyramid(), {1, 1, 2})}),
    };
    const double scale = drawn(random, 0.2, 1.5);
    return shapes::moved(shapes::scaled(soups[random() % 4], {drawn(random, 0.2, 3), 1, scale}),
                         {0, 0, drawn(random, -50, 50)});
}

TEST_CASE("walls have the highest layers, and slopes of 45 degrees those of their measure", "[engine][heights]") {
    const shapes::Soup box = shapes::box({0, 0, 0}, {4, 4, 9});
    CHECK(heights_in(slabs_of(view_of(box), {.cusp_mm = 0.01}), 0, 0.005) == Heights(30, 60));
    const shapes::Soup cone = pyramid();
    for (const AdaptiveOptions& options :
         {AdaptiveOptions{.cusp_mm = 0.1}, AdaptiveOptions{.deviation_mm = 0.1}, AdaptiveOptions{.slope_limit_mm = 0.14}}) {
        CHECK(heights_in(slabs_of(view_of(cone), options), 0, 0.005) == Heights(36, 28));
    }
    CHECK(slabs_of(view_of(cone), {}) == slabs_of(view_of(shapes::box({0, 0, 0}, {4, 4, 5})), {.cusp_mm = 0.01}));
}

TEST_CASE("layers are as high as their definition allows, and none could be a step higher", "[engine][heights][random]") {
    std::mt19937_64 random(40);
    for (int i = 0; i < 400; ++i) {
        const shapes::Soup soup = drawn_mesh(random);
        const AdaptiveOptions options = drawn_options(random);
        Definition definition(soup, options);
        INFO("case " << i);
        const Context context{.threads = 1 + i % 3};
        REQUIRE(heights_in(slabs_of(view_of(soup), options, context), definition.low_mm(), options.step_mm) ==
                definition.heights());
    }
}

TEST_CASE("heights do not depend on order, threads, types or how a mesh is given", "[engine][heights][threads]") {
    const shapes::Soup soup = shapes::joined({shapes::octasphere({0, 0, 0}, 8, 6), shapes::octasphere({3, 1, 9}, 4, 5)});
    const std::vector<float> floats = shapes::floats(soup);
    const shapes::Soup rounded(floats.begin(), floats.end());
    const shapes::Soup shuffled = shapes::shuffled(rounded, 7);
    const shapes::Indexed indexed = shapes::indexed(rounded);
    const PreparedMesh prepared = value_of(prepare(view_of(floats)));
    const AdaptiveOptions options{.cusp_mm = 0.06, .most_change_mm = 0.02, .smoothing_mm = 0.3};
    const std::vector<Slab> expected = slabs_of(view_of(floats), options, {.threads = 1});
    REQUIRE(expected.size() > 100);
    for (const int threads : {2, 5}) {
        const Context context{.threads = threads};
        CHECK(slabs_of(view_of(floats), options, context) == expected);
        CHECK(slabs_of(view_of(shuffled), options, context) == expected);
    }
    CHECK(slabs_of(indexed.view(), options) == expected);
    CHECK(slabs_of(prepared, options) == expected);
    const shapes::Soup first = shapes::only(rounded, 0, 32768);
    const shapes::Soup rest = shapes::only(rounded, 32768, 8192);
    const Part parts[] = {{.mesh = view_of(first)}, {.mesh = view_of(rest)}};
    CHECK(slabs_of(parts, options) == expected);
    AdaptiveOptions turned = options;
    turned.frame.transform.m = {0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0};  // x, y and z become z, x and y
    shapes::Soup lying(rounded.size());
    for (std::size_t i = 0; i < rounded.size(); i += 3) {
        std::rotate_copy(
            rounded.begin() + static_cast<std::ptrdiff_t>(i), rounded.begin() + static_cast<std::ptrdiff_t>(i) + 2,
            rounded.begin() + static_cast<std::ptrdiff_t>(i) + 3, lying.begin() + static_cast<std::ptrdiff_t>(i));
    }
    CHECK(slabs_of(view_of(lying), turned) == expected);
}

TEST_CASE("slabs that begin in a range have its height, and change is limited around it", "[engine][heights]") {
    const shapes::Soup cone = pyramid();
    const HeightRange ranges[] = {{0, 0.3, 0.3}, {1, 2, 0.04}, {3, 100, 0.2}};
    const std::vector<Slab> slabs = slabs_of(view_of(cone), {.cusp_mm = 0.1, .ranges = ranges});
    CHECK(slabs[0] == Slab{0, 0.3});
    for (const Slab& slab : slabs) {
        const bool thin = slab.bottom_mm > 0.9999 && slab.bottom_mm < 1.9999;
        const bool thick = slab.bottom_mm > 2.9999 || slab.bottom_mm == 0;
        const double most = thick ? (slab.bottom_mm == 0 ? 0.3 : 0.2) : thin ? 0.04 : 0.14;
        INFO(slab.bottom_mm);
        CHECK(slab.top_mm - slab.bottom_mm < most + 1e-6);
        CHECK((slab.top_mm - slab.bottom_mm > most - 1e-6 || (!thin && !thick && slab.bottom_mm < 1)));
    }
    CHECK(std::any_of(slabs.begin(), slabs.end(), [](const Slab& slab) { return slab.top_mm > 1 && slab.top_mm < 1.06; }));
    const HeightRange one[] = {{2, 2.5, 0.05}};
    const AdaptiveOptions smooth{.cusp_mm = 0.1, .most_change_mm = 0.01, .ranges = one};
    const Heights heights = heights_in(slabs_of(view_of(cone), smooth), 0, 0.005);
    CHECK(*std::min_element(heights.begin(), heights.end()) == 10);
    CHECK(*std::max_element(heights.begin(), heights.end()) == 28);
    for (std::size_t i = 1; i < heights.size(); ++i) {
        CHECK(std::abs(heights[i] - heights[i - 1]) <= 2);
    }
}

TEST_CASE("adaptive layers refuse what makes no sense, by name", "[engine][heights][errors]") {
    const shapes::Soup cone = pyramid();
    const auto refusal = [&](const AdaptiveOptions& options) {
        const Error error = error_of(adaptive_layers(view_of(cone), options));
        CHECK(error.code == ErrorCode::invalid_argument);
        return error.message;
    };
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    CHECK(refusal({.least_mm = 0.004}) == "least_mm must be at least step_mm and at most most_mm");
    CHECK(refusal({.least_mm = 0.4}) == "least_mm must be at least step_mm and at most most_mm");
    CHECK(refusal({.most_mm = 6000}) == "most_mm is more than 2^20 times step_mm: 6000");
    CHECK(refusal({.step_mm = 0}) == "step_mm must be finite and more than 0, not 0");
    CHECK(refusal({.step_mm = 1e-320}) == "step_mm must be finite and more than 0, not 1e-320");
    CHECK(refusal({.cusp_mm = -1}) == "cusp_mm must be finite and at least 0, not -1");
    CHECK(refusal({.deviation_mm = nan}) == "deviation_mm must be finite and at least 0, not nan");
    CHECK(refusal({.slope_limit_mm = HUGE_VAL}) == "slope_limit_mm must be finite and at least 0, not inf");
    CHECK(refusal({.most_change_mm = 0.001}) == "most_change_mm must be 0 or at least step_mm");
    CHECK(refusal({.smoothing_mm = -0.1}) == "smoothing_mm must be finite and at least 0, not -0.1");
    const HeightRange wrong[][2] = {{{0, 1, 0.1}, {0.5, 2, 0.1}}, {{0, 1, 0.1}, {2, 2, 0.1}}, {{0, 1, 0.1}, {1, nan, 0.1}}};
    for (const auto& ranges : wrong) {
        CHECK(refusal({.ranges = ranges}) == "ranges[1] must begin at 0 or above, after the one before, and end above that");
    }
    const HeightRange low[] = {{0, 1, 0.001}};
    CHECK(refusal({.ranges = low}) == "ranges[0].height_mm is less than step_mm");

    const std::vector<Part> parts = {{.mesh = view_of(cone)}, {.mesh = {}}};
    CHECK(error_of(adaptive_layers(parts)).message == "part 1: the mesh has no triangles");
    CHECK(error_of(adaptive_layers(std::vector<Part>())).message == "there are no parts");
    const PreparedMesh prepared = value_of(prepare(view_of(cone)));
    CHECK_THAT(error_of(adaptive_layers(prepared, {.frame = {.transform = Transform::scale(2)}})).message,
               Catch::Contains("prepared with another transform"));
    shapes::Soup broken = cone;
    broken[20] = nan;
    CHECK(error_of(adaptive_layers(view_of(broken))).triangle == 2);
    const Error large =
        error_of(adaptive_layers(view_of(cone), {.least_mm = 1e-6, .step_mm = 1e-6}, {.memory_limit_bytes = 1 << 20}));
    CHECK(large.code == ErrorCode::result_too_large);
    CHECK(large.message == "5 mm in steps of 1e-06 mm need more than the memory limit of 1048576 bytes");
}

TEST_CASE("a mesh of no height, or of less than a slab, has one slab", "[engine][heights]") {
    const shapes::Soup flat = shapes::quad({0, 0, 3}, {4, 0, 3}, {4, 4, 3}, {0, 4, 3});
    CHECK(slabs_of(view_of(flat), {.cusp_mm = 0.1}) == std::vector<Slab>{{3, 3 + 60 * 0.005}});
    CHECK(slabs_of(view_of(shapes::box({0, 0, 0}, {1, 1, 0.001})), {}) == std::vector<Slab>{{0, 60 * 0.005}});
}

TEST_CASE("a slice keeps the slabs that it is given", "[engine][heights][planes]") {
    const shapes::Soup box = shapes::box({0, 0, 0}, {4, 4, 9});
    const std::vector<Slab> slabs = {{6, 9}, {0, 1}, {1, 3}, {4, 6}};  // in any order, with a gap
    SliceOptions options{.slabs = slabs};
    const SliceResult middles = sliced(box, options);
    CHECK(middles.info.options.heights_mm == std::vector<double>{7.5, 0.5, 2, 5});
    CHECK(middles.info.layer_of == std::vector<std::uint64_t>{3, 0, 1, 2});
    double volume = 0;
    for (std::size_t i = 0; i < slabs.size(); ++i) {
        const LayerView layer = middles[middles.info.layer_of[i]];
        CHECK(Slab{layer.bottom_mm, layer.top_mm} == slabs[i]);
        CHECK(layer.plane_mm == middles.info.options.heights_mm->at(i));
        volume += layer.area_mm2() * (layer.top_mm - layer.bottom_mm);
    }
    CHECK(volume == 16 * 8);
    CHECK(sliced(box, middles.info.options).hash() == middles.hash());

    options.heights_mm = {6, 0.25, 3, 6 - 0x1p-22};  // at ends too; the first and the last share a plane
    const SliceResult given = sliced(box, options);
    REQUIRE(given.size() == 3);
    CHECK(given[0].plane_mm == 0.25);
    CHECK(given[2].plane_mm == 6 - 0x1p-22);
    CHECK(given[2].bottom_mm == 4);
    CHECK(given[2].top_mm == 9);
    options.planes.first_layer = 1;
    CHECK(sliced(box, options)[0].bottom_mm == 1);
    const std::vector<Part> parts = {{.mesh = view_of(box)}, {.mesh = view_of(box)}};
    CHECK(sliced(parts, options)[0].top_mm == 3);
    options.content = LayerContent::upward_faces;
    CHECK(sliced(box, options)[0].top_mm == 3);
}

TEST_CASE("slabs that do not fit their planes are refused", "[engine][heights][planes][errors]") {
    const shapes::Soup box = shapes::box({0, 0, 0}, {4, 4, 9});
    const auto refusal = [&](const SliceOptions& options) {
        const Error error = failure_of(view_of(box), options);
        CHECK(error.code == ErrorCode::bad_planes);
        return error.message;
    };
    CHECK(refusal({.heights_mm = {{1, 2}}, .slabs = {{0, 1}}}) == "1 slab for 2 heights");
    CHECK(refusal({.heights_mm = {{1, 2}}, .slabs = {{0, 1}, {0, 1}}}) ==
          "slab 1, from 0 mm to 1 mm, does not hold its plane at 2 mm");
    CHECK(refusal({.slabs = {{0, 1}, {3, 2}}}) == "slab 1, from 3 mm to 2 mm, has no middle");
    CHECK(refusal({.slabs = {{0, HUGE_VAL}}}) == "slab 0, from 0 mm to inf mm, has no middle");
    CHECK(refusal({.slabs = {{std::nan(""), 1}}}) == "slab 0, from nan mm to 1 mm, has no middle");
}

TEST_CASE("adaptive layers go through C, to a slice that keeps them", "[c][heights]") {
    const std::vector<float> soup = shapes::floats(pyramid());
    auto mesh = fresh<lamella_mesh>(LAMELLA_MESH);
    mesh.vertices = soup.data();
    mesh.triangle_count = soup.size() / 9;
    auto source = fresh<lamella_source>(LAMELLA_SOURCE);
    source.mesh = &mesh;
    auto adaptive = fresh<lamella_adaptive>(LAMELLA_ADAPTIVE);
    const lamella_height_range in_c{0, 0.3, 0.2};
    const HeightRange in_cpp[] = {{0, 0.3, 0.2}};
    adaptive.cusp_mm = 0.1;
    adaptive.ranges = &in_c;
    adaptive.range_count = 1;
    lamella_slabs* found = nullptr;
    REQUIRE(lamella_adaptive_layers(&source, &adaptive, nullptr, nullptr, &found, nullptr) == LAMELLA_OK);
    auto options = fresh<lamella_options>(LAMELLA_OPTIONS);
    options.slabs = lamella_slabs_view(found, &options.slab_count);
    const std::vector<Slab> slabs = slabs_of(view_of(soup), {.cusp_mm = 0.1, .ranges = in_cpp});
    REQUIRE(options.slab_count == slabs.size());
    lamella_result* made = nullptr;
    REQUIRE(lamella_slice(nullptr, &mesh, &options, &made, nullptr) == LAMELLA_OK);
    const Owned<lamella_result> result(made);
    auto layer = fresh<lamella_layer_view>(LAMELLA_LAYER_VIEW);
    for (std::size_t i = 0; i < slabs.size(); ++i) {
        REQUIRE(lamella_result_layer(made, i, &layer) == LAMELLA_OK);
        CHECK(Slab{layer.layer.bottom_mm, layer.layer.top_mm} == slabs[i]);
    }
    adaptive.ranges = nullptr;
    auto error = fresh<lamella_error>(LAMELLA_ERROR);
    CHECK(lamella_adaptive_layers(&source, &adaptive, nullptr, nullptr, &found, &error) == LAMELLA_INVALID_ARGUMENT);
    CHECK(std::string(error.message) == "ranges is NULL, but its count is not 0");
    lamella_slabs_free(found);
    CHECK((lamella_slabs_view(nullptr, &options.slab_count) == nullptr && options.slab_count == 0));
}

}  // namespace
