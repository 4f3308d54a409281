// Some layers of a plan have the bytes that they have in the whole; and outers with their holes, as a view of contours.
#include <algorithm>
#include <iterator>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "golden/shape_cases.hpp"

using lamella::Contour;
using lamella::FillRule;
using lamella::Island;
using lamella::Role;
using lamella::SliceOptions;
using lamella::SliceResult;

static_assert(std::forward_iterator<lamella::Islands::Iterator> && std::forward_iterator<SliceResult::Iterator>);

namespace {

/// A layer as SliceResult::hash() reads it, with indices that count from the layer's first, and its heights.
std::vector<double> numbers_of(const lamella::LayerView& layer) {
    std::vector<double> numbers{layer.bottom_mm,         layer.plane_mm,         layer.top_mm,
                                double(layer.plane.z()), double(layer.segments), double(layer.contour_count)};
    for (const Contour& contour : layer.contours) {
        const std::int64_t parent = contour.parent < 0 ? -1 : contour.parent - std::int64_t(layer.first_contour);
        numbers.insert(numbers.end(), {double(contour.role), double(contour.orientation), double(contour.flags),
                                       double(contour.segments), double(parent)});
        for (const lamella::Point& point : layer.points_of(contour)) {
            numbers.insert(numbers.end(), {double(point.x), double(point.y)});
        }
    }
    return numbers;
}

shapes::Soup several_shapes() {
    return shapes::joined({shapes::octasphere({0, 0, 8}, 8, 3), shapes::box({9, 9, 2}, {12, 13, 11}),
                           shapes::triangle({-5, 0, 0.1}, {-9, 0, 15}, {-9, 5, 7})});
}

struct Plan {
    SliceOptions options;
    lamella::Tuning tuning{};
};

std::vector<Plan> plans() {
    std::vector<Plan> all = {
        {uniform(0.3)}, {{}}, {{}, {.random_heights = lamella::RandomHeights{0.1, 1}}}, {uniform(0.25)}, {uniform(1.5)}};
    all[1].options.heights_mm = {{-3, 9, 2, 1.5, 1.5, 11, 7.25, 3, 3.1, 3.2, 400, 5e8}};
    all[3].options.region.fill_from = {{3, FillRule::non_zero}, {9, FillRule::even_odd}};
    all[3].options.stitch_mm = 0.5;
    all[4].options.content = lamella::LayerContent::upward_faces;
    return all;
}

}  // namespace

TEST_CASE("layers cut alone are those of the whole, of a mesh, a prepared mesh and of parts", "[layers]") {
    const shapes::Soup soup = several_shapes();
    const auto prepared = value_of(prepare(view_of(soup)));
    const std::vector<lamella::Part> parts = {{.mesh = view_of(soup)}};
    const lamella::Source sources[] = {view_of(soup), prepared, parts};
    const lamella::Context context{.threads = GENERATE(1, 3)};
    for (auto [options, tuning] : plans()) {
        const SliceResult whole = sliced(soup, options, context, tuning);
        const std::size_t k = whole.layers.size();
        const bool by_faces = options.content != lamella::LayerContent::section;  // of one mesh only
        REQUIRE(whole.info.planned_layers == k);
        REQUIRE(whole.info.first_layer == 0);
        for (std::size_t first = 0; first < k; first += 1 + k / 7) {
            for (const std::size_t count : {std::size_t{1}, std::size_t{2}, k / 3, k}) {
                options.planes.first_layer = first;
                options.planes.end_layer = first + count;
                const SliceResult part = sliced(sources[by_faces ? 0 : (first + count) % 3], options, context, tuning);
                const std::size_t end = std::min(k, first + count);
                INFO("layers " << first << " to " << end << " of " << k);
                CHECK(part.info.first_layer == first);
                CHECK(part.info.planned_layers == k);
                REQUIRE(part.layers.size() == end - first);
                for (std::size_t layer = first; layer < end; ++layer) {
                    CHECK(numbers_of(part[layer - first]) == numbers_of(whole[layer]));
                }
                CHECK(part.info.layer_of == whole.info.layer_of);
            }
        }
    }
}

TEST_CASE("layers that the plan does not have are refused", "[layers]") {
    SliceOptions options = uniform(1);
    const shapes::Soup soup = shapes::box({0, 0, 0}, {5, 5, 5});
    for (const auto& [first, end] : std::vector<std::pair<std::uint64_t, std::uint64_t>>{
             {5, 9}, {2, 2}, {3, 1}, {lamella::all_layers, lamella::all_layers}}) {
        options.planes.first_layer = first;
        options.planes.end_layer = end;
        const lamella::Error error = failure_of(view_of(soup), options);
        CHECK(error.code == lamella::ErrorCode::bad_planes);
        CHECK(error.message.find("of the 5 layers") != std::string::npos);
    }
    options.planes.first_layer = 3;
    options.planes.end_layer = 900;
    CHECK(sliced(soup, options).layers.size() == 2);
}

TEST_CASE("the islands of a slice hold every outer and every hole once", "[engine][islands]") {
    for (const auto& [name, mesh] : shape_cases::meshes()) {
        INFO(name);
        const lamella::SliceResult result = sliced(mesh, uniform(0.25));
        std::size_t outers = 0;
        std::size_t holes = 0;
        for (const lamella::LayerView layer : result) {
            for (const Island island : layer.islands()) {
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
        CHECK(holes == result.info.holes);
        CHECK(outers + holes + result.info.open_contours + result.info.flat_contours == result.contours.size());
    }
}
