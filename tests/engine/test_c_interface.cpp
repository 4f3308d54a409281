// lamella.h: the same bytes as the C++ calls, from any source to any destination; structs of other sizes; what is refused.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <functional>
#include <memory>
#include <new>
#include <string>

#include <catch2/catch.hpp>

#include "engine/c_handles.hpp"
#include "engine/everywhere.hpp"

using namespace lamella;
using namespace c_handles;

namespace {

lamella_mesh soup_of(const std::vector<float>& soup) {
    auto mesh = fresh<lamella_mesh>(LAMELLA_MESH);
    mesh.vertices = soup.data();
    mesh.triangle_count = soup.size() / 9;
    return mesh;
}

lamella_options options_at(double layer_height_mm) {
    auto options = fresh<lamella_options>(LAMELLA_OPTIONS);
    options.layer_height_mm = layer_height_mm;
    return options;
}

lamella_source source_of(const lamella_mesh& mesh) {
    auto source = fresh<lamella_source>(LAMELLA_SOURCE);
    source.mesh = &mesh;
    return source;
}

Owned<lamella_result> c_sliced(const lamella_source& from, const lamella_options& options,
                               const lamella_context* context = nullptr) {
    lamella_result* result = nullptr;
    const lamella_destination to = into(&result, nullptr, nullptr);
    REQUIRE(lamella_slice_to(nullptr, &to, &from, &options, context, nullptr, nullptr) == LAMELLA_OK);
    return Owned<lamella_result>(result);
}
Owned<lamella_result> c_sliced(const lamella_mesh& mesh, const lamella_options& options) {
    return c_sliced(source_of(mesh), options);
}

std::uint64_t hash_of(const lamella_mesh& mesh, const lamella_options& options) {
    return lamella_result_hash(c_sliced(mesh, options).get());
}

/// A tetrahedron of 9 mm.
const std::vector<float> tetrahedron = {0, 0, 0, 0, 9, 0, 9, 0, 0, 0, 0, 0, 9, 0, 0, 0, 0, 9,
                                        0, 0, 0, 0, 0, 9, 0, 9, 0, 9, 0, 0, 0, 9, 0, 0, 0, 9};

template <class T, class Other>
void check_bytes(const T* found, const Array<Other>& expected) {
    static_assert(sizeof(T) == sizeof(Other));
    CHECK((expected.size() == 0 || std::memcmp(found, expected.data(), expected.size() * sizeof(T)) == 0));
}

void check_info(const lamella_info& it, const SliceInfo& expected) {
    CHECK(counters_of(it) == counters_of(expected));
    CHECK(it.grid_mm == expected.grid_mm);
    CHECK(std::equal(it.max_mm, it.max_mm + 3, std::begin(expected.box.max_mm)));
    CHECK(std::vector(it.layer_of, it.layer_of + it.layer_of_count) == expected.layer_of);
    REQUIRE(it.copy_count == expected.copies.size());
    CHECK(std::memcmp(it.copies, expected.copies.data(), it.copy_count * sizeof(lamella_part_copy)) == 0);
}

/// Arrays, areas and islands.
void check_result(const lamella_result* found, const SliceResult& expected) {
    auto view = fresh<lamella_view>(LAMELLA_VIEW);
    lamella_result_view(found, &view);
    check_info(view.info, expected.info);
    CHECK(lamella_result_hash(found) == expected.hash());
    check_bytes(view.points, expected.points);
    check_bytes(view.contours, expected.contours);
    check_bytes(view.origins, expected.origins);
    auto layer = fresh<lamella_layer_view>(LAMELLA_LAYER_VIEW);
    for (const LayerView own : expected) {
        REQUIRE(lamella_result_layer(found, own.index, &layer) == LAMELLA_OK);
        CHECK(lamella_area_mm2(&layer) == own.area_mm2());
        CHECK(layer.layer.plane_mm == own.plane_mm);
        CHECK((layer.point_count == 0 || layer.points == view.points + layer.first_point));
        lamella_island island;
        std::uint64_t at = 0;
        for (const Island expected_island : own.islands()) {
            REQUIRE(lamella_next_island(layer.contours, layer.layer.contour_count, &at, &island) != 0);
            CHECK(island.hole_count == expected_island.holes.size());
            CHECK(lamella_contour_area_mm2(island.outer, layer.grid_mm) == own.area_mm2(*expected_island.outer));
        }
        CHECK(lamella_next_island(layer.contours, layer.layer.contour_count, &at, &island) == 0);
    }
    CHECK(lamella_result_layer(found, expected.size(), &layer) == LAMELLA_INVALID_ARGUMENT);
}

/// Requires that every destination gets `expected` by C.
void check_destinations(const lamella_source& source, const lamella_options& options, const SliceResult& expected) {
    const Owned<lamella_slicer> slicer(lamella_slicer_create());
    const auto slice_to = [&](const lamella_destination& to) {
        auto info = fresh<lamella_info>(LAMELLA_INFO);
        REQUIRE(lamella_slice_to(slicer.get(), &to, &source, &options, nullptr, &info, nullptr) == LAMELLA_OK);
        check_info(info, expected.info);
    };
    lamella_result* result = nullptr;
    slice_to(into(&result, nullptr, nullptr));
    check_result(Owned<lamella_result>(result).get(), expected);

    auto outline = fresh<lamella_info>(LAMELLA_INFO);
    REQUIRE(lamella_outline(slicer.get(), &source, &options, nullptr, &outline, nullptr) == LAMELLA_OK);
    CHECK(outline.layers == expected.size());
    CHECK(lamella_slicer_bytes(slicer.get()) > 0);

    struct Compared {
        const SliceResult& expected;
        std::uint64_t layers = 0;
        bool same = true;
    } compared{expected};
    auto sink = fresh<lamella_sink>(LAMELLA_SINK);
    sink.object = &compared;
    sink.take = [](void* object, const lamella_layer_view* layer) {
        auto& self = *static_cast<Compared*>(object);
        const LayerView own = self.expected[layer->index];
        self.same = self.same && layer->index == self.layers++ && layer->layer.contour_count == own.contour_count &&
                    layer->point_count == own.points.size() && (layer->origins != nullptr) == !own.origins.empty() &&
                    std::memcmp(layer->points, own.points.data(), own.points.size_bytes()) == 0 &&
                    std::memcmp(layer->origins, own.origins.data(), own.origins.size_bytes()) == 0;
    };
    slice_to(into(nullptr, &sink, nullptr));
    CHECK((compared.same && compared.layers == expected.size()));

    GuardedArrays host(expected);
    auto arrays = fresh<lamella_arrays>(LAMELLA_ARRAYS);
    arrays.points = host.arrays.points;
    arrays.contours = reinterpret_cast<lamella_contour*>(host.arrays.contours.data());
    arrays.layers = reinterpret_cast<lamella_layer*>(host.arrays.layers.data());
    arrays.origins = reinterpret_cast<lamella_point_origin*>(host.arrays.origins.data());
    arrays.point_capacity = host.arrays.point_capacity;
    arrays.contour_capacity = host.arrays.contours.size();
    arrays.layer_capacity = host.arrays.layers.size();
    slice_to(into(nullptr, nullptr, &arrays));
    host.require_hold(expected);
    lamella_slicer_reset(slicer.get());
    CHECK(lamella_slicer_bytes(slicer.get()) == 0);
    CHECK(lamella_slicer_make_ready(slicer.get(), 1000, nullptr, nullptr) == LAMELLA_OK);
    CHECK(lamella_slicer_bytes(slicer.get()) >= 48000);
}

}  // namespace

TEST_CASE("any source goes to any destination by C, with the bytes of C++, whatever is asked", "[c]") {
    using namespace shapes;
    const std::vector<float> soup =  // with a hole, and another island
        floats(joined({octasphere({1, 2, 3}, 20, 3), flipped(octasphere({1, 2, 3}, 9, 2)), box({30, 0, 0}, {33, 3, 9})}));
    const std::vector<double> heights = {7, 1, 1, 4};
    const lamella_slab slabs[] = {{1, 4}, {4, 5}};
    const auto listed = [&](lamella_options& it) {
        it.at_heights = 1;
        it.heights_mm = heights.data();
        it.height_count = heights.size();
    };
    const std::pair<std::function<void(lamella_options&)>, SliceOptions> cases[] = {
        {[](lamella_options& it) { it.layer_height_mm = 0.5; }, {.layer_height_mm = 0.5}},
        {[](lamella_options& it) { it.origins = 1; }, {.origins = true}},
        {[](lamella_options& it) { it.content = LAMELLA_LAYER_CONTENT_UPWARD_FACES; },
         {.content = LayerContent::upward_faces}},
        {[](lamella_options& it) { it.content = LAMELLA_LAYER_CONTENT_DOWNWARD_FACES; },
         {.content = LayerContent::downward_faces}},
        {[](lamella_options& it) { it.simplify_mm = 0.5; }, {.region = {.simplify_mm = 0.5}}},
        {[&](lamella_options& it) {
             listed(it);
             it.fill_rule = LAMELLA_FILL_RULE_NON_ZERO;
             it.offset_mm = 0.25;
         },
         {.heights_mm = heights, .region = {.fill_rule = FillRule::non_zero, .offset_mm = 0.25}}},
        {[&](lamella_options& it) {
             it.slabs = slabs;
             it.slab_count = 2;
         },
         {.slabs = {{1, 4}, {4, 5}}}},
        // The finest grid leaves room for the offset.
        {[](lamella_options& it) {
             it.fill_rule = LAMELLA_FILL_RULE_NON_ZERO;
             it.offset_mm = 2.5;
             it.grid_mm = LAMELLA_FINEST_GRID;
         },
         {.frame = {.grid_mm = finest_grid}, .region = {.fill_rule = FillRule::non_zero, .offset_mm = 2.5}}},
    };
    const lamella_mesh mesh = soup_of(soup);
    const MeshView view = MeshView::soup(soup);
    Part moved{.mesh = view};
    moved.placement.m[3] = 50;
    const Part both[] = {{.mesh = view}, moved};
    const lamella_part parts[2] = {{&mesh, {}}, {&mesh, {1, 0, 0, 50, 0, 1, 0, 0, 0, 0, 1, 0}}};
    for (const auto& [in_c, in_cpp] : cases) {
        lamella_options options = fresh<lamella_options>(LAMELLA_OPTIONS);
        in_c(options);
        lamella_source source = source_of(mesh);
        check_destinations(source, options, slice(view, in_cpp).value());
        if (in_cpp.content != LayerContent::section) {
            options.origins = 1;
            lamella_result* refused = nullptr;
            CHECK(lamella_slice(nullptr, &mesh, &options, &refused, nullptr) == LAMELLA_INVALID_ARGUMENT);
            continue;
        }
        source.mesh = nullptr;
        source.parts = parts;
        source.part_count = 2;
        check_destinations(source, options, slice(both, in_cpp).value());
        lamella_prepared* handle = nullptr;
        REQUIRE(lamella_prepare(&mesh, &options, nullptr, &handle, nullptr) == LAMELLA_OK);
        const Owned<lamella_prepared> prepared(handle);
        const lamella_prepared* const first[] = {handle, nullptr};
        source.part_prepared = options.grid_mm == 0 ? first : nullptr;  // else that of both parts is coarser
        check_destinations(source, options, slice(both, in_cpp).value());
        source.part_prepared = nullptr;
        source.parts = nullptr;
        source.part_count = 0;
        CHECK(lamella_prepared_bytes(handle) >= mesh.triangle_count * 12);
        source.prepared = handle;
        check_destinations(source, options, slice(prepare(view, in_cpp.frame).value(), in_cpp).value());
    }
    // What is negative takes something away only within its object.
    std::int32_t roles[] = {LAMELLA_SOLID, LAMELLA_SOLID, LAMELLA_NEGATIVE};
    const std::uint32_t objects[] = {3, 0, 0};
    const lamella_part three[] = {parts[0], parts[1], {&mesh, {0.5, 0, 0, 51, 0, 0.5, 0, 1, 0, 0, 0.5, 0}}};
    lamella_source cut{sizeof cut, 0, nullptr, nullptr, three, 3, roles, objects, nullptr, nullptr, nullptr};
    const Transform half{{0.5, 0, 0, 51, 0, 0.5, 0, 1, 0, 0, 0.5, 0}};
    Part holed[] = {{.mesh = view, .object = 3}, moved, {view, half, PartRole::negative}};
    check_destinations(cut, fresh<lamella_options>(LAMELLA_OPTIONS), slice(holed).value());
    const std::array<double, 3> stands[] = {{0, 90, 0}, {0, -90, 0}};
    const double* const places[] = {stands[0].data(), nullptr, nullptr};
    const std::size_t place_counts[] = {2, 7, 7};
    holed[0].at_mm = stands;
    cut.part_places = places;
    cut.part_place_counts = place_counts;
    for (const bool share : {false, true}) {
        auto options = fresh<lamella_options>(LAMELLA_OPTIONS);
        options.share_copies = share ? 1 : 0;
        check_destinations(cut, options, slice(holed, {.share_copies = share}).value());
    }
    roles[1] = 9;
    CHECK(lamella_outline(nullptr, &cut, nullptr, nullptr, nullptr, nullptr) == LAMELLA_INVALID_ARGUMENT);
    // A slicer that ends with the call keeps no list.
    const lamella_source source = source_of(mesh);
    auto options = fresh<lamella_options>(LAMELLA_OPTIONS);
    listed(options);
    auto info = fresh<lamella_info>(LAMELLA_INFO);
    REQUIRE(lamella_outline(nullptr, &source, &options, nullptr, &info, nullptr) == LAMELLA_OK);
    CHECK(info.layer_of_count == 0);
    std::uint64_t at = 0;
    lamella_island island;
    CHECK(lamella_next_island(nullptr, 0, &at, &island) == 0);
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
    auto mesh = fresh<lamella_mesh>(LAMELLA_MESH);
    mesh.vertex_count = mesh.triangle_count = 4;
    mesh.mm_per_unit = 1e-3;
    const std::uint64_t expected = hash_of(soup_of(tetrahedron), options_at(0.25));
    const auto check_same = [&](int type, const void* vertices, int index_type, const void* indices, std::size_t stride) {
        mesh.vertex_type = type;
        mesh.vertices = vertices;
        mesh.index_type = index_type;
        mesh.indices = indices;
        mesh.index_stride = stride;
        CHECK(hash_of(mesh, options_at(0.25)) == expected);
    };
    check_same(LAMELLA_F64, f64.data(), LAMELLA_U32, u32.data(), 0);
    check_same(LAMELLA_I32, i32.data(), LAMELLA_U32, spaced.data(), 20);
    check_same(LAMELLA_I64, i64.data(), LAMELLA_U64, u64.data(), 0);
    check_same(LAMELLA_F32, f32.data(), LAMELLA_U64, u64.data(), 0);
    u64[5] = std::uint64_t{1} << 32;
    lamella_result* result = nullptr;
    auto error = fresh<lamella_error>(LAMELLA_ERROR);
    CHECK(lamella_slice(nullptr, &mesh, nullptr, &result, &error) == LAMELLA_INVALID_ARGUMENT);
    CHECK(error.triangle == 1);
    CHECK(result == nullptr);
}

TEST_CASE("a struct that knows fewer fields has the defaults of the rest, one with more must leave them alone", "[c]") {
    const lamella_mesh mesh = soup_of(tetrahedron);
    lamella_options whole = options_at(0.5);
    whole.fill_rule = 99;  // would be refused
    lamella_result* result = nullptr;
    CHECK(lamella_slice(nullptr, &mesh, &whole, &result, nullptr) == LAMELLA_INVALID_ARGUMENT);
    whole.struct_size = offsetof(lamella_options, fill_rule);
    const Owned<lamella_result> owned = c_sliced(mesh, whole);

    // The library writes no further than the program's struct, too.
    lamella_view view;
    std::memset(&view, 0x5a, sizeof view);
    view.struct_size = offsetof(lamella_view, points);
    lamella_result_view(owned.get(), &view);
    CHECK(view.layers[0].plane_mm == 0.25);
    lamella_init_sized(&view, LAMELLA_VIEW, offsetof(lamella_view, points));
    CHECK(view.info.layers == 0x5a5a5a5a5a5a5a5aU);

    struct Later {
        lamella_options known;
        double unknown[4] = {1, 2, 3, 4};
    } later{};
    lamella_init_sized(&later, LAMELLA_OPTIONS, sizeof later);
    later.known.layer_height_mm = 0.5;
    CHECK(later.unknown[3] == 0);
    CHECK(hash_of(mesh, later.known) == hash_of(mesh, options_at(0.5)));
    Later other = later;
    later.unknown[3] = 1e-300;
    other.known.reserved = 1;
    for (const Later& refused : {later, other}) {
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
                                       return ::operator new (bytes, std::align_val_t{alignment}, std::nothrow);
                                   },
                                   &host,
                                   [](void* self, void* block, std::size_t bytes, std::size_t alignment) {
                                       static_cast<Host*>(self)->held -= static_cast<long long>(bytes);
                                       ::operator delete (block, std::align_val_t{alignment});
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
        const Owned<lamella_result> result = c_sliced(source, options, &context);
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
    const Owned<lamella_result> region(made);
    auto layer = fresh<lamella_layer_view>(LAMELLA_LAYER_VIEW);
    REQUIRE(lamella_result_layer(made, 0, &layer) == LAMELLA_OK);
    CHECK(lamella_area_mm2(&layer) == 28);
    std::vector<lamella_segment> segments(4);
    for (std::uint64_t i = 0; i < 4; ++i) {
        segments[i] = {{i, 0, 0}, {(i + 1) % 4, 0, 0}, low[i], low[(i + 1) % 4], 0, 0};
    }
    lamella_result* square = nullptr;
    REQUIRE(lamella_assemble(segments.data(), 4, nullptr, &square, nullptr) == LAMELLA_OK);
    auto assembled = fresh<lamella_layer_view>(LAMELLA_LAYER_VIEW);
    REQUIRE(lamella_result_layer(square, 0, &assembled) == LAMELLA_OK);
    CHECK((assembled.layer.contour_count == 1 && assembled.point_count == 4));
    lamella_result_free(square);

    const lamella_mesh mesh = soup_of(tetrahedron);
    const double volume = 9 * 9 * 9 / 6.0;
    lamella_mesh open = mesh;
    open.triangle_count = 3;
    auto found = fresh<lamella_check_result>(LAMELLA_CHECK_RESULT);
    REQUIRE(lamella_check(&mesh, nullptr, 0, nullptr, &found, nullptr) == LAMELLA_OK);
    CHECK((found.closed == 1 && found.clean == 1));
    CHECK(found.volume_mm3 == Approx(volume));
    REQUIRE(lamella_check(&open, nullptr, 0, nullptr, &found, nullptr) == LAMELLA_OK);
    CHECK((found.closed == 0 && found.clean == 0));
    CHECK(found.faults[static_cast<std::size_t>(Fault::boundary_edge)] == 3);
    REQUIRE(lamella_check(&open, nullptr, 1, nullptr, &found, nullptr) == LAMELLA_OK);
    CHECK(found.boundary_edges == 3);

    lamella_welded* handle = nullptr;
    REQUIRE(lamella_weld(&mesh, 0.01, 1, nullptr, &handle, nullptr) == LAMELLA_OK);
    const Owned<lamella_welded> welded(handle);
    auto joined = fresh<lamella_mesh>(LAMELLA_MESH);
    lamella_welded_mesh(handle, &joined);
    CHECK(joined.vertex_count == 4);
    CHECK(hash_of(joined, options_at(0.5)) == hash_of(mesh, options_at(0.5)));

    auto judged = fresh<lamella_audit_result>(LAMELLA_AUDIT_RESULT);
    REQUIRE(lamella_audit(c_sliced(mesh, options_at(0.5)).get(), &mesh, nullptr, &judged, nullptr) == LAMELLA_OK);
    CHECK((judged.volume == LAMELLA_VOLUME_HOLDS && judged.structure == LAMELLA_OK));
    CHECK(judged.mesh_mm3 == Approx(volume));
    REQUIRE(lamella_audit(c_sliced(open, options_at(0.5)).get(), nullptr, nullptr, &judged, nullptr) == LAMELLA_OK);
    CHECK(judged.open_layers == 18);
    CHECK((judged.volume == LAMELLA_VOLUME_NOT_ASKED && std::isnan(judged.mesh_mm3)));

    // What no call has filled claims nothing.
    judged = fresh<lamella_audit_result>(LAMELLA_AUDIT_RESULT);
    CHECK((judged.volume == LAMELLA_VOLUME_NOT_ASKED && judged.structure != LAMELLA_OK));
    judged.struct_size = found.struct_size = layer.struct_size = 0;
    lamella_info info{};
    const lamella_source source = source_of(mesh);
    const lamella_destination to = into(&made, nullptr, nullptr);
    for (const std::int32_t status :
         {lamella_audit(made, nullptr, nullptr, &judged, nullptr),
          lamella_check(&mesh, nullptr, 0, nullptr, &found, nullptr), lamella_result_layer(made, 0, &layer),
          lamella_slice_to(nullptr, &to, &source, nullptr, nullptr, &info, nullptr),
          lamella_outline(nullptr, &source, nullptr, nullptr, &info, nullptr)}) {
        CHECK(status == LAMELLA_INVALID_ARGUMENT);
    }
}
