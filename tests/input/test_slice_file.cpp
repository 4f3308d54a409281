// A file sliced in ranges within a budget of memory gives what slice() gives of the whole mesh, or the same error.
#include <optional>
#include <thread>

#include "engine/calls.hpp"
#include "input/read.hpp"
#include "lamella/io.hpp"

namespace lamella::input_test {

namespace {

/// A part of the memory that a whole slice needs, and how many threads have to do with it.
struct Share {
    std::uint64_t part;
    int threads;
};

#ifdef LAMELLA_TESTS_SANITIZED
constexpr Share shares[] = {{50, 3}};
constexpr std::uint64_t triangles = 15'000;
constexpr double budget_heights_mm[] = {1.0};
constexpr std::uint64_t budget_triangles = 80'000;
#else
constexpr Share shares[] = {{1, 3}, {2, 1}, {10, 3}, {50, 1}, {50, 3}};
constexpr std::uint64_t triangles = 45'000;
constexpr double budget_heights_mm[] = {0.05, 1.0};
constexpr std::uint64_t budget_triangles = 250'000;
#endif

const std::string little = "binary_little_endian";
const std::string big = "binary_big_endian";

Soup soup_of(models::Shape shape, models::Order order, std::uint64_t triangles) {
    const std::vector<float> soup = models::make_soup({.shape = shape, .triangles = triangles, .order = order});
    return {soup.begin(), soup.end()};
}

std::string ply_of(const Soup& soup, const Ply& form) {
    return form(mesh_of(soup));
}

std::filesystem::path made(models::Shape shape, models::Order order, std::uint64_t triangles) {
    std::filesystem::path path = dir / "mesh.stl";
    REQUIRE(models::write_stl({.shape = shape, .triangles = triangles, .order = order}, path).ok());
    return path;
}

struct Ranges {
    SliceResult result;
    MeshStream::Spent spent;
};

Ranges in_ranges(const std::filesystem::path& path, const StreamOptions& stream, const SliceOptions& options,
                 const Context& context = {}, const Tuning& tuning = {}) {
    const MeshStream file = value_of(open_mesh(path, stream));
    SliceResult result = sliced(file, options, context, tuning);
    return {std::move(result), file.spent()};
}

/// The message of opening or slicing the file; empty where it is sliced.
std::string refusal_of(const std::filesystem::path& path, const StreamOptions& stream = {}, const SliceOptions& options = {},
                       const Context& context = {}) {
    const Result<MeshStream> file = open_mesh(path, stream);
    if (!file) {
        return error_of(file).message;
    }
    const auto take = [](const LayerView&) noexcept {};
    const Result<SliceInfo> sliced = Slicer().slice_to(LayerSink{.take = take}, *file, options, context);
    return sliced ? "" : error_of(sliced).message;
}

/// The budget that the refusal of a byte names, or that the vertices alone need.
std::uint64_t least_budget(const std::filesystem::path& path, const SliceOptions& options, const Context& context,
                           const Tuning& tuning = {}) {
    StreamOptions stream{.memory_bytes = 1};
    for (bool vertices = true; vertices;) {
        const MeshStream file = value_of(open_mesh(path, stream));
        Slicer slicer;
        SliceResult result;
        const Result<SliceInfo> refused = slice_tuned(slicer, result, file, options, tuning, context);
        const std::string message = refused ? "" : refused.error().message;
        REQUIRE((refused.ok() || refused.error().code == ErrorCode::out_of_memory));
        vertices = message.find("stay in memory") != std::string::npos;
        stream.memory_bytes = refused ? stream.memory_bytes : std::stoull(message.substr(message.rfind(' ') + 1));
    }
    return stream.memory_bytes;
}

/// At the whole of the need, a half, a tenth and a fiftieth, or as near as the widest layer and the tables allow.
void require_same_at_all_budgets(const std::filesystem::path& path, const SliceOptions& options, const Tuning& tuning) {
    const MeshFile mesh = value_of(read_mesh(path));
    const SliceResult whole = sliced(mesh, options, {}, tuning);
    const std::uint64_t need = 50 * mesh.triangle_count + 48 * whole.info.crossed;  // the file and the crossed triangles
    for (const auto& [part, threads] : shares) {
        const Context context{.threads = threads};
        const std::uint64_t budget = std::max(need / part, least_budget(path, options, context, tuning));
        INFO("1/" << part << " of the need, " << budget << " bytes, " << threads << " threads");
        const SliceResult result = in_ranges(path, {.memory_bytes = budget}, options, context, tuning).result;
        require_same(result, whole);
        CHECK(result.info.options == whole.info.options);
    }
}

/// Open, degenerate, flat and tall facets, with points and needles.
Soup every_kind() {
    Soup soup = shapes::joined({shapes::octasphere({0, 0, 10}, 10, 5), shapes::box({20, 0, 0}, {30, 10, 40}),
                                shapes::box({20, 20, 5}, {30, 30, 10}), shapes::random_soup(3, 400, 40),
                                shapes::random_tetrahedra(5, 200, 20)});
    for (int i = 0; i < 100; ++i) {
        const double at = i / 4.0;
        shapes::append(soup, shapes::triangle({at, at, at}, {at, at, at}, {at, at + 1, 30}));
    }
    soup.resize(soup.size() - 9 * 7);
    return shapes::shuffled(soup, 11);
}

struct Case {
    const char* name;
    Soup soup;
    SliceOptions options;
    Tuning tuning{};
};

std::vector<Case> cases() {
    using enum models::Shape;
    using enum models::Order;
    const Soup tilted = soup_of(torus, random, triangles / 3 * 2);
    const Soup kinds = every_kind();
    const Transform turn = Transform::from_normal(1, 2, 3);
    const std::vector<double> heights{-30, 90, 20.5, 20.5, 1e7, 3, 77.125, 1.5, 60, 60.1, 60.2, 140};
    const PlaneOptions on_faces{.first_height_mm = 0.25};
    return {
        {"in the order of height", soup_of(bone, z, triangles), uniform(0.5)},
        {"in any order", soup_of(gyroid, random, triangles), uniform(0.4)},
        {"facets as tall as the part", soup_of(prism, random, 20'000), uniform(1)},
        {"listed heights, some of them twice and some beyond the mesh", tilted, {.heights_mm = heights}},
        {"random heights", tilted, {}, {.random_heights = RandomHeights{0.05, 3, 7}}},
        {"another datum, side and grid",
         tilted,
         {.layer_height_mm = 0.7, .planes = {.datum = Datum::zero, .side = PlaneSide::above}, .frame = {.grid_mm = 0.001}}},
        {"a transform, another grid", tilted, {.layer_height_mm = 0.7, .frame = {.transform = turn, .grid_mm = 0.001}}},
        {"rules by layer", tilted, {.region = {.fill_from = {{20, FillRule::non_zero}, {70, FillRule::even_odd}}}}},
        {"some layers", tilted, {.layer_height_mm = 0.3, .planes = {.first_layer = 100, .end_layer = 333}}},
        {"facets of every kind", kinds, {.layer_height_mm = 0.25, .planes = on_faces}},
        {"gaps closed",
         kinds,
         {.layer_height_mm = 0.25, .stitch_mm = 0.5, .stitch_direction = StitchDirection::any, .planes = on_faces}},
        {"facets of every kind, on the side above",
         kinds,
         {.layer_height_mm = 0.25, .planes = {.first_height_mm = 0.25, .side = PlaneSide::above}}},
    };
}

}  // namespace

TEST_CASE("a file gives the same layers in ranges, in every format and form", "[slice_file][threads]") {
    const Ply forms[] = {{.encoding = little},
                         {.encoding = big, .coordinate = "double", .index = "uint"},
                         {.encoding = little, .coordinate = "double", .extra_numbers = true},
                         {.encoding = big, .index = "uint", .extra_numbers = true}};
    std::size_t number = 0;
    for (const Case& one : cases()) {
        INFO(one.name);
        require_same_at_all_budgets(dir.write("mesh.stl", binary_stl(one.soup)), one.options, one.tuning);
        const std::string ply = ply_of(one.soup, forms[number++ % std::size(forms)]);
        require_same_at_all_budgets(dir.write("mesh.ply", ply), one.options, one.tuning);
    }
}

TEST_CASE("a file in the order of height is cut as it is read, one in any order is spilled", "[slice_file][threads]") {
    const auto sorted = made(models::Shape::bone, models::Order::z, 300'000);
    const Ranges cut = in_ranges(sorted, {.memory_bytes = 4'000'000}, uniform(0.2), {.threads = 2});
    CHECK(cut.spent.ranges > 4);
    CHECK(cut.spent.spilled_bytes == 0);
    const auto shuffled = made(models::Shape::gyroid, models::Order::random, 300'000);
    const Ranges spilled = in_ranges(shuffled, {.memory_bytes = 3'000'000}, uniform(0.2));
    CHECK(spilled.spent.ranges > 4);
    CHECK(spilled.spent.spilled_bytes > 44 * spilled.result.info.crossed / 2);
}

TEST_CASE("a file written layer by layer is the file of the whole", "[slice_file][write]") {
    const TempFolder folder;
    const auto path = folder.write("mesh.stl", binary_stl(every_kind()));
    const SliceOptions options{.layer_height_mm = 0.25,
                               .planes = {.first_layer = 3, .end_layer = 150},
                               .frame = {.transform = Transform::from_normal(0, 1, 2)}};
    const StreamOptions stream{.memory_bytes = GENERATE(std::uint64_t{1'500'000}, std::uint64_t{50'000'000}),
                               .read = {.mm_per_unit = 2}};
    std::optional<LayerFile> svg;
    std::vector<SliceInfo> begun;
    std::uint64_t layers = 0;
    const auto streamed = folder / "streamed.svg";
    auto begin = [&](const SliceInfo& info) noexcept {
        begun.push_back(info);
        svg = LayerFile::begin(info, streamed).value();
    };
    auto take = [&](const LayerView& view) noexcept {
        svg->add(view);
        ++layers;
    };
    const MeshStream file = value_of(open_mesh(path, stream));
    sliced_to(LayerSink{.take = take, .begin = begin}, file, options);
    REQUIRE(begun.size() == 1);
    CHECK(begun[0].layers == layers);
    CHECK_FALSE(std::filesystem::exists(streamed));
    CHECK(value_of(svg->finish()).layers == layers);

    const SliceResult whole = in_ranges(path, stream, options).result;
    REQUIRE(whole.info.open_contours > 0);
    begun.push_back(value_of(Slicer().outline(file, options)));
    CHECK(begun[1].segments == whole.info.segments);
    CHECK(begun[1].degenerate == whole.info.degenerate);
    for (const SliceInfo& info : begun) {
        CHECK(info.layers == whole.size());
        CHECK(info.options == whole.info.options);
        CHECK(info.box == whole.info.box);
    }
    value_of(write_layers(whole, folder / "whole.svg"));
    CHECK(::bytes_of(streamed) == ::bytes_of(folder / "whole.svg"));
}

TEST_CASE("the engine holds no more than the budget", "[slice_file]") {
    const auto shape = GENERATE(models::Shape::bone, models::Shape::gyroid, models::Shape::sphere, models::Shape::prism);
    const auto order = GENERATE(models::Order::z, models::Order::random);
    const auto path = made(shape, order, shape == models::Shape::prism ? 10'000 : budget_triangles);
    for (const double height : budget_heights_mm) {
        for (const std::uint64_t budget : {3'000'000U, 10'000'000U}) {
            for (const int threads : {1, 2, 4}) {
                CountingMemory memory;
                const auto file = value_of(open_mesh(path, {.memory_bytes = budget}));
                const auto take = [](const LayerView&) noexcept {};
                const SinkOrder order_of_sink = threads == 4 ? SinkOrder::ascending : SinkOrder::any;
                const auto sliced = Slicer().slice_to(LayerSink{.take = take, .order = order_of_sink}, file, uniform(height),
                                                      {.threads = threads, .memory = &memory});
                INFO("layers of " << height << ", budget " << budget << ", " << threads << " threads");
                if (!sliced) {
                    CHECK_THAT(sliced.error().message, Catch::Contains("too small"));
                    continue;
                }
                INFO(file.spent().ranges << " ranges");
                CHECK(memory.peak() <= file.spent().memory_bytes);
            }
        }
    }
}

TEST_CASE("vertices count against the budget", "[slice_file]") {
    const auto soup = soup_of(models::Shape::bone, GENERATE(models::Order::z, models::Order::random), 100'000);
    const auto path = dir.write("mesh.ply", ply_of(soup, {.encoding = little, .coordinate = GENERATE("float", "double")}));
    for (const double height : budget_heights_mm) {
        for (const int threads : {1, 2}) {
            CountingMemory memory;
            const SliceOptions options = uniform(height);
            const StreamOptions stream{.memory_bytes = least_budget(path, options, {.threads = threads})};
            INFO(stream.memory_bytes << " bytes, " << threads << " threads");
            CHECK(refusal_of(path, stream, options, {.threads = threads, .memory = &memory}).empty());
            CHECK(memory.peak() <= stream.memory_bytes);
        }
    }
    check_says(refusal_of(path, {.memory_bytes = 10'000}), "vertices stay in memory, which takes at least");
}

// --- Refusals

TEST_CASE("what cannot be sliced in ranges is refused by name", "[slice_file]") {
    const Soup soup = shapes::box({0, 0, 0}, {5, 5, 5});
    const std::string stl = binary_stl(soup);
    const std::string ply = ply_of(soup, {.encoding = little});
    Soup bad = soup;
    bad[9 * 7 + 4] = std::nan("");
    for (const auto& [name, bytes, says] : {
             std::tuple<std::string, std::string, std::string>{
                 "a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 3\n",
                 "a.obj: is a text OBJ file: only binary STL and PLY can be sliced within a budget of memory; "
                 "'lamella convert MESH -o MESH.ply' makes the latter of it"},
             {"a.stl", "solid a\nfacet normal 0 0 1\nouter loop\n", "is a text STL file"},
             {"a.stl.gz", "\x1f\x8b\x08", "gunzip"},
             {"a.stl", stl.substr(0, 300), "truncated"},
             {"a.stl", "", "is empty"},
             {"a.stl", binary_stl(bad), "a.stl: triangle 7, vertex 1, y is not finite"},
             {"a.ply", replaced(ply, "uchar int", "uchar float"), "'face' has other lists"},
             {"a.ply", replaced(ply, "element face", "element tristrips"), "'tristrips' has other lists"},
             {"a.ply", replaced(ply, "element face 12", "element face 0"), "holds no faces"},
             {"a.ply", replaced(ply, "end_header", "comment " + std::string(70'000, 'a') + "\nend_header"), "64 KiB"},
             {"a.ply", ply_of(soup, {}), "is a text PLY file"},
         }) {
        check_says(refusal_of(dir.write(name, bytes)), says);
    }
    check_says(refusal_of(dir / "none.stl"), "cannot be opened");
    const auto path = dir.write("a.stl", stl);
    check_says(refusal_of(path, {}, {.origins = true}), "origins");
    check_says(refusal_of(path, {}, {.content = LayerContent::upward_faces}), "faces");
    check_says(refusal_of(path, {}, {.planes = {.first_layer = 70, .end_layer = 80}}), "none of the 25 layers");
    check_says(refusal_of(path, {.memory_bytes = 1, .temporary_folder = dir / "none"}), "temporary file in");
}

TEST_CASE("a damaged PLY is refused as in memory", "[slice_file]") {
    const Ply form = GENERATE(Ply{.encoding = little}, Ply{.encoding = big, .coordinate = "double", .extra_numbers = true});
    const std::string good = ply_of(shapes::octasphere({0, 0, 10}, 10, 5), form);
    const std::size_t begin = form.extra_numbers ? 9 : 0;  // of what stands before the list, and after it
    const std::size_t row = 13 + 2 * begin;
    const std::size_t face = good.size() - (8192 - 5000) * row + begin;  // of one in the middle
    const auto refused = [&](const std::string& bytes) { return refusal_of(dir.write("a.ply", bytes)); };
    const auto with = [&](std::size_t at, const std::string& bytes) {
        return std::string(good).replace(at, bytes.size(), bytes);
    };
    std::vector<std::string> as_in_memory{good.substr(0, 90), with(face + 1, "\x7f\x7f\x7f\x7f"),
                                          with(face + 1, "\xff\xff\xff\xff")};
    for (const std::size_t end : {std::size_t{1}, row - 1, row, row + 1, 100 * row, 8192 * row + 5}) {
        as_in_memory.push_back(good.substr(0, good.size() - end));
    }
    as_in_memory.push_back(as_in_memory[1].substr(0, good.size() - 7));
    for (const std::string& bytes : as_in_memory) {
        const std::string message = refused(bytes);
        const auto read = read_mesh(dir / "a.ply");
        CHECK(message == (read ? slice(*read).error().message : read.error().message));
    }
    check_says(refused(with(face, "\4")), "face 5000 has 4 corners: only triangles");
    check_says(refused(with(face, "\2").substr(0, good.size() - 1)), "face 5000 has 2 corners: only triangles");
    const std::string message = refused(with(good.size() - 8192 * row - begin - 8, std::string(8, '\xff')));  // last vertex
    check_says(message, "is not finite");
    check_says(message, slice(*read_mesh(dir / "a.ply")).error().message);
}

// --- What else a slice of a file has in common with one of a mesh

TEST_CASE("what is said about a file in ranges is what reading says of it", "[slice_file]") {
    const std::string ply = ply_of(shapes::box({0, 0, 0}, {5, 5, 5}), {.encoding = little, .comment = "SPACE=RAS"});
    const auto path = dir.write("a.ply", ply + "rest");
    const MeshStream file = value_of(open_mesh(path));
    const MeshFile read = value_of(read_mesh(path));
    CHECK(file.about().warnings == read.warnings);
    CHECK(file.about().patient_frame == read.patient_frame);
    CHECK(file.about().triangle_count == read.triangle_count);
    CHECK(file.about().vertex_count == read.vertex_count);
}

TEST_CASE("a mesh that collapses, or that no plane meets, is sliced as in memory", "[slice_file]") {
    const auto path = dir.write("a.stl", binary_stl(shapes::triangle({1, 1, 1}, {1, 1, 1}, {2, 2, 9})));
    check_says(refusal_of(path), "the triangle has two equal corners");
    CHECK(in_ranges(path, {}, {.allow_empty = true}).result.layers.empty());
    const std::vector<double> heights{1, 2, 3};
    CHECK(in_ranges(path, {}, {.heights_mm = heights, .allow_empty = true}).result.layers.size() == 3);
    const auto box = dir.write("b.stl", binary_stl(shapes::box({0, 0, 0}, {5, 5, 5})));
    const SliceOptions beyond{.layer_height_mm = 500, .planes = {.first_height_mm = 100}};
    CHECK(in_ranges(box, {}, beyond).result.layers.empty());
}

TEST_CASE("a file in ranges can be stopped and reports its progress", "[slice_file]") {
    const auto path = made(models::Shape::sphere, models::Order::random, 100'000);
    const MeshStream file = value_of(open_mesh(path, {.memory_bytes = 2'000'000}));
    require_obedient({"slice of a file in ranges", [&](const Context& c) { return code_of(slice(file, {}, c)); }});
}

TEST_CASE("a file is sliced to every destination, and by two slicers at once", "[slice_file][threads]") {
    const auto path = made(models::Shape::bone, models::Order::random, 20'000);
    const MeshStream file = value_of(open_mesh(path, {.memory_bytes = 1'000'000}));
    const SliceResult whole = sliced(value_of(read_mesh(path)), uniform(0.5));
    require_at_every_destination(whole, file, uniform(0.5));
    std::uint64_t hashes[2] = {};
    std::thread other([&] { hashes[0] = slice(file, uniform(0.5)).value().hash(); });
    hashes[1] = slice(file, uniform(0.5)).value().hash();
    other.join();
    CHECK(hashes[0] == whole.hash());
    CHECK(hashes[1] == whole.hash());
}

}  // namespace lamella::input_test
