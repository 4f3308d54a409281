// lamella.h: the same bytes as the C++ calls, from any source to any destination; structs of other sizes; what is refused.
#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/c_calls.hpp"
#include "engine/shapes.hpp"
#include "lamella/lamella.h"
#include "lamella/lamella.hpp"

using namespace c_calls;
using namespace lamella;

TEST_CASE("any source goes to any destination by C", "[c]") {
    const std::vector<float> sphere = shapes::floats(shapes::octasphere({1, 2, 3}, 20, 3));
    const lamella_mesh mesh = soup_of(sphere);
    lamella_options options = options_at(0.7);
    options.origins = 1;
    lamella_prepared* handle = nullptr;
    REQUIRE(lamella_prepare(&mesh, &options, nullptr, &handle, nullptr) == LAMELLA_OK);
    const std::unique_ptr<lamella_prepared, Freed> prepared(handle);
    CHECK(lamella_prepared_grid_mm(handle) == LAMELLA_DEFAULT_GRID_MM);
    CHECK(lamella_prepared_bytes(handle) >= mesh.triangle_count * 48);
    const lamella_part parts[2] = {{&mesh, {}},
                                   {&mesh, {1, 0, 0, 50, 0, 1, 0, 0, 0, 0, 1, 0}}};  // the second is moved along x
    lamella_source source = source_of(mesh);
    const int kind = GENERATE(0, 1, 2, 3, 4);
    INFO("a mesh, prepared, two parts, what faces project: " << kind);
    if (kind == 1 || kind == 2) {
        source.mesh = nullptr;
        source.prepared = kind == 1 ? handle : nullptr;
        source.parts = kind == 2 ? parts : nullptr;
        source.part_count = kind == 1 ? 0 : 2;
    } else if (kind > 2) {
        options.content = kind == 3 ? LAMELLA_LAYER_CONTENT_UPWARD_FACES : LAMELLA_LAYER_CONTENT_DOWNWARD_FACES;
        lamella_result* refused = nullptr;
        CHECK(lamella_slice(nullptr, &mesh, &options, &refused, nullptr) == LAMELLA_INVALID_ARGUMENT);  // no origins
        options.origins = 0;
    }
    const ResultHandle expected = sliced(source, options);
    const lamella_view view = view_of(expected);
    REQUIRE(view.info.points != 0);
    CHECK(view.info.part_count == (kind == 2 ? 2 : 1));
    CHECK((kind > 2 || view.info.points == view.info.part_count * view_of(sliced(mesh, options)).info.points));

    const std::unique_ptr<lamella_slicer, Freed> slicer(lamella_slicer_create());
    auto outline = fresh<lamella_info>(LAMELLA_INFO);
    REQUIRE(lamella_outline(slicer.get(), &source, &options, nullptr, &outline, nullptr) == LAMELLA_OK);
    CHECK(outline.layers == view.info.layers);
    CHECK(lamella_slicer_bytes(slicer.get()) > 0);

    Collected got;
    const lamella_sink sink = got.sink();
    auto to = into(nullptr, &sink, nullptr);
    auto info = fresh<lamella_info>(LAMELLA_INFO);
    REQUIRE(lamella_slice_to(slicer.get(), &to, &source, &options, nullptr, &info, nullptr) == LAMELLA_OK);
    CHECK(info.points == view.info.points);
    CHECK(got.order.size() == view.info.layers);
    CHECK(std::is_sorted(got.order.begin(), got.order.end()));
    CHECK(same_bytes(got.points, view.points, view.info.points));

    const std::uint64_t most = std::max(outline.segments, view.info.points);  // regions make points
    std::vector<lamella_point> points(most);
    std::vector<lamella_point_origin> origins(most);
    std::vector<lamella_contour> contours(most);
    std::vector<lamella_layer> layers(outline.layers);
    auto arrays = fresh<lamella_arrays>(LAMELLA_ARRAYS);
    arrays.points = points.data();
    arrays.contours = contours.data();
    arrays.layers = layers.data();
    arrays.origins = origins.data();
    arrays.point_capacity = arrays.contour_capacity = most;
    arrays.layer_capacity = layers.size();
    to = into(nullptr, nullptr, &arrays);
    REQUIRE(lamella_slice_to(slicer.get(), &to, &source, &options, nullptr, &info, nullptr) == LAMELLA_OK);
    CHECK(info.contours == view.info.contours);
    CHECK(same_bytes(points, view.points, view.info.points));
    if (view.origins != nullptr) {
        CHECK(same_bytes(got.origins, view.origins, view.info.points));
        CHECK(same_bytes(origins, view.origins, view.info.points));
    }
    lamella_slicer_reset(slicer.get());
    CHECK(lamella_slicer_bytes(slicer.get()) == 0);
}

TEST_CASE("a slice by C has the bytes of one by C++, whatever is asked", "[c]") {
    const std::vector<float> sphere = shapes::floats(shapes::octasphere({1, 2, 3}, 20, 4));
    const std::vector<double> heights = {7, 1, 1, 4};
    struct Case {
        std::function<void(lamella_options&)> in_c;
        SliceOptions in_cpp;
    };
    const Case cases[] = {
        {[](lamella_options& it) { it.layer_height_mm = 0.5; }, {.layer_height_mm = 0.5}},
        {[](lamella_options& it) { it.origins = 1; }, {.origins = true}},
        {[](lamella_options& it) { it.content = LAMELLA_LAYER_CONTENT_UPWARD_FACES; },
         {.content = LayerContent::upward_faces}},
        {[](lamella_options& it) { it.content = LAMELLA_LAYER_CONTENT_DOWNWARD_FACES; },
         {.content = LayerContent::downward_faces}},
        {[](lamella_options& it) { it.simplify_mm = 0.5; }, {.region = {.simplify_mm = 0.5}}},
        {[&](lamella_options& it) {
             it = at_heights(heights);
             it.fill_rule = LAMELLA_FILL_RULE_NON_ZERO;
             it.offset_mm = 0.25;
         },
         {.heights_mm = heights, .region = {.fill_rule = FillRule::non_zero, .offset_mm = 0.25}}},
        // The finest grid leaves room for the offset.
        {[](lamella_options& it) {
             it.fill_rule = LAMELLA_FILL_RULE_NON_ZERO;
             it.offset_mm = 2.5;
             it.grid_mm = LAMELLA_FINEST_GRID;
         },
         {.frame = {.grid_mm = finest_grid}, .region = {.fill_rule = FillRule::non_zero, .offset_mm = 2.5}}},
    };
    for (const auto& [in_c, in_cpp] : cases) {
        lamella_options options = fresh<lamella_options>(LAMELLA_OPTIONS);
        in_c(options);
        const ResultHandle result = sliced(soup_of(sphere), options);
        const Result<SliceResult> expected = slice(MeshView::soup(sphere), in_cpp);
        REQUIRE(expected);
        CHECK(lamella_result_hash(result.get()) == expected->hash());
        const lamella_view view = view_of(result);
        CHECK(view.info.grid_mm == expected->info.grid_mm);
        CHECK(std::vector(view.info.layer_of, view.info.layer_of + view.info.layer_of_count) == expected->info.layer_of);
        CHECK(std::equal(expected->origins.begin(), expected->origins.end(), view.origins,
                         [](const auto& a, const auto& b) { return std::memcmp(&a, &b, sizeof a) == 0; }));
    }
}

TEST_CASE("counts, layers, islands and areas go through C", "[c]") {
    using namespace shapes;
    const std::vector<float> soup =  // a box with a box in it that is empty, beside a smaller one
        floats(joined({box({0, 0, 0}, {9, 9, 9}), flipped(box({2, 2, 2}, {7, 7, 7})), box({12, 0, 0}, {15, 3, 9})}));
    const lamella_mesh mesh = soup_of(soup);
    const lamella_source source = source_of(mesh);
    const std::vector<double> heights = {7.5, 1, 4.5, 1};
    const lamella_options options = at_heights(heights);
    const ResultHandle result = sliced(mesh, options);
    const lamella_view view = view_of(result);
    const std::unique_ptr<lamella_slicer, Freed> slicer(lamella_slicer_create());
    auto info = fresh<lamella_info>(LAMELLA_INFO);
    REQUIRE(lamella_outline(slicer.get(), &source, &options, nullptr, &info, nullptr) == LAMELLA_OK);
    REQUIRE(info.layer_of_count == 4);
    CHECK(std::vector<std::uint64_t>(info.layer_of, info.layer_of + 4) == std::vector<std::uint64_t>{2, 0, 1, 0});
    CHECK(std::vector{view.info.triangles, view.info.holes} == std::vector<std::uint64_t>{36, 1});
    CHECK(info.max_mm[0] == 15);
    // A slicer that ends with the call keeps no list.
    REQUIRE(lamella_outline(nullptr, &source, &options, nullptr, &info, nullptr) == LAMELLA_OK);
    CHECK(info.layer_of_count == 0);

    auto layer = fresh<lamella_layer_view>(LAMELLA_LAYER_VIEW);
    REQUIRE(lamella_result_layer(result.get(), 1, &layer) == LAMELLA_OK);
    CHECK(lamella_area_mm2(&layer) == 81 - 25 + 9);
    CHECK(layer.points == view.points + layer.first_point);
    std::vector<double> areas;
    lamella_island island;
    for (std::uint64_t at = 0; lamella_next_island(layer.contours, layer.layer.contour_count, &at, &island) != 0;) {
        double area = lamella_contour_area_mm2(island.outer, view.info.grid_mm);
        for (std::uint64_t h = 0; h < island.hole_count; ++h) {
            CHECK(view.contours + island.holes[h].parent == island.outer);
            area += lamella_contour_area_mm2(island.holes + h, view.info.grid_mm);
        }
        areas.push_back(area);
    }
    CHECK(areas == std::vector<double>{81 - 25, 9});
    CHECK(lamella_result_layer(result.get(), 3, &layer) == LAMELLA_INVALID_ARGUMENT);
    std::uint64_t none = 0;
    CHECK(lamella_next_island(nullptr, 0, &none, &island) == 0);
    CHECK(lamella_contour_area_mm2(nullptr, 1) == 0);
}

TEST_CASE("every type of coordinates and indices gives the same slice by C, and a wrong index is named", "[c]") {
    const std::vector<std::int32_t> i32 = {0, 0, 0, 9000, 0, 0, 0, 9000, 0, 0, 0, 9000};
    const std::vector<std::int64_t> i64(i32.begin(), i32.end());
    const std::vector<double> f64(i32.begin(), i32.end());
    const std::vector<float> f32(i32.begin(), i32.end());
    const std::vector<std::uint32_t> u32 = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    const std::vector<std::uint32_t> spaced = {0, 2, 1, 77, 78, 0, 1, 3, 77, 78, 0, 3, 2, 77, 78, 1, 2, 3, 77, 78};
    std::vector<std::uint64_t> u64(u32.begin(), u32.end());
    const auto mesh_of = [](int type, const void* vertices, int index_type, const void* index, std::size_t stride = 0) {
        auto mesh = fresh<lamella_mesh>(LAMELLA_MESH);
        mesh.vertex_type = type;
        mesh.vertices = vertices;
        mesh.vertex_count = 4;
        mesh.indices = index;
        mesh.index_type = index_type;
        mesh.index_stride = stride;
        mesh.triangle_count = 4;
        mesh.mm_per_unit = 1e-3;
        return mesh;
    };
    const lamella_options options = options_at(0.25);
    const std::uint64_t expected = hash_of(mesh_of(LAMELLA_F64, f64.data(), LAMELLA_U32, u32.data()), options);
    CHECK(hash_of(mesh_of(LAMELLA_I32, i32.data(), LAMELLA_U32, u32.data()), options) == expected);
    CHECK(hash_of(mesh_of(LAMELLA_I64, i64.data(), LAMELLA_U64, u64.data()), options) == expected);
    CHECK(hash_of(mesh_of(LAMELLA_F32, f32.data(), LAMELLA_U64, u64.data()), options) == expected);
    CHECK(hash_of(mesh_of(LAMELLA_I32, i32.data(), LAMELLA_U32, spaced.data(), 20), options) == expected);
    u64[5] = std::uint64_t{1} << 32;
    const lamella_mesh beyond = mesh_of(LAMELLA_F64, f64.data(), LAMELLA_U64, u64.data());
    lamella_result* result = nullptr;
    auto error = fresh<lamella_error>(LAMELLA_ERROR);
    CHECK(lamella_slice(nullptr, &beyond, nullptr, &result, &error) == LAMELLA_INVALID_ARGUMENT);
    CHECK(error.triangle == 1);
    CHECK(result == nullptr);
}

TEST_CASE("a struct that knows fewer fields has the defaults of the rest", "[c]") {
    const lamella_mesh mesh = soup_of(tetrahedron);
    lamella_options whole = options_at(0.5);
    whole.fill_rule = 99;  // would be refused
    lamella_result* result = nullptr;
    CHECK(lamella_slice(nullptr, &mesh, &whole, &result, nullptr) == LAMELLA_INVALID_ARGUMENT);
    whole.struct_size = offsetof(lamella_options, fill_rule);
    const ResultHandle owned = sliced(mesh, whole);

    // The library writes no further than the program's struct, too.
    lamella_view view;
    std::memset(&view, 0x5a, sizeof view);
    view.struct_size = offsetof(lamella_view, points);
    lamella_result_view(owned.get(), &view);
    CHECK(view.layers[0].plane_mm == 0.25);
    CHECK(view.info.layers == 0x5a5a5a5a5a5a5a5aU);
    lamella_init_sized(&view, LAMELLA_VIEW, offsetof(lamella_view, points));
    CHECK(view.info.layers == 0x5a5a5a5a5a5a5a5aU);
}

TEST_CASE("a struct of a later version is taken unless a field is set that is not known", "[c]") {
    struct Later {
        lamella_options known;
        double unknown[4] = {1, 2, 3, 4};
    } later{};
    lamella_init_sized(&later, LAMELLA_OPTIONS, sizeof later);
    later.known.layer_height_mm = 0.5;
    CHECK(later.unknown[3] == 0);
    const lamella_mesh mesh = soup_of(tetrahedron);
    CHECK(hash_of(mesh, later.known) == hash_of(mesh, options_at(0.5)));
    Later other = later;
    later.unknown[3] = 1e-300;
    other.known.reserved = 1;
    for (const Later& refused : {later, other}) {
        lamella_result* result = nullptr;
        auto error = fresh<lamella_error>(LAMELLA_ERROR);
        CHECK(lamella_slice(nullptr, &mesh, &refused.known, &result, &error) == LAMELLA_INVALID_ARGUMENT);
        CHECK(error.message ==
              "lamella_options has a field set that lamella " + std::string(lamella_version()) +
                  " does not know: initialise it by LAMELLA_INIT(&it, LAMELLA_OPTIONS), or use a later version"
                  " of the library");
        CHECK(result == nullptr);
    }
}

TEST_CASE("what C gives wrongly is refused by name", "[c]") {
    const lamella_mesh good = soup_of(tetrahedron);
    struct Asked {
        lamella_mesh mesh;
        lamella_options options;
        lamella_source source;
        lamella_destination to;
    };
    const std::pair<std::function<void(Asked&)>, const char*> cases[] = {
        {[](Asked& it) { it.mesh.struct_size = 0; },
         "struct_size of lamella_mesh is 0: initialise it by LAMELLA_INIT(&it, LAMELLA_MESH)"},
        {[](Asked& it) { it.mesh.struct_size = 0xcccccccc; },
         "struct_size of lamella_mesh is 3435973836: initialise it by LAMELLA_INIT(&it, LAMELLA_MESH)"},
        {[](Asked& it) { it.mesh.vertex_type = 4; }, "vertex_type is 4, but the choices are 0 to 3"},
        {[](Asked& it) { it.mesh.vertices = nullptr; }, "vertices is NULL, but its count is not 0"},
        {[](Asked& it) { it.mesh.mm_per_unit = 0; }, "mm_per_unit must be finite and above 0"},
        {[](Asked& it) { it.options.at_heights = it.options.height_count = 1; },
         "heights_mm is NULL, but its count is not 0"},
        {[](Asked& it) { it.options.side = -1; }, "side is -1, but the choices are 0 to 1"},
        {[](Asked& it) { it.to.result = nullptr; },
         "of result, sink and arrays of a destination exactly one must be set, and 0 are"},
        {[](Asked& it) { it.source.mesh = nullptr; },
         "of mesh, prepared and parts of a source exactly one must be set, and 0 are"},
    };
    for (const auto& [spoil, message] : cases) {
        lamella_result* result = nullptr;
        auto error = fresh<lamella_error>(LAMELLA_ERROR);
        Asked asked{good, options_at(1), fresh<lamella_source>(LAMELLA_SOURCE), into(&result, nullptr, nullptr)};
        asked.source.mesh = &asked.mesh;
        spoil(asked);
        CHECK(lamella_slice_to(nullptr, &asked.to, &asked.source, &asked.options, nullptr, nullptr, &error) ==
              LAMELLA_INVALID_ARGUMENT);
        CHECK(std::string(error.message) == message);
        CHECK(result == nullptr);
    }
    lamella_result* result = nullptr;
    auto error = fresh<lamella_error>(LAMELLA_ERROR);
    CHECK(lamella_slice(nullptr, nullptr, nullptr, &result, &error) == LAMELLA_INVALID_ARGUMENT);
    CHECK(std::string(error.message) == "the mesh is NULL");
    CHECK(lamella_slice(nullptr, &good, nullptr, nullptr, nullptr) == LAMELLA_INVALID_ARGUMENT);
    CHECK(std::string(lamella_status_name(LAMELLA_BAD_PLANES)) == "bad_planes");
    CHECK(std::string(lamella_status_name(99)) == "unknown");
}

TEST_CASE("threads, memory, stop and progress of C are used", "[c][threads]") {
    struct Host {
        std::atomic<int> workers = 0;
        std::atomic<long long> held = 0;
        std::atomic<bool> stopped = false;
        double fraction = 0;
    } host;
    const lamella_memory memory = {&host,
                                   [](void* self, std::size_t bytes, std::size_t alignment) -> void* {
                                       static_cast<Host*>(self)->held += static_cast<long long>(bytes);
                                       return std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
                                   },
                                   &host,
                                   [](void* self, void* block, std::size_t bytes, std::size_t) {
                                       static_cast<Host*>(self)->held -= static_cast<long long>(bytes);
                                       std::free(block);
                                   }};
    auto context = fresh<lamella_context>(LAMELLA_CONTEXT);
    context.memory = &memory;
    context.executor = [](void* self, std::int32_t workers, void (*body)(void*), void* argument) {
        for (int i = 0; i < workers; ++i) {
            ++static_cast<Host*>(self)->workers;
            body(argument);
        }
    };
    context.executor_object = &host;
    context.executor_threads = 3;
    context.stop = [](void* self) -> std::int32_t { return static_cast<Host*>(self)->stopped ? 1 : 0; };
    context.stop_object = &host;
    context.progress = [](void* self, double fraction) { static_cast<Host*>(self)->fraction = fraction; };
    context.progress_object = &host;
    const std::vector<float> sphere = shapes::floats(shapes::octasphere({0, 0, 0}, 20, 6));
    const lamella_mesh mesh = soup_of(sphere);
    const lamella_source source = source_of(mesh);
    const lamella_options options = options_at(0.05);
    {
        const ResultHandle result = sliced(source, options, &context);
        CHECK(host.held > 0);
        CHECK(host.fraction == 1);
        CHECK(host.workers > 0);
        CHECK(lamella_result_hash(result.get()) == hash_of(mesh, options));
    }
    CHECK(host.held == 0);
    lamella_result* result = nullptr;
    const lamella_destination to = into(&result, nullptr, nullptr);
    context.memory_limit_bytes = 1;
    CHECK(lamella_slice_to(nullptr, &to, &source, &options, &context, nullptr, nullptr) == LAMELLA_RESULT_TOO_LARGE);
    host.stopped = true;
    CHECK(lamella_slice_to(nullptr, &to, &source, &options, &context, nullptr, nullptr) == LAMELLA_CANCELLED);
    CHECK(result == nullptr);
    CHECK(host.held == 0);
}

TEST_CASE("regions, contours of segments, checks, welding and audits go through C", "[c]") {
    const std::vector<lamella_point> low = {{0, 0}, {4, 0}, {4, 4}, {0, 4}};
    const std::vector<lamella_point> high = {{2, 2}, {6, 2}, {6, 6}, {2, 6}};
    const lamella_path paths[] = {{low.data(), 4}, {high.data(), 4}};
    auto rules = fresh<lamella_options>(LAMELLA_OPTIONS);
    rules.fill_rule = LAMELLA_FILL_RULE_NON_ZERO;
    lamella_result* made = nullptr;
    REQUIRE(lamella_region_of(paths, 2, &rules, 1, nullptr, &made, nullptr) == LAMELLA_OK);
    const ResultHandle region(made);
    CHECK(view_of(region).info.contours == 1);
    CHECK(view_of(region).info.points == 8);
    auto layer = fresh<lamella_layer_view>(LAMELLA_LAYER_VIEW);
    REQUIRE(lamella_result_layer(made, 0, &layer) == LAMELLA_OK);
    CHECK(lamella_area_mm2(&layer) == 28);
    std::vector<lamella_segment> segments(4);
    for (std::uint64_t i = 0; i < 4; ++i) {
        segments[i].from_key[0] = i;
        segments[i].to_key[0] = (i + 1) % 4;
        segments[i].from = low[i];
        segments[i].to = low[(i + 1) % 4];
    }
    lamella_result* square = nullptr;
    REQUIRE(lamella_assemble(segments.data(), 4, nullptr, &square, nullptr) == LAMELLA_OK);
    const lamella_info counts = view_of(ResultHandle(square)).info;
    CHECK(std::vector{counts.contours, counts.points, counts.segments} == std::vector<std::uint64_t>{1, 4, 4});

    const lamella_mesh mesh = soup_of(tetrahedron);
    const double volume = 9 * 9 * 9 / 6.0;
    lamella_mesh open = mesh;
    open.triangle_count = 3;
    auto found = fresh<lamella_check_result>(LAMELLA_CHECK_RESULT);
    REQUIRE(lamella_check(&mesh, nullptr, 0, nullptr, &found, nullptr) == LAMELLA_OK);
    CHECK(found.closed == 1);
    CHECK(found.clean == 1);
    CHECK(found.volume_mm3 == Approx(volume));
    REQUIRE(lamella_check(&open, nullptr, 0, nullptr, &found, nullptr) == LAMELLA_OK);
    CHECK(found.closed == 0);
    CHECK(found.faults[static_cast<std::size_t>(Fault::boundary_edge)] == 3);
    REQUIRE(lamella_check(&open, nullptr, 1, nullptr, &found, nullptr) == LAMELLA_OK);
    CHECK(found.boundary_edges == 3);
    CHECK(found.clean == 0);

    lamella_welded* handle = nullptr;
    REQUIRE(lamella_weld(&mesh, 0.01, 1, nullptr, &handle, nullptr) == LAMELLA_OK);
    const std::unique_ptr<lamella_welded, Freed> welded(handle);
    auto joined = fresh<lamella_mesh>(LAMELLA_MESH);
    lamella_welded_mesh(handle, &joined);
    CHECK(joined.vertex_count == 4);
    const ResultHandle result = sliced(joined, options_at(0.5));
    CHECK(lamella_result_hash(result.get()) == hash_of(mesh, options_at(0.5)));

    auto judged = fresh<lamella_audit_result>(LAMELLA_AUDIT_RESULT);
    REQUIRE(lamella_audit(result.get(), &mesh, nullptr, &judged, nullptr) == LAMELLA_OK);
    CHECK(judged.volume == LAMELLA_VOLUME_HOLDS);
    CHECK(judged.mesh_mm3 == Approx(volume));
    CHECK(judged.structure == LAMELLA_OK);
    REQUIRE(lamella_audit(sliced(open, options_at(0.5)).get(), nullptr, nullptr, &judged, nullptr) == LAMELLA_OK);
    CHECK(judged.open_layers == 18);
    CHECK(judged.volume == LAMELLA_VOLUME_OPEN_MESH);
}
