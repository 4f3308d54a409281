// How alike two stacks are: known shapes, and dense points judged by brute force.
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "engine/polygons.hpp"
#include "engine/slicing.hpp"
#include "lamella/compare.hpp"
#include "lamella/layers.hpp"

using namespace lamella;
using polygons::box;
using polygons::Ring;
using polygons::Rings;

namespace {

SliceResult layer_of(const Rings& rings) {
    const std::vector<std::span<const Point>> spans(rings.begin(), rings.end());
    return value_of(region_of(spans, {.fill_rule = FillRule::non_zero}, 1));
}

LayerComparison compared(const Rings& first, const Rings& second) {
    return value_of(compare(layer_of(first), layer_of(second))).layers[0];
}

double distance_to(const SliceResult& layer, double x, double y) {
    double least = std::numeric_limits<double>::infinity();
    for (const Contour& contour : layer.contours) {
        rings::each_edge(layer.points_of(contour), [&](Point a, Point b) {
            least = std::min(least, rings::distance(a, b, {x, y}));
        });
    }
    return least;
}

/// Of points at so many places along each edge of `from`: the largest distance, and the sum by length.
struct Sampled {
    double most = 0;
    double sum = 0;
    double length = 0;

    Sampled(const SliceResult& from, const SliceResult& to, int places) {
        for (const Contour& contour : from.contours) {
            rings::each_edge(from.points_of(contour), [&](Point a, Point b) {
                const double own = std::hypot(double(b.x) - a.x, double(b.y) - a.y);
                for (int p = 0; p < places; ++p) {
                    const double t = (p + 0.5) / places;
                    const double found = distance_to(to, a.x + t * (double(b.x) - a.x), a.y + t * (double(b.y) - a.y));
                    most = std::max(most, found);
                    sum += own * found / places;
                }
                length += own;
            });
        }
    }
};

}  // namespace

TEST_CASE("shapes that are known have their Dice and distances", "[compare]") {
    const Rings outer = {box(0, 0, 100, 100)};
    const LayerComparison inner = compared(outer, {box(20, 20, 80, 80)});
    CHECK(inner.dice == 2 * 3600 / 13600.0);
    CHECK(inner.jaccard == 3600 / 10000.0);
    CHECK(inner.hausdorff_mm == Approx(std::sqrt(800)));
    const LayerComparison same = compared(outer, outer);
    CHECK((same.dice == 1 && same.jaccard == 1 && same.mean_distance_mm == 0 && same.hausdorff_mm == 0));
    // Of a long side only the middle lies far: not at its ends, nor at its own middle.
    const LayerComparison notched =
        compared({box(0, -50, 1000, 0)}, {{{0, -50}, {1000, -50}, {1000, 0}, {300, 0}, {250, -40}, {200, 0}, {0, 0}}});
    CHECK(notched.hausdorff_mm == Approx(2000 / std::hypot(50, 40)));
    const LayerComparison missed = compared(outer, {});
    CHECK(
        (missed.dice == 0 && missed.jaccard == 0 && std::isinf(missed.mean_distance_mm) && std::isinf(missed.hausdorff_mm)));
    const LayerComparison nothing = compared({}, {});
    CHECK((std::isnan(nothing.dice) && std::isnan(nothing.jaccard) && std::isnan(nothing.hausdorff_mm)));
}

TEST_CASE("distances of random contours are those of dense points on them", "[compare]") {
    std::mt19937 random(5);
    for (int n = 0; n < 60; ++n) {
        const double size = std::pow(10, 2 + n % 3 * 3);
        const auto shape = [&] {
            Rings rings = {polygons::star(random, 5 + random() % 20, size / 4, size)};
            if (n % 4 == 0) {
                rings.push_back(polygons::round({std::int32_t(size), 0}, size / 2, 40));
            }
            return layer_of(rings);
        };
        const SliceResult first = shape();
        const SliceResult second = shape();
        const LayerComparison found = value_of(compare(first, second)).layers[0];
        const int places = 200;
        const Sampled there(first, second, places);
        const Sampled back(second, first, places);
        const double step = 4 * size / places;
        const double most = std::max(there.most, back.most);
        CHECK(found.hausdorff_mm >= most - 0.5);
        CHECK(found.hausdorff_mm <= most + step);
        CHECK(found.mean_distance_mm == Approx((there.sum + back.sum) / (there.length + back.length)).epsilon(0.1));
        const LayerComparison turned = value_of(compare(second, first)).layers[0];
        CHECK(turned.hausdorff_mm == Approx(found.hausdorff_mm).epsilon(1e-9));
        CHECK(turned.first_mm2 == found.second_mm2);
        CHECK(turned.dice == found.dice);
    }
}

TEST_CASE("stacks are compared as a whole, on any number of threads", "[compare]") {
    const SliceResult ball = sliced(shapes::octasphere({0, 0, 5}, 5, 4), uniform(0.1));
    const SliceResult moved = sliced(shapes::octasphere({0.5, 0, 5}, 5, 4), uniform(0.1));
    const Comparison found = value_of(compare(ball, moved));
    for (const int threads : {1, 3}) {
        const Comparison again = value_of(compare(ball, moved, {}, {.threads = threads}));
        CHECK(std::memcmp(again.layers.data(), found.layers.data(), found.layers.size() * sizeof(LayerComparison)) == 0);
        CHECK(std::memcmp(&again.stack, &found.stack, sizeof found.stack) == 0);
    }
    CHECK(found.stack.hausdorff_mm == Approx(0.5).epsilon(1e-4));
    CHECK(found.stack.dice == Approx(1 - 1.5 * 0.05 + 0.5 * std::pow(0.05, 3)).epsilon(0.01));  // of balls
    CHECK(found.stack.mean_distance_mm < 0.5);
    const Comparison areas = value_of(compare(ball, moved, {.distances = false}));
    CHECK((areas.stack.dice == found.stack.dice && std::isnan(areas.stack.hausdorff_mm)));
}

TEST_CASE("layers that are not known make the stack unknown, and other planes are refused", "[compare]") {
    const shapes::Soup cube = shapes::box({0, 0, 0}, {4, 4, 4});
    const SliceResult whole = sliced(cube, uniform(1));
    const SliceResult open = sliced(shapes::without(cube, 4, 1), uniform(1));
    const Comparison found = value_of(compare(whole, open));
    CHECK((std::isnan(found.layers[1].dice) && std::isnan(found.stack.dice) && std::isnan(found.stack.hausdorff_mm)));
    const Error error = error_of(compare(whole, sliced(cube, uniform(0.5))));
    CHECK(error.message == "layer 0 of the two lies at other heights: cut both at the same planes");
    CHECK(error.plane == 0);
    CHECK(code_of(compare(whole, sliced(cube, uniform(1, 1e-3)))) == ErrorCode::invalid_argument);
}

TEST_CASE("a mirrored mesh of floats is compared with itself at heights that no float holds", "[compare]") {
    const std::vector<float> ball = shapes::floats(shapes::octasphere({0, 0, 105}, 5, 4));
    SliceOptions options{.heights_mm = std::vector<double>{101.1, 102.3, 104.7}};
    const SliceResult own = value_of(slice(MeshView::soup(ball), options));
    options.frame.transform.m[0] = -1;
    const SliceResult mirrored = value_of(slice(MeshView::soup(ball), options));
    CHECK(own.layers[1].plane != mirrored.layers[1].plane);
    CHECK(value_of(compare(own, mirrored)).stack.hausdorff_mm < 1e-5);
}
