// Any source goes to any destination, with the same bytes and the same refusals: one table of each.
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/everywhere.hpp"
#include "golden/shape_cases.hpp"

using lamella::ErrorCode;
using lamella::FillRule;
using lamella::LayerContent;
using lamella::MeshView;
using lamella::SliceOptions;

namespace {

#ifdef LAMELLA_TESTS_SANITIZED
constexpr double region_layer_mm = 5;
#else
constexpr double region_layer_mm = 1;
#endif

struct Question {
    std::string name;
    SliceOptions options;
};

/// Each option that changes the way through the engine at least once.
std::vector<Question> questions() {
    return {
        {"stitched", {.layer_height_mm = 0.25, .stitch_mm = 0.5}},
        {"heights in any order", {.heights_mm = {{4, -1, 0.5, 4, 30, 2}}}},
        {"origins of some layers, turned and above",
         {.layer_height_mm = 0.5,
          .origins = true,
          .planes = {.side = lamella::PlaneSide::above, .first_layer = 3, .end_layer = 12},
          .frame = {.transform = lamella::Transform::from_normal(1, 2, 3), .grid_mm = 0x1p-18}}},
        {"regions",
         {.layer_height_mm = region_layer_mm,
          .region = {.fill_rule = FillRule::non_zero,
                     .offset_mm = -0.4,
                     .flag_closing_mm = 0.1,
                     .largest_only = true,
                     .fill_from = {{2, FillRule::even_odd}}}}},
        {"simplified",
         {.layer_height_mm = region_layer_mm,
          .origins = true,
          .region = {.fill_rule = FillRule::non_zero, .simplify_mm = 0.05}}},
        {"upward faces", {.layer_height_mm = region_layer_mm, .content = LayerContent::upward_faces}},
        {"downward faces", {.layer_height_mm = region_layer_mm, .content = LayerContent::downward_faces}},
    };
}

/// An outline says, and a sink is told before its first layer, all but the counts of contours.
void require_known_before(const lamella::SliceInfo& expected, const lamella::Source& source, const SliceOptions& options) {
    lamella::SliceInfo told;
    std::uint64_t layers = 0;
    const auto begin = [&](const lamella::SliceInfo& info) noexcept { told = layers == 0 ? info : lamella::SliceInfo{}; };
    const auto take = [&](const lamella::LayerView& /*layer*/) noexcept { ++layers; };
    sliced_to(lamella::LayerSink{.take = take, .begin = begin}, source, options);
    for (const lamella::SliceInfo& info : {value_of(lamella::Slicer().outline(source, options)), told}) {
        const bool adds_points = options.region.fill_rule != FillRule::contours || options.content != LayerContent::section;
        CHECK((adds_points || info.segments >= expected.contours));
        CHECK((adds_points || (expected.open_contours > 0 ? 2 : 1) * info.segments >= expected.points));
        CHECK(info.layers == expected.layers);
        CHECK(info.first_layer == expected.first_layer);
        CHECK(info.planned_layers == expected.planned_layers);
        CHECK(info.segments == expected.segments);
        CHECK(info.triangles == expected.triangles);
        CHECK(info.box == expected.box);
        CHECK(info.grid_mm == expected.grid_mm);
        SliceOptions asked = info.options;
        asked.frame.grid_mm = expected.options.frame.grid_mm;  // a prepared mesh's frame holds the grid that was chosen
        CHECK(asked == expected.options);
        CHECK(info.layer_of == expected.layer_of);
    }
}

struct Nothing {
    void operator()(const lamella::LayerView& /*layer*/) const noexcept {}
};

/// Slices to every destination fail with the same error.
void require_refused_alike(const lamella::Source& source, const SliceOptions& options, const lamella::Context& context,
                           const lamella::Error& expected) {
    lamella::SliceResult result;
    GuardedArrays host({1000, 1000, 1000});
    Nothing nothing;
    const lamella::LayerSink sinks[] = {{.take = nothing}, {.take = nothing, .order = lamella::SinkOrder::any}};
    for (const lamella::Destination to : {lamella::Destination(result), lamella::Destination(sinks[0]),
                                          lamella::Destination(sinks[1]), lamella::Destination(host.arrays)}) {
        const lamella::Error found = error_of(lamella::Slicer().slice_to(to, source, options, context));
        CHECK(found.code == expected.code);
        CHECK(found.message == expected.message);
        CHECK(found.triangle == expected.triangle);
        CHECK(found.plane == expected.plane);
    }
}

}  // namespace

TEST_CASE("any source goes to any destination, with the same bytes", "[engine][sources][sink][host][prepare][threads]") {
    const std::vector<Way> all_ways = ways();
    unsigned combination = 0;
    for (const auto& [mesh_name, mesh] : shape_cases::meshes()) {
        for (const auto& [name, options] : questions()) {
            const EverySource sources(mesh, options.frame);
            const lamella::SliceResult expected = sliced(mesh, options, {.threads = 1});
            for (const auto& [source_name, source] : sources.all()) {
                const bool takes_faces = source.prepared() == nullptr && !source.is_parts();
                const Way& way = all_ways[7 * combination % all_ways.size()];
                INFO(mesh_name << " as " << source_name << ", " << name << ", " << way);
                if (tried(combination++) && (takes_faces || options.content == LayerContent::section)) {
                    require_at_every_destination(expected, source, options, way);
                    require_known_before(expected.info, source, options);
                }
            }
        }
    }
}

TEST_CASE("every destination gets planes that all threads work on together", "[engine][sources][sink][wide][threads]") {
    constexpr int quarters = 1 << 15;  // eight facets each: 2^18 segments
    SliceOptions options;
    options.heights_mm = {{0.25, 0.5, 0.75}};
    const shapes::Soup prism = shapes::prism(quarters, 400, 1);
    const shapes::Soup open = shapes::without(prism, 0, 1);  // each band is begun twice
    for (const shapes::Soup& mesh : {prism, open}) {
        const lamella::SliceResult expected = sliced(mesh, options, {.threads = 1});
        require_at_every_destination(expected, view_of(mesh), options, {.context = {.threads = 2}});
        options.stitch_mm = 1;
    }
}

TEST_CASE("an empty mesh gives every destination empty layers where asked for", "[engine][sources][empty]") {
    const shapes::Soup collapsed = {0, 0, 0, 0, 0, 0, 0, 0, 10, 5, 5, 0, 5, 5, 10, 5, 5, 10};  // each along a line
    for (const shapes::Soup& mesh : {shapes::Soup{}, collapsed}) {
        const EverySource sources(mesh, {.grid_mm = coarse_unit_mm});
        for (const LayerContent content :
             {LayerContent::section, LayerContent::upward_faces, LayerContent::downward_faces}) {
            SliceOptions options = at_heights({5, 2, 5});
            options.content = content;
            CHECK(failure_of(view_of(mesh), options).code == ErrorCode::empty_mesh);
            options.allow_empty = true;
            const lamella::SliceResult given = sliced(mesh, options);
            REQUIRE(given.layers.size() == 2);
            CHECK(given.layers[0].plane_mm == 2);
            CHECK(given.layers[0].contour_count == 0);
            CHECK(given.info.layer_of == std::vector<std::uint64_t>{1, 0, 1});
            CHECK(given.info.triangles == mesh.size() / 9);
            CHECK(given.info.degenerate == mesh.size() / 9);
            require_at_every_destination(given, view_of(mesh), options);
            options.heights_mm.reset();
            options.layer_height_mm = 3;
            CHECK(sliced(mesh, options).layers.empty());
        }
        SliceOptions options = at_heights({5, 2, 5});
        options.allow_empty = true;
        const lamella::SliceResult given = sliced(mesh, options);
        for (const auto& [name, source] : sources.all()) {
            INFO(name);
            require_at_every_destination(given, source, options);
        }
        CHECK(sliced(view_of(mesh), options, {}, {.random_heights = lamella::RandomHeights{1, 2, 3}}).layers.empty());
        options.heights_mm.reset();
        options.layer_height_mm = -1;
        CHECK(failure_of(view_of(mesh), options).code == ErrorCode::invalid_argument);
    }
}

TEST_CASE("every destination and content refuses alike, in the same words", "[engine][sources][sink][errors]") {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const shapes::Soup box = shapes::box({0, 0, 0}, {4, 4, 4});
    shapes::Soup no_number = box;
    no_number[40] = nan;
    shapes::Soup too_far = box;
    too_far[40] = 2e9;
    const shapes::Soup point = shapes::triangle({0, 0, 0}, {0.01, 0, 0}, {0, 0.01, 0});
    shapes::Indexed beyond = shapes::indexed(box);
    beyond.indices[7] = 99;
    struct Refusal {
        MeshView mesh;
        SliceOptions options;
        ErrorCode code;
        lamella::Context context{};
    };
    const Refusal refusals[] = {
        {view_of(no_number), at_heights({1}), ErrorCode::bad_coordinate},
        {view_of(too_far), at_heights({1}), ErrorCode::bad_coordinate},
        {MeshView{}, at_heights({1}), ErrorCode::empty_mesh},
        {view_of(point), at_heights({1}), ErrorCode::empty_mesh},
        {beyond.view(), at_heights({1}), ErrorCode::invalid_argument},
        {view_of(box), at_heights({1, nan}), ErrorCode::bad_planes},
        {view_of(box), uniform(-1), ErrorCode::invalid_argument},
        {view_of(box), uniform(1, 1e-18), ErrorCode::invalid_argument},
        {view_of(box), uniform(1, 1e-9), ErrorCode::bad_coordinate},
        {view_of(box), uniform(1), ErrorCode::invalid_argument, {.threads = -1}},
        {view_of(box), uniform(0.001), ErrorCode::result_too_large, {.memory_limit_bytes = 1000}},
    };
    for (const auto& [mesh, options, code, context] : refusals) {
        const lamella::Error expected = failure_of(mesh, options, context);
        CHECK(expected.code == code);
        for (const LayerContent content :
             {LayerContent::section, LayerContent::upward_faces, LayerContent::downward_faces}) {
            INFO(expected.message << ", " << lamella::name_of(content));
            SliceOptions asked = options;
            asked.content = content;
            require_refused_alike(mesh, asked, context, expected);
        }
    }
    CHECK(code_of(lamella::Slicer().slice_to(lamella::LayerSink{}, view_of(box))) == ErrorCode::invalid_argument);
}
