// lamella.h: the same bytes as the C++ calls, structs of other sizes, and what is refused.
#include <catch2/catch.hpp>

#include <atomic>
#include <cmath>
#include <cstring>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "engine/c_calls.hpp"
#include "engine/shapes.hpp"
#include "engine/slicing.hpp"
#include "lamella/host_output.hpp"
#include "lamella/lamella.h"
#include "lamella/lamella.hpp"

using namespace c_calls;
using namespace lamella;

namespace {

std::uint64_t hash_in_cpp(const MeshView& mesh, const SliceOptions& options) {
    const SliceResult result = value_of(slice(mesh, options));
    return hash_result(result);
}

}  // namespace

TEST_CASE("a slice by C has the bytes of one by C++", "[c]") {
    SliceOptions options;
    options.plan.spacing = UniformLayers{.layer_height_mm = 0.5};
    const lamella_mesh mesh = soup_of(tetrahedron);
    const ResultHandle result = sliced(mesh, options_at(0.5));
    CHECK(lamella_result_hash(result.get()) == hash_in_cpp(MeshView::soup(tetrahedron), options));
    lamella_view view = view_of(result);
    REQUIRE(view.layer_count == 18);
    CHECK(view.triangles == 4);
    CHECK(view.contours[view.layers[3].first_contour].role == LAMELLA_ROLE_OUTER);
    CHECK(lamella_result_area_mm2(result.get(), 3) == Approx(0.5 * 7.25 * 7.25).epsilon(1e-6));
    CHECK(lamella_result_area_mm2(result.get(), 18) == 0);
}

TEST_CASE("every type of coordinates and indices gives the same slice by C", "[c]") {
    const std::vector<std::int32_t> corners = {0, 0, 0, 9000, 0, 0, 0, 9000, 0, 0, 0, 9000};
    const std::vector<std::uint32_t> indices = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    const auto hash = [&](int type, const void* vertices, int index_type, const void* index, std::size_t index_stride) {
        lamella_mesh mesh = fresh(lamella_mesh_init_sized);
        mesh.coordinate_type = type;
        mesh.vertices = vertices;
        mesh.vertex_count = 4;
        mesh.indices = index;
        mesh.index_type = index_type;
        mesh.index_stride = index_stride;
        mesh.triangle_count = 4;
        mesh.coordinate_mm = 1e-3;
        const ResultHandle result = sliced(mesh, options_at(0.25));
        return lamella_result_hash(result.get());
    };
    const std::vector<std::int64_t> wide(corners.begin(), corners.end());
    const std::vector<double> doubles(corners.begin(), corners.end());
    const std::vector<float> floats(corners.begin(), corners.end());
    const std::vector<std::uint64_t> wide_indices(indices.begin(), indices.end());
    std::vector<std::uint32_t> spaced;
    for (std::size_t t = 0; t < 4; ++t) {
        spaced.insert(spaced.end(), {indices[3 * t], indices[3 * t + 1], indices[3 * t + 2], 77, 78});
    }
    const std::uint64_t expected = hash(LAMELLA_F64, doubles.data(), LAMELLA_INDEX_U32, indices.data(), 0);
    CHECK(hash(LAMELLA_I32, corners.data(), LAMELLA_INDEX_U32, indices.data(), 0) == expected);
    CHECK(hash(LAMELLA_I64, wide.data(), LAMELLA_INDEX_U64, wide_indices.data(), 0) == expected);
    CHECK(hash(LAMELLA_F32, floats.data(), LAMELLA_INDEX_U64, wide_indices.data(), 0) == expected);
    CHECK(hash(LAMELLA_I32, corners.data(), LAMELLA_INDEX_U32, spaced.data(), 20) == expected);
}

TEST_CASE("an index of 64 bits beyond the last vertex is named", "[c]") {
    const std::vector<double> xyz = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const std::vector<std::uint64_t> indices = {0, 1, 2, 0, 1, std::uint64_t{1} << 32};
    lamella_mesh mesh = fresh(lamella_mesh_init_sized);
    mesh.coordinate_type = LAMELLA_F64;
    mesh.vertices = xyz.data();
    mesh.vertex_count = 3;
    mesh.indices = indices.data();
    mesh.index_type = LAMELLA_INDEX_U64;
    mesh.triangle_count = 2;
    lamella_result* result = nullptr;
    lamella_error error = fresh_error();
    CHECK(lamella_slice(&mesh, nullptr, nullptr, &result, &error) == LAMELLA_INVALID_ARGUMENT);
    CHECK(error.triangle == 1);
    CHECK(result == nullptr);
}

TEST_CASE("a struct that knows fewer fields has the defaults of the rest", "[c]") {
    const lamella_mesh mesh = soup_of(tetrahedron);
    lamella_options whole = options_at(0.5);
    whole.memory_limit_bytes = 1;  // would refuse any result
    lamella_result* result = nullptr;
    lamella_error error = fresh_error();
    CHECK(lamella_slice(&mesh, &whole, nullptr, &result, &error) == LAMELLA_RESULT_TOO_LARGE);
    whole.struct_size = offsetof(lamella_options, memory_limit_bytes);
    CHECK(lamella_slice(&mesh, &whole, nullptr, &result, &error) == LAMELLA_OK);
    const ResultHandle owned(result);

    // What is written stays within the program's struct, too.
    lamella_view view;
    std::memset(&view, 0x5a, sizeof view);
    view.struct_size = offsetof(lamella_view, layer_count);
    lamella_result_view(result, &view);
    CHECK(view.unit_mm == default_unit_mm);
    CHECK(view.layer_count == 0x5a5a5a5a5a5a5a5aU);
    lamella_view_init_sized(&view, offsetof(lamella_view, layers));
    CHECK(view.layer_count == 0x5a5a5a5a5a5a5a5aU);
}

TEST_CASE("a struct of a later version is taken unless a field is set that is not known", "[c]") {
    struct Later {
        lamella_options known;
        double unknown[4] = {1, 2, 3, 4};
    } later{};
    lamella_options_init_sized(&later.known, sizeof later);
    later.known.layer_height_mm = 0.5;
    CHECK(later.unknown[3] == 0);
    const lamella_mesh mesh = soup_of(tetrahedron);
    const ResultHandle result = sliced(mesh, later.known);
    CHECK(lamella_result_hash(result.get()) == lamella_result_hash(sliced(mesh, options_at(0.5)).get()));

    const std::string expected =
        "lamella_options has a field set that lamella " + std::string(lamella_version()) +
        " does not know: initialise it by lamella_options_init(), or use a later version of the library";
    lamella_result* refused = nullptr;
    lamella_error error = fresh_error();
    later.unknown[3] = 1e-300;
    CHECK(lamella_slice(&mesh, &later.known, nullptr, &refused, &error) == LAMELLA_INVALID_ARGUMENT);
    CHECK(error.message == expected);
    later.unknown[3] = 0;
    later.known.reserved = 1;
    CHECK(lamella_slice(&mesh, &later.known, nullptr, &refused, &error) == LAMELLA_INVALID_ARGUMENT);
    CHECK(error.message == expected);
    CHECK(refused == nullptr);
}

TEST_CASE("what C gives wrongly is refused by name", "[c]") {
    const lamella_mesh good = soup_of(tetrahedron);
    lamella_result* result = nullptr;
    lamella_error error = fresh_error();
    const auto message = [&](const lamella_mesh* mesh, const lamella_options* options) {
        CHECK(lamella_slice(mesh, options, nullptr, &result, &error) == LAMELLA_INVALID_ARGUMENT);
        CHECK(result == nullptr);
        return std::string(error.message);
    };
    CHECK(message(nullptr, nullptr) == "the mesh is NULL");
    lamella_mesh mesh = good;
    mesh.struct_size = 0;
    CHECK(message(&mesh, nullptr) == "struct_size of lamella_mesh is 0: initialise it by lamella_mesh_init()");
    mesh.struct_size = 0xcccccccc;
    CHECK(message(&mesh, nullptr) == "struct_size of lamella_mesh is 3435973836: initialise it by lamella_mesh_init()");
    mesh = good;
    mesh.coordinate_type = 4;
    CHECK(message(&mesh, nullptr) == "coordinate_type is 4, but the choices are 0 to 3");
    mesh = good;
    mesh.vertices = nullptr;
    CHECK(message(&mesh, nullptr) == "vertices is NULL, but its count is not 0");
    mesh = good;
    mesh.coordinate_mm = 0;
    CHECK(message(&mesh, nullptr) == "coordinate_mm must be finite and above 0");
    lamella_options options = options_at(1);
    options.spacing = 2;
    CHECK(message(&good, &options) == "spacing is 2, but the choices are 0 to 1");
    options = options_at(1);
    options.spacing = LAMELLA_LAYERS_AT_HEIGHTS;
    options.height_count = 1;
    CHECK(message(&good, &options) == "heights_mm is NULL, but its count is not 0");
    options = options_at(1);
    options.side = -1;
    CHECK(message(&good, &options) == "side is -1, but the choices are 0 to 1");
    CHECK(lamella_slice(&good, nullptr, nullptr, nullptr, nullptr) == LAMELLA_INVALID_ARGUMENT);
    CHECK(std::string(lamella_status_name(LAMELLA_BAD_PLANES)) == "bad_planes");
    CHECK(std::string(lamella_status_name(99)) == "unknown");
}

TEST_CASE("heights, rules and gaps go through C", "[c]") {
    const std::vector<double> heights = {7, 1, 1, 4};
    lamella_region_rules rules = fresh(lamella_region_rules_init_sized);
    rules.fill_rule = LAMELLA_FILL_NON_ZERO;
    rules.offset_mm = 0.25;
    lamella_options options = options_at(heights);
    options.region = &rules;
    const lamella_mesh mesh = soup_of(tetrahedron);
    const ResultHandle result = sliced(mesh, options);
    SliceOptions same;
    same.plan.spacing = ExplicitPlanes{heights};
    same.region.fill_rule = FillRule::non_zero;
    same.region.offset_mm = 0.25;
    CHECK(lamella_result_hash(result.get()) == hash_in_cpp(MeshView::soup(tetrahedron), same));
    lamella_view view = view_of(result);
    REQUIRE(view.layer_of_count == 4);
    CHECK(std::vector<std::uint64_t>(view.layer_of, view.layer_of + 4) == std::vector<std::uint64_t>{2, 0, 0, 1});
    // The finest grid leaves room for the offset: 2^-26 mm holds 9 mm, but not three times 2.5 mm more.
    rules.offset_mm = 2.5;
    options.unit_mm = LAMELLA_UNIT_BY_BOX;
    const ResultHandle grown = sliced(mesh, options);
    lamella_result_view(grown.get(), &view);
    CHECK(view.unit_mm == 0x1p-25);
}

TEST_CASE("threads, memory, stop and progress of C are used", "[c][threads]") {
    struct Host {
        std::atomic<int> workers = 0;
        std::atomic<long long> held = 0;
        std::atomic<bool> stopped = false;
        double fraction = 0;
    } host;
    lamella_memory memory = {[](void* self, std::size_t bytes, std::size_t alignment) -> void* {
                                 static_cast<Host*>(self)->held += static_cast<long long>(bytes);
                                 return std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
                             },
                             [](void* self, void* block, std::size_t bytes, std::size_t) {
                                 static_cast<Host*>(self)->held -= static_cast<long long>(bytes);
                                 std::free(block);
                             },
                             &host};
    lamella_control control = fresh(lamella_control_init_sized);
    control.memory = &memory;
    control.executor = [](void* self, std::int32_t workers, void (*body)(void*), void* argument) {
        for (int i = 0; i < workers; ++i) {
            ++static_cast<Host*>(self)->workers;
            body(argument);
        }
    };
    control.executor_context = &host;
    control.executor_threads = 3;
    control.stop = [](void* self) -> std::int32_t { return static_cast<Host*>(self)->stopped ? 1 : 0; };
    control.stop_context = &host;
    control.progress = [](void* self, double fraction) { static_cast<Host*>(self)->fraction = fraction; };
    control.progress_context = &host;
    const std::vector<float> sphere = shapes::floats(shapes::octasphere({0, 0, 0}, 20, 6));
    const lamella_mesh mesh = soup_of(sphere);
    lamella_options options = options_at(0.05);
    options.control = &control;
    {
        const ResultHandle result = sliced(mesh, options);
        CHECK(host.held > 0);
        CHECK(host.fraction == 1);
        CHECK(host.workers > 0);
        CHECK(lamella_result_hash(result.get()) == lamella_result_hash(sliced(mesh, options_at(0.05)).get()));
    }
    CHECK(host.held == 0);
    host.stopped = true;
    lamella_result* result = nullptr;
    CHECK(lamella_slice(&mesh, &options, nullptr, &result, nullptr) == LAMELLA_CANCELLED);
    CHECK(result == nullptr);
    CHECK(host.held == 0);
}

TEST_CASE("prepared meshes, sinks, parts and host arrays go through C", "[c]") {
    const lamella_mesh mesh = soup_of(tetrahedron);
    const lamella_options options = options_at(0.5);
    const ResultHandle expected = sliced(mesh, options);
    const std::uint64_t hash = lamella_result_hash(expected.get());
    lamella_view view = view_of(expected);
    const std::unique_ptr<lamella_workspace, Freed> workspace(lamella_workspace_create());

    SECTION("a prepared mesh gives the same bytes") {
        lamella_prepared* handle = nullptr;
        REQUIRE(lamella_prepare(&mesh, &options, &handle, nullptr) == LAMELLA_OK);
        const std::unique_ptr<lamella_prepared, Freed> prepared(handle);
        lamella_result* result = nullptr;
        REQUIRE(lamella_slice_prepared(handle, &options, workspace.get(), &result, nullptr) == LAMELLA_OK);
        const ResultHandle owned(result);
        CHECK(lamella_result_hash(result) == hash);
        CHECK(lamella_prepared_bytes(handle) >= 4 * 48);
        CHECK(lamella_workspace_bytes(workspace.get()) > 0);
        lamella_workspace_reset(workspace.get());
        CHECK(lamella_workspace_bytes(workspace.get()) == 0);
        CHECK(lamella_slice_prepared(nullptr, &options, nullptr, &result, nullptr) == LAMELLA_INVALID_ARGUMENT);
    }
    SECTION("a sink gets every layer") {
        struct Got {
            std::vector<lamella_point> points;
            std::vector<std::uint64_t> order;
        } got;
        const lamella_sink sink = {[](void* context, const lamella_layer_view* layer) {
                                       auto& into = *static_cast<Got*>(context);
                                       into.order.push_back(layer->index);
                                       into.points.insert(into.points.end(), layer->points,
                                                          layer->points + layer->point_count);
                                   },
                                   &got, LAMELLA_SINK_ASCENDING, 0};
        lamella_totals totals = fresh(lamella_totals_init_sized);
        REQUIRE(lamella_slice_to(&sink, &mesh, &options, workspace.get(), &totals, nullptr) == LAMELLA_OK);
        CHECK(totals.layers == view.layer_count);
        CHECK(got.order.size() == view.layer_count);
        REQUIRE(got.points.size() == view.point_count);
        CHECK(std::memcmp(got.points.data(), view.points, view.point_count * sizeof(lamella_point)) == 0);
        CHECK(lamella_slice_to(nullptr, &mesh, &options, nullptr, nullptr, nullptr) == LAMELLA_INVALID_ARGUMENT);
    }
    SECTION("parts are kept apart") {
        const lamella_mesh* const meshes[] = {&mesh, &mesh};
        std::vector<double> transforms(24, 0);
        for (const std::size_t diagonal : {0U, 5U, 10U, 12U, 17U, 22U}) {
            transforms[diagonal] = 1;
        }
        transforms[15] = 3;  // the second is moved along x
        lamella_result* result = nullptr;
        REQUIRE(lamella_slice_parts(meshes, transforms.data(), 2, &options, LAMELLA_PARTS_SEPARATE, &result, nullptr) ==
                LAMELLA_OK);
        const ResultHandle owned(result);
        lamella_view both = view_of(result);
        CHECK(both.contour_count == 2 * view.contour_count);
        CHECK(both.contours[1].part == 1);
    }
    SECTION("host arrays are filled") {
        lamella_output_bounds bounds = fresh(lamella_output_bounds_init_sized);
        REQUIRE(lamella_bound_output(&mesh, &options, workspace.get(), &bounds, nullptr) == LAMELLA_OK);
        HostArrays<double> host(bounds, LAMELLA_F64);
        host.output.scale = bounds.unit_mm;
        lamella_totals totals = fresh(lamella_totals_init_sized);
        REQUIRE(lamella_slice_into(&host.output, &mesh, &options, workspace.get(), &totals, nullptr) == LAMELLA_OK);
        REQUIRE(totals.points == view.point_count);
        for (std::uint64_t i = 0; i < totals.points; ++i) {
            REQUIRE(host.points[2 * i] == view.points[i].x * view.unit_mm);
            REQUIRE(host.points[2 * i + 1] == view.points[i].y * view.unit_mm);
        }
    }
}

TEST_CASE("regions and assembled contours go through C", "[c]") {
    const std::vector<lamella_point> low = {{0, 0}, {4, 0}, {4, 4}, {0, 4}};
    const std::vector<lamella_point> high = {{2, 2}, {6, 2}, {6, 6}, {2, 6}};
    const lamella_path paths[] = {{low.data(), 4}, {high.data(), 4}};
    lamella_region_rules rules = fresh(lamella_region_rules_init_sized);
    rules.fill_rule = LAMELLA_FILL_NON_ZERO;
    lamella_result* result = nullptr;
    REQUIRE(lamella_region_of(paths, 2, &rules, 1, nullptr, &result, nullptr) == LAMELLA_OK);
    const ResultHandle region(result);
    lamella_view view = view_of(result);
    REQUIRE(view.contour_count == 1);
    CHECK(view.point_count == 8);
    CHECK(lamella_result_area_mm2(result, 0) == 28);

    std::vector<lamella_segment> segments(4);
    for (std::uint64_t i = 0; i < 4; ++i) {
        segments[i].from_key[0] = i;
        segments[i].to_key[0] = (i + 1) % 4;
        segments[i].from = low[i];
        segments[i].to = low[(i + 1) % 4];
    }
    lamella_result* square = nullptr;
    REQUIRE(lamella_assemble(segments.data(), 4, nullptr, &square, nullptr) == LAMELLA_OK);
    const ResultHandle assembled(square);
    lamella_result_view(square, &view);
    CHECK(view.contour_count == 1);
    CHECK(view.point_count == 4);
    CHECK(view.segments == 4);
}
