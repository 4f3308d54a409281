// Some layers of a plan have the bytes that they have in the whole; and outers with their holes, as a view of contours.
#include <algorithm>
#include <iterator>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "golden/shape_cases.hpp"

using lamella::Contour;
using lamella::Island;
using lamella::LayerRange;
using lamella::Role;
using lamella::SliceOptions;
using lamella::SliceResult;

static_assert(std::forward_iterator<lamella::Islands::Iterator>);

namespace {

/// What hash_result() reads, with indices that count from the layer's first, and the layers' heights.
std::vector<double> numbers_of(const SliceResult& result, std::size_t first, std::size_t end) {
    std::vector<double> numbers;
    for (std::size_t l = first; l < end; ++l) {
        const lamella::Layer& layer = result.layers[l];
        numbers.insert(numbers.end(), {layer.bottom_mm, layer.plane_mm, layer.top_mm, double(layer.plane.z()),
                                       double(layer.segments), double(layer.contour_count)});
        for (const lamella::Contour& contour : result.contours_of(layer)) {
            const std::int64_t parent = contour.parent < 0 ? -1 : contour.parent - std::int64_t(layer.first_contour);
            numbers.insert(numbers.end(), {double(contour.role), double(contour.orientation), double(contour.flags),
                                           double(contour.segments), double(parent)});
            for (const lamella::Point& point : result.points_of(contour)) {
                numbers.insert(numbers.end(), {double(point.x), double(point.y)});
            }
        }
    }
    return numbers;
}

shapes::Soup several_shapes() {
    return shapes::joined({shapes::octasphere({0, 0, 8}, 8, 3), shapes::box({9, 9, 2}, {12, 13, 11}),
                           shapes::triangle({-5, 0, 0.1}, {-9, 0, 15}, {-9, 5, 7})});
}

std::vector<SliceOptions> plans() {
    std::vector<SliceOptions> all(4);
    all[0].plan.spacing = lamella::UniformLayers{.layer_height_mm = 0.3};
    all[1].plan.spacing = lamella::ExplicitPlanes{{-3, 9, 2, 1.5, 1.5, 11, 7.25, 3, 3.1, 3.2, 400, 5e8}};
    all[2].plan.spacing = lamella::RandomLayers{.min_height_mm = 0.1, .max_height_mm = 1};
    all[3].plan.spacing = lamella::UniformLayers{.layer_height_mm = 0.25};
    all[3].region.fill_from = {{3, lamella::FillRule::non_zero}, {9, lamella::FillRule::even_odd}};
    all[3].close_gaps_mm = 0.5;
    return all;
}

}  // namespace

TEST_CASE("layers cut alone are those of the whole", "[layers]") {
    const shapes::Soup soup = several_shapes();
    for (SliceOptions options : plans()) {
        options.control.threads = GENERATE(1, 3);
        const SliceResult whole = sliced(soup, options);
        const std::size_t k = whole.layers.size();
        REQUIRE(whole.all_layers == k);
        REQUIRE(whole.first_layer == 0);
        for (std::size_t first = 0; first < k; first += 1 + k / 7) {
            for (const std::size_t count : {std::size_t{1}, std::size_t{2}, k / 3, k}) {
                options.layers = {first, first + count};
                const SliceResult part = sliced(soup, options);
                const std::size_t end = std::min(k, first + count);
                INFO("layers " << first << " to " << end << " of " << k);
                CHECK(part.first_layer == first);
                CHECK(part.all_layers == k);
                REQUIRE(part.layers.size() == end - first);
                CHECK(numbers_of(part, 0, part.layers.size()) == numbers_of(whole, first, end));
                CHECK(std::equal(part.layer_of.begin(), part.layer_of.end(), whole.layer_of.begin(), whole.layer_of.end()));
            }
        }
    }
}

TEST_CASE("layers that the plan does not have are refused", "[layers]") {
    SliceOptions options = uniform(1);
    const shapes::Soup soup = shapes::box({0, 0, 0}, {5, 5, 5});
    for (const LayerRange range : {LayerRange{5, 9}, LayerRange{2, 2}, LayerRange{3, 1}, LayerRange{~0ULL, ~0ULL}}) {
        options.layers = range;
        const lamella::Error error = failure_of(view_of(soup), options);
        CHECK(error.code == lamella::ErrorCode::bad_planes);
        CHECK(error.message.find("of the 5 layers") != std::string::npos);
    }
    options.layers = {3, 900};
    CHECK(sliced(soup, options).layers.size() == 2);
}

TEST_CASE("layers of a prepared mesh and of parts are those of the whole", "[layers]") {
    const shapes::Soup soup = several_shapes();
    SliceOptions options = uniform(0.5);
    const SliceResult whole = sliced(soup, options);
    options.layers = {4, 11};
    const auto prepared = value_of(lamella::prepare(view_of(soup)));
    const auto of_prepared = value_of(lamella::slice(prepared, options));
    CHECK(numbers_of(of_prepared, 0, 7) == numbers_of(whole, 4, 11));
    const std::vector<lamella::Part> parts = {{.mesh = view_of(soup)}};
    const auto of_parts = value_of(lamella::slice_parts(parts, options));
    CHECK(of_parts.first_layer == 4);
    CHECK(numbers_of(of_parts, 0, 7) == numbers_of(whole, 4, 11));
}

TEST_CASE("every outer comes with its holes, whatever stands between", "[engine][islands]") {
    std::vector<Contour> contours;
    for (const Role role :
         {Role::open, Role::outer, Role::hole, Role::hole, Role::flat, Role::outer, Role::outer, Role::hole, Role::open}) {
        contours.emplace_back().role = role;
    }
    std::vector<std::pair<std::ptrdiff_t, std::size_t>> found;
    for (const Island island : lamella::islands_of(contours)) {
        found.emplace_back(island.outer - contours.data(), island.holes.size());
        CHECK((island.holes.empty() || island.holes.data() == island.outer + 1));
    }
    CHECK(found == std::vector<std::pair<std::ptrdiff_t, std::size_t>>{{1, 2}, {5, 0}, {6, 1}});
    CHECK(lamella::islands_of({}).begin() == lamella::islands_of({}).end());
}

TEST_CASE("the islands of a slice hold every outer and every hole once", "[engine][islands]") {
    for (const auto& [name, mesh] : shape_cases::meshes()) {
        INFO(name);
        const lamella::SliceResult result = sliced(mesh, uniform(0.25));
        std::size_t outers = 0;
        std::size_t holes = 0;
        for (const lamella::Layer& layer : result.layers) {
            for (const Island island : lamella::islands_of(result.contours_of(layer))) {
                ++outers;
                holes += island.holes.size();
                const auto outer = static_cast<std::int64_t>(island.outer - result.contours.data());
                for (const Contour& hole : island.holes) {
                    // A hole lies in its outer, or in a hole of it.
                    const std::int64_t around = hole.parent;
                    CHECK((around == outer || result.contours[static_cast<std::size_t>(around)].role == Role::hole));
                }
            }
        }
        CHECK(holes == result.summary.holes);
        CHECK(outers + holes + result.summary.open_contours + result.summary.flat_contours == result.contours.size());
    }
}
