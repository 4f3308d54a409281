// Slicing in ranges refuses files that cannot be read in pieces, can be stopped, and reports its progress.
#include <cmath>
#include <string>
#include <thread>
#include <vector>

#include "engine/shapes.hpp"
#include "input/read.hpp"
#include "input/slices_in_ranges.hpp"
#include "lamella/io.hpp"
#include "models/models.hpp"

using namespace lamella;
using namespace lamella::input_test;
using Catch::Contains;

TEST_CASE("what cannot be sliced in ranges is refused by name", "[slice_file]") {
    const shapes::Soup soup = shapes::box({0, 0, 0}, {5, 5, 5});
    const std::string stl = stl_of(soup);
    const std::string at = (dir.path() / "a").string();
    CHECK(refusal_of(dir.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 3\n")) ==
          at + ".obj: is a text OBJ file: only binary STL and PLY can be sliced within a budget of memory; "
               "'lamella convert MESH -o MESH.ply' makes the latter of it");
    CHECK_THAT(refusal_of(dir.write("a.stl", "solid a\nfacet normal 0 0 1\nouter loop\n")), Contains("is a text STL file"));
    CHECK_THAT(refusal_of(dir.write("a.stl.gz", "\x1f\x8b\x08")), Contains("gunzip"));
    CHECK_THAT(refusal_of(dir.write("a.stl", stl.substr(0, 300))), Contains("truncated"));
    CHECK_THAT(refusal_of(dir.write("a.stl", "")), Contains("is empty"));
    CHECK_THAT(refusal_of(dir / "none.stl"), Contains("cannot be opened"));
    const auto with = [&](const SliceOptions& options) { return refusal_of(dir.write("a.stl", stl), {}, options); };
    CHECK_THAT(with({.origins = true}), Contains("origins"));
    CHECK_THAT(with({.content = LayerContent::upward_faces}), Contains("faces"));
    CHECK_THAT(with({.planes = {.first_layer = 70, .end_layer = 80}}), Contains("none of the 25 layers"));
    shapes::Soup bad = soup;
    bad[9 * 7 + 4] = std::nan("");
    CHECK(refusal_of(dir.write("a.stl", stl_of(bad))) == at + ".stl: triangle 7, vertex 1, y is not finite");
    const StreamOptions nowhere{.memory_bytes = 1, .temporary_folder = dir / "none"};
    CHECK_THAT(refusal_of(dir.write("a.stl", stl), nowhere), Contains("temporary file in"));
}

TEST_CASE("a damaged PLY is refused as in memory", "[slice_file]") {
    const PlyVariant form =
        GENERATE(PlyVariant{.encoding = little}, PlyVariant{.encoding = big, .coordinate = "double", .extra_numbers = true});
    const std::string good = ply_of(shapes::octasphere({0, 0, 10}, 10, 5), form);
    const std::size_t begin = form.extra_numbers ? 9 : 0;  // of what stands before the list, and after it
    const std::size_t row = 13 + 2 * begin;
    const std::size_t face = good.size() - (8192 - 5000) * row + begin;  // of one in the middle
    const auto refused = [&](const std::string& bytes) { return refusal_of(dir.write("a.ply", bytes)); };
    const auto require_as_in_memory = [&](const std::string& bytes) {
        const std::string message = refused(bytes);
        const auto read = read_mesh(dir / "a.ply");
        CHECK(message == (read ? slice(*read).error().message : read.error().message));
    };
    for (const std::size_t cut : {std::size_t{1}, row - 1, row, row + 1, 100 * row, 8192 * row + 5}) {
        INFO("ends " << cut << " bytes early");
        require_as_in_memory(good.substr(0, good.size() - cut));
    }
    require_as_in_memory(good.substr(0, 90));
    std::string bad = good;
    bad.replace(face + 1, 4, "\x7f\x7f\x7f\x7f");
    require_as_in_memory(bad);
    require_as_in_memory(bad.substr(0, bad.size() - 7));
    bad.replace(face + 1, 4, "\xff\xff\xff\xff");
    require_as_in_memory(bad);
    bad = good;
    bad[face] = 4;
    CHECK_THAT(refused(bad), Contains("face 5000 has 4 corners: only triangles"));
    bad[face] = 2;
    CHECK_THAT(refused(bad.substr(0, bad.size() - 1)), Contains("face 5000 has 2 corners: only triangles"));
    bad = good;
    bad.replace(good.size() - 8192 * row - begin - 8, 8, std::string(8, '\xff'));  // of the last vertex
    const std::string message = refused(bad);
    CHECK_THAT(message, Contains("is not finite"));
    CHECK_THAT(message, Contains(slice(*read_mesh(dir / "a.ply")).error().message));
}

TEST_CASE("a PLY that cannot be read in pieces is refused by name", "[slice_file]") {
    const auto refused = [&](const std::string& bytes) { return refusal_of(dir.write("a.ply", bytes)); };
    const std::string good = ply_of(shapes::box({0, 0, 0}, {5, 5, 5}), {.encoding = little});
    const auto with = [&](const std::string& from, const std::string& to) {
        return std::string(good).replace(good.find(from), from.size(), to);
    };
    CHECK_THAT(refused(with("uchar int", "uchar float")), Contains("'face' has other lists"));
    CHECK_THAT(refused(with("element face", "element tristrips")), Contains("'tristrips' has other lists"));
    CHECK_THAT(refused(with("element face 12", "element face 0")), Contains("holds no faces"));
    CHECK_THAT(refused(with("end_header", "comment " + std::string(70'000, 'a') + "\nend_header")), Contains("64 KiB"));
    CHECK_THAT(refused(ply_of(shapes::box({0, 0, 0}, {5, 5, 5}), {.encoding = "ascii"})), Contains("is a text PLY file"));
    const auto path = dir.write("a.ply", with("end_header", "comment SPACE=RAS\nend_header") + "rest");
    const MeshStream file = value_of(open_mesh(path));
    const MeshFile read = value_of(read_mesh(path));
    CHECK(file.about().warnings == read.warnings);
    CHECK(file.about().patient_frame == read.patient_frame);
    CHECK(file.about().triangle_count == read.triangle_count);
    CHECK(file.about().vertex_count == read.vertex_count);
}

TEST_CASE("a mesh that collapses, or that no plane meets, is sliced as in memory", "[slice_file]") {
    const shapes::Soup dots = shapes::triangle({1, 1, 1}, {1, 1, 1}, {2, 2, 9});
    const auto path = dir.write("a.stl", stl_of(dots));
    CHECK_THAT(refusal_of(path), Contains("the triangle has two equal corners"));
    SliceOptions options{.allow_empty = true};
    CHECK(in_ranges(path, {}, options).result.layers.empty());
    options.heights_mm = std::vector<double>{1, 2, 3};
    CHECK(in_ranges(path, {}, options).result.layers.size() == 3);
    const auto box = dir.write("b.stl", stl_of(shapes::box({0, 0, 0}, {5, 5, 5})));
    options = uniform(500);
    options.planes.first_height_mm = 100;
    CHECK(in_ranges(box, {}, options).result.layers.empty());
}

TEST_CASE("a file in ranges can be stopped and reports its progress", "[slice_file]") {
    const auto path = made(models::Shape::sphere, models::Order::random, 100'000);
    const StreamOptions stream{.memory_bytes = 2'000'000};
    double last = -1;
    bool rises = true;
    auto show = [&](double fraction) noexcept {
        rises = rises && fraction >= last;
        last = fraction;
    };
    in_ranges(path, stream, {}, {.progress = show});
    CHECK(rises);
    CHECK(last == 1);
    auto stop = []() noexcept { return true; };
    CHECK(refusal_of(path, stream, {}, {.stop = stop}) == "cancelled");
}

TEST_CASE("a file is sliced to a result, to arrays and by two slicers at once", "[slice_file][threads]") {
    const auto path = made(models::Shape::bone, models::Order::random, 20'000);
    const MeshStream file = value_of(open_mesh(path, {.memory_bytes = 1'000'000}));
    const SliceResult whole = sliced(file, uniform(0.5));
    std::vector<Point> points(whole.points.size());
    std::vector<Contour> contours(whole.contours.size());
    std::vector<Layer> layers(whole.layers.size());
    sliced_to(HostArrays{.points = points.data(), .point_capacity = points.size(), .contours = contours, .layers = layers},
              file, uniform(0.5));
    CHECK(std::equal(points.begin(), points.end(), whole.points.begin()));
    std::uint64_t hashes[2] = {};
    std::thread other([&] { hashes[0] = slice(file, uniform(0.5)).value().hash(); });
    hashes[1] = slice(file, uniform(0.5)).value().hash();
    other.join();
    CHECK(hashes[0] == whole.hash());
    CHECK(hashes[1] == whole.hash());
}
