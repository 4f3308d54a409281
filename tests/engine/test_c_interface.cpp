// lamella.h: the same bytes as the C++ calls, structs of other sizes, and what is refused.
#include <catch2/catch.hpp>

#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "engine/c_calls.hpp"
#include "engine/shapes.hpp"
#include "lamella/lamella.h"
#include "lamella/lamella.hpp"

using namespace lamella;
using namespace c_calls;

namespace {

std::uint64_t hash_in_cpp(const Source& mesh, const SliceOptions& options) {
    const Result<SliceResult> result = slice(mesh, options);
    REQUIRE(result);
    return result->hash();
}

}  // namespace

TEST_CASE("a slice by C has the bytes of one by C++", "[c]") {
    const ResultHandle result = sliced(soup_of(tetrahedron), options_at(0.5));
    CHECK(lamella_result_hash(result.get()) == hash_in_cpp(MeshView::soup(tetrahedron), {.layer_height_mm = 0.5}));
    const lamella_view view = view_of(result);
    REQUIRE(view.info.layers == 18);
    CHECK(view.info.triangles == 4);
    CHECK(view.contours[view.layers[3].first_contour].role == LAMELLA_ROLE_OUTER);
    auto layer = fresh<lamella_layer_view>(LAMELLA_LAYER_VIEW);
    REQUIRE(lamella_result_layer(result.get(), 3, &layer) == LAMELLA_OK);
    CHECK(lamella_area_mm2(&layer) == Approx(0.5 * 7.25 * 7.25).epsilon(1e-6));
    CHECK(layer.points == view.points + layer.first_point);
    CHECK(lamella_result_layer(result.get(), 18, &layer) == LAMELLA_INVALID_ARGUMENT);
}

TEST_CASE("every type of coordinates and indices gives the same slice by C", "[c]") {
    const std::vector<std::int32_t> corners = {0, 0, 0, 9000, 0, 0, 0, 9000, 0, 0, 0, 9000};
    const std::vector<std::uint32_t> indices = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    const auto hash = [&](int type, const void* vertices, int index_type, const void* index, std::size_t index_stride) {
        auto mesh = fresh<lamella_mesh>(LAMELLA_MESH);
        mesh.vertex_type = type;
        mesh.vertices = vertices;
        mesh.vertex_count = 4;
        mesh.indices = index;
        mesh.index_type = index_type;
        mesh.index_stride = index_stride;
        mesh.triangle_count = 4;
        mesh.mm_per_unit = 1e-3;
        return lamella_result_hash(sliced(mesh, options_at(0.25)).get());
    };
    const std::vector<std::int64_t> wide(corners.begin(), corners.end());
    const std::vector<double> doubles(corners.begin(), corners.end());
    const std::vector<float> floats(corners.begin(), corners.end());
    const std::vector<std::uint64_t> wide_indices(indices.begin(), indices.end());
    std::vector<std::uint32_t> spaced;
    for (std::size_t t = 0; t < 4; ++t) {
        spaced.insert(spaced.end(), {indices[3 * t], indices[3 * t + 1], indices[3 * t + 2], 77, 78});
    }
    const std::uint64_t expected = hash(LAMELLA_F64, doubles.data(), LAMELLA_U32, indices.data(), 0);
    CHECK(hash(LAMELLA_I32, corners.data(), LAMELLA_U32, indices.data(), 0) == expected);
    CHECK(hash(LAMELLA_I64, wide.data(), LAMELLA_U64, wide_indices.data(), 0) == expected);
    CHECK(hash(LAMELLA_F32, floats.data(), LAMELLA_U64, wide_indices.data(), 0) == expected);
    CHECK(hash(LAMELLA_I32, corners.data(), LAMELLA_U32, spaced.data(), 20) == expected);
}

TEST_CASE("an index of 64 bits beyond the last vertex is named", "[c]") {
    const std::vector<double> xyz = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const std::vector<std::uint64_t> indices = {0, 1, 2, 0, 1, std::uint64_t{1} << 32};
    auto mesh = fresh<lamella_mesh>(LAMELLA_MESH);
    mesh.vertex_type = LAMELLA_F64;
    mesh.vertices = xyz.data();
    mesh.vertex_count = 3;
    mesh.indices = indices.data();
    mesh.index_type = LAMELLA_U64;
    mesh.triangle_count = 2;
    lamella_result* result = nullptr;
    auto error = fresh<lamella_error>(LAMELLA_ERROR);
    CHECK(lamella_slice(nullptr, &mesh, nullptr, &result, &error) == LAMELLA_INVALID_ARGUMENT);
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
    CHECK(lamella_slice(nullptr, &mesh, &whole, &result, nullptr) == LAMELLA_OK);
    const ResultHandle owned(result);

    // The library writes no further than the program's struct, too.
    lamella_view view;
    std::memset(&view, 0x5a, sizeof view);
    view.struct_size = offsetof(lamella_view, points);
    lamella_result_view(result, &view);
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
    const ResultHandle result = sliced(mesh, later.known);
    CHECK(lamella_result_hash(result.get()) == lamella_result_hash(sliced(mesh, options_at(0.5)).get()));

    const std::string expected =
        "lamella_options has a field set that lamella " + std::string(lamella_version()) +
        " does not know: initialise it by LAMELLA_INIT(&it, LAMELLA_OPTIONS), or use a later version"
        " of the library";
    lamella_result* refused = nullptr;
    auto error = fresh<lamella_error>(LAMELLA_ERROR);
    later.unknown[3] = 1e-300;
    CHECK(lamella_slice(nullptr, &mesh, &later.known, &refused, &error) == LAMELLA_INVALID_ARGUMENT);
    CHECK(error.message == expected);
    later.unknown[3] = 0;
    later.known.reserved = 1;
    CHECK(lamella_slice(nullptr, &mesh, &later.known, &refused, &error) == LAMELLA_INVALID_ARGUMENT);
    CHECK(error.message == expected);
    CHECK(refused == nullptr);
}

TEST_CASE("what C gives wrongly is refused by name", "[c]") {
    const lamella_mesh good = soup_of(tetrahedron);
    lamella_result* result = nullptr;
    auto error = fresh<lamella_error>(LAMELLA_ERROR);
    const auto message = [&](const lamella_mesh* mesh, const lamella_options* options) {
        CHECK(lamella_slice(nullptr, mesh, options, &result, &error) == LAMELLA_INVALID_ARGUMENT);
        CHECK(result == nullptr);
        return std::string(error.message);
    };
    CHECK(message(nullptr, nullptr) == "the mesh is NULL");
    lamella_mesh mesh = good;
    mesh.struct_size = 0;
    CHECK(message(&mesh, nullptr) == "struct_size of lamella_mesh is 0: initialise it by LAMELLA_INIT(&it, LAMELLA_MESH)");
    mesh.struct_size = 0xcccccccc;
    CHECK(message(&mesh, nullptr) ==
          "struct_size of lamella_mesh is 3435973836: initialise it by LAMELLA_INIT(&it, LAMELLA_MESH)");
    mesh = good;
    mesh.vertex_type = 4;
    CHECK(message(&mesh, nullptr) == "vertex_type is 4, but the choices are 0 to 3");
    mesh = good;
    mesh.vertices = nullptr;
    CHECK(message(&mesh, nullptr) == "vertices is NULL, but its count is not 0");
    mesh = good;
    mesh.mm_per_unit = 0;
    CHECK(message(&mesh, nullptr) == "mm_per_unit must be finite and above 0");
    const std::vector<double> none;
    lamella_options options = at_heights(none);
    options.heights_mm = nullptr;
    options.height_count = 1;
    CHECK(message(&good, &options) == "heights_mm is NULL, but its count is not 0");
    options = options_at(1);
    options.side = -1;
    CHECK(message(&good, &options) == "side is -1, but the choices are 0 to 1");
    CHECK(lamella_slice(nullptr, &good, nullptr, nullptr, nullptr) == LAMELLA_INVALID_ARGUMENT);
    auto source = source_of(good);
    auto to = into(nullptr, nullptr, nullptr);
    CHECK(lamella_slice_to(nullptr, &to, &source, nullptr, nullptr, nullptr, &error) == LAMELLA_INVALID_ARGUMENT);
    CHECK(std::string(error.message) == "of result, sink and arrays of a destination exactly one must be set, and 0 are");
    to.result = &result;
    source.mesh = nullptr;
    CHECK(lamella_slice_to(nullptr, &to, &source, nullptr, nullptr, nullptr, &error) == LAMELLA_INVALID_ARGUMENT);
    CHECK(std::string(error.message) == "of mesh, prepared and parts of a source exactly one must be set, and 0 are");
    CHECK(std::string(lamella_status_name(LAMELLA_BAD_PLANES)) == "bad_planes");
    CHECK(std::string(lamella_status_name(99)) == "unknown");
}

TEST_CASE("heights, rules and stitches go through C", "[c]") {
    const std::vector<double> heights = {7, 1, 1, 4};
    lamella_options options = at_heights(heights);
    options.fill_rule = LAMELLA_FILL_RULE_NON_ZERO;
    options.offset_mm = 0.25;
    const lamella_mesh mesh = soup_of(tetrahedron);
    const ResultHandle result = sliced(mesh, options);
    SliceOptions same;
    same.heights_mm = heights;
    same.region.fill_rule = FillRule::non_zero;
    same.region.offset_mm = 0.25;
    CHECK(lamella_result_hash(result.get()) == hash_in_cpp(MeshView::soup(tetrahedron), same));
    const lamella_info info = view_of(result).info;
    REQUIRE(info.layer_of_count == 4);
    CHECK(std::vector<std::uint64_t>(info.layer_of, info.layer_of + 4) == std::vector<std::uint64_t>{2, 0, 0, 1});
    // The finest grid leaves room for the offset: 2^-26 mm holds 9 mm, but not three times 2.5 mm more.
    options.offset_mm = 2.5;
    options.grid_mm = LAMELLA_FINEST_GRID;
    CHECK(view_of(sliced(mesh, options)).info.grid_mm == 0x1p-25);

    auto rules = options_at(1);
    const std::vector<float> sphere = shapes::floats(shapes::octasphere({0, 0, 0}, 20, 4));
    const std::uint64_t points = view_of(sliced(soup_of(sphere), rules)).info.points;
    rules.simplify_mm = 0.5;
    CHECK(view_of(sliced(soup_of(sphere), rules)).info.points < points / 2);
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
        const ResultHandle result = sliced_from(source, options, &context);
        CHECK(host.held > 0);
        CHECK(host.fraction == 1);
        CHECK(host.workers > 0);
        CHECK(lamella_result_hash(result.get()) == lamella_result_hash(sliced(mesh, options).get()));
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

TEST_CASE("regions and assembled contours go through C", "[c]") {
    const std::vector<lamella_point> low = {{0, 0}, {4, 0}, {4, 4}, {0, 4}};
    const std::vector<lamella_point> high = {{2, 2}, {6, 2}, {6, 6}, {2, 6}};
    const lamella_path paths[] = {{low.data(), 4}, {high.data(), 4}};
    auto rules = fresh<lamella_options>(LAMELLA_OPTIONS);
    rules.fill_rule = LAMELLA_FILL_RULE_NON_ZERO;
    lamella_result* result = nullptr;
    REQUIRE(lamella_region_of(paths, 2, &rules, 1, nullptr, &result, nullptr) == LAMELLA_OK);
    const ResultHandle region(result);
    const lamella_info info = view_of(region).info;
    CHECK(info.contours == 1);
    CHECK(info.points == 8);
    auto layer = fresh<lamella_layer_view>(LAMELLA_LAYER_VIEW);
    REQUIRE(lamella_result_layer(result, 0, &layer) == LAMELLA_OK);
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
    const ResultHandle assembled(square);
    const lamella_info counts = view_of(assembled).info;
    CHECK(counts.contours == 1);
    CHECK(counts.points == 4);
    CHECK(counts.segments == 4);
}

TEST_CASE("checks, welding and audits go through C", "[c]") {
    const lamella_mesh mesh = soup_of(tetrahedron);
    auto found = fresh<lamella_check_result>(LAMELLA_CHECK_RESULT);
    REQUIRE(lamella_check(&mesh, nullptr, 0, nullptr, &found, nullptr) == LAMELLA_OK);
    CHECK(found.closed == 1);
    CHECK(found.clean == 1);
    CHECK(found.volume_mm3 == Approx(9 * 9 * 9 / 6.0));
    lamella_mesh open = mesh;
    open.triangle_count = 3;
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
    CHECK(lamella_result_hash(result.get()) == lamella_result_hash(sliced(mesh, options_at(0.5)).get()));

    auto judged = fresh<lamella_audit_result>(LAMELLA_AUDIT_RESULT);
    REQUIRE(lamella_audit(result.get(), &mesh, nullptr, &judged, nullptr) == LAMELLA_OK);
    CHECK(judged.volume == LAMELLA_VOLUME_HOLDS);
    CHECK(judged.mesh_mm3 == Approx(9 * 9 * 9 / 6.0));
    CHECK(judged.structure == LAMELLA_OK);
    REQUIRE(lamella_audit(sliced(open, options_at(0.5)).get(), nullptr, nullptr, &judged, nullptr) == LAMELLA_OK);
    CHECK(judged.open_layers == 18);
    CHECK(judged.volume == LAMELLA_VOLUME_OPEN_MESH);
}
