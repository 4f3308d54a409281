// read_mesh() for every format: formats are told apart, gzip is unpacked, units reach every call, changing files are errors.
#include <chrono>

#include "golden/mesh_files.hpp"
#include "io/read/input_file.hpp"
#include "lamella/io.hpp"
#include "read.hpp"

namespace lamella {
namespace {

using namespace input_test;

std::string gzipped(const std::string& bytes) {
    return deflated(bytes, 16 + MAX_WBITS);
}

TEST_CASE("gzip of any form of STL is unpacked", "[input][gzip]") {
    const std::vector<Facet> facets = numbered_facets(3000);
    const bool text = GENERATE(false, true);
    const std::string bytes = text ? ascii_stl(facets) : binary_stl(facets);
    const auto half = bytes.size() / 2;
    for (const std::string& packed : {gzipped(bytes), gzipped(bytes.substr(0, half)) + gzipped(bytes.substr(half))}) {
        const auto path = dir.write("a.stl.gz", packed);
        CHECK(read_triangles(path) == triangles_of(facets));
        const MeshFile mesh = read_one(path);
        CHECK(mesh.compressed);
        CHECK(mesh.text == text);
        CHECK(mesh.warnings.empty());
    }
}

TEST_CASE("a file with a name given for it is told by its content, and called by that name", "[input][gzip]") {
    const std::string bytes = binary_stl(numbered_facets(10));
    const bool packed = GENERATE(false, true);
    const auto path = dir.write("a.ply", packed ? gzipped(bytes) : bytes);
    CHECK(read_one(path).warnings.size() == (packed ? 2 : 1));
    const MeshFile mesh = value_of(read_mesh(path, {.name = "standard\ninput"}));
    CHECK(mesh.format == MeshFormat::stl);
    CHECK(mesh.compressed == packed);
    CHECK(mesh.warnings.empty());
    CHECK(error_of(read_mesh(dir.write("empty", ""), {.name = "standard\ninput"})).message == "standard?input: is empty");
}

TEST_CASE("files are named as meshes by their extension alone", "[input]") {
    for (const char* const name : {"a.stl", "A.STL", "a.b/c.obj", "a.Vtp", "/a/b.3mf", "a.stl.gz", "a.OFF.GZ", "a.gz.ply"}) {
        INFO(name);
        CHECK(is_named_as_mesh(name));
    }
    for (const char* const name : {"", "stl", ".", "..", "a", "a.", "a.stl/", "a.stl/b", "a.gz", "a.stl.gz.gz", "a.stlx",
                                   "a.tstl", "a.st", "a.stereolitho", ".stl", "a/.stl", "a.b/.stl.gz", ".gz"}) {
        INFO(name);
        CHECK_FALSE(is_named_as_mesh(name));
    }
}

TEST_CASE("bytes after gzip data give a warning", "[input][gzip]") {
    CHECK(warnings_of(dir.write("a.stl.gz", gzipped(binary_stl(numbered_facets(10))) + "tail")) ==
          Texts{"ignored 4 bytes after the gzip data"});
}

TEST_CASE("gzip data that end too early or are damaged are refused", "[input][gzip]") {
    const std::string packed = gzipped(binary_stl(numbered_facets(40)));
    for (std::size_t length = 2; length < packed.size(); ++length) {
        const auto path = dir.write("a.stl.gz", packed.substr(0, length));
        CHECK(refuses(path, "is truncated: its gzip data end too early").code == ErrorCode::malformed_mesh);
    }
    std::string damaged = packed;
    damaged[packed.size() - 6] ^= 1;  // the checksum
    refuses(dir.write("a.stl.gz", damaged), "is damaged: no valid gzip data");
    CHECK(read_error(dir.write("a.stl.gz", std::string("\x1F\x8B") + std::string(100, 'x'))).code ==
          ErrorCode::malformed_mesh);
}

TEST_CASE("unpacked gzip data are recognised by content, and gzip within gzip is refused", "[input][gzip]") {
    refuses(dir.write("a.stl.gz", gzipped("")), "is empty", ErrorCode::empty_mesh);
    refuses(dir.write("a.stl.gz", gzipped("<xml>")), "'<xml>'");
    const auto twice = dir.write("a.stl.gz", gzipped(gzipped(binary_stl(numbered_facets(1)))));
    CHECK(refuses(twice, "is compressed twice").code == ErrorCode::malformed_mesh);
}

TEST_CASE("a .gz name without gzip data, or gzip data without the name, gives a warning", "[input][gzip]") {
    const std::string plain = binary_stl(numbered_facets(3));
    const auto warnings = [&](const std::string& name, const std::string& bytes) {
        return warnings_of(dir.write(name, bytes));
    };
    CHECK(warnings("a.stl", plain).empty());
    CHECK(warnings("a.stl.GZ", gzipped(plain)).empty());
    CHECK(warnings("a.gz", gzipped(plain)).empty());
    CHECK(warnings("a.stl.gz", plain) == Texts{"is not compressed by gzip, as its name says"});
    CHECK(warnings("a.stl", gzipped(plain)) == Texts{"is compressed by gzip, which its name does not say"});
    CHECK(warnings("a", gzipped(plain)) == Texts{"is compressed by gzip, which its name does not say"});
    CHECK(warnings("a.obj", gzipped(plain)).size() == 2);
}

TEST_CASE("the format of a file is told by its content, and the name of another one gives a warning", "[input]") {
    for (const auto& [name, bytes] : golden::mesh_files()) {
        INFO(name);
        const MeshFile mesh = read_one(dir.write(name, bytes));
        CHECK(mesh.warnings.empty());
        const std::string own(name_of(mesh.format));
        CHECK(upper(name.substr(name.find('.') + 1)) == own);
        const MeshFile unnamed = read_one(dir.write("a", bytes));
        CHECK(unnamed.format == mesh.format);
        CHECK(unnamed.warnings.empty());
        const bool is_stl = mesh.format == MeshFormat::stl;
        CHECK(warnings_of(dir.write(is_stl ? "a.ply" : "a.stl", bytes)) ==
              Texts{"is a file of format " + own + ", not " + (is_stl ? "PLY" : "STL") + " as its name says"});
    }
}

TEST_CASE("an STL file may have any name, and be reached by a link", "[input]") {
    const std::vector<Facet> facets = numbered_facets(20);
    std::filesystem::create_symlink(dir.write("to.stl", binary_stl(facets)), dir / "link.stl");
    CHECK(read_triangles(dir / "link.stl") == triangles_of(facets));
    for (const char* name : {"a", "a.STL", "a.bin", "a.gz"}) {
        CHECK(read_triangles(dir.write(name, binary_stl(facets))) == triangles_of(facets));
        CHECK(read_triangles(dir.write(name, ascii_stl(facets))) == triangles_of(facets));
    }
}

TEST_CASE("what is no mesh is named for what it is, under any name", "[input]") {
    for (const char* name : {"a.stl", "a.obj", "a.ply", "a.vtk", "a.3mf", "a.txt"}) {
        refuses(dir.write(name, "<!DOCTYPE html>\r\n<html>\n"), "is an HTML page");
        refuses(dir.write(name, "\n  <HTML>\nv 1 2 3\n"), "is an HTML page");
        refuses(dir.write(name, "version https://git-lfs.github.com/spec/v1\noid sha256:00\n"), "is a Git LFS pointer");
        refuses(dir.write(name, std::string("\xFF\xFEv\0 \0", 6)), "is text in UTF-16");
    }
    refuses(dir.write("a.obj", std::string("v 1 2 3\n\0\1\2", 11)), "no OBJ file as text");
}

TEST_CASE("solids of text STL, and objects or groups of OBJ, are parts of a mesh", "[input]") {
    const std::string solid = ascii_stl(numbered_facets(3));
    const std::string rest = solid.substr(solid.find('\n'));
    CHECK(parts_of(read_one(dir.write("a.stl", "solid a  b " + rest + "\nsolid" + rest))) ==
          "a  b solid 0 3; part 2 solid 3 3; ");
    CHECK(parts_of(read_one(dir.write("a.stl", "solid a\xe4" + rest + "\nsolid a\xe4" + rest))) ==
          "a\xe4 solid 0 3; a\xe4 solid 3 3; ");
    const std::string begin = "v 0 0 0\nv 1 0 0\nv 0 1 1\no a\ng x\nf 1 2 3\n";
    const MeshFile groups = read_one(dir.write("a.obj", begin + "g y z \nf 3 2 1\nf 1 2 3\ng y z\nf 1 3 2"));
    CHECK(parts_of(groups) == "x solid 0 1; y z solid 1 3; ");
    const MeshFile objects = read_one(dir.write("a.obj", begin + "g y\nf 3 2 1\no b\ng x\nf 1 3 2\n"));
    CHECK(parts_of(objects) == "a solid 0 2; b solid 2 1; ");
    const MeshFile unnamed =
        read_one(dir.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 3\no a\nf 3 2 1\no b\nf 1 3 2\n"));
    CHECK(parts_of(unnamed) == "part 1 solid 0 1; a solid 1 1; b solid 2 1; ");
    std::string many = begin;
    for (int i = 0; i < 70'000; ++i) {
        many += i % 2 == 0 ? "g x\n" : "g y\n";
    }
    CHECK(read_one(dir.write("a.obj", many)).warnings.at(0).find("names more than 65536 parts") != std::string::npos);
}

TEST_CASE("names that repeat or are cut are told apart", "[input]") {
    const std::vector<std::string> names = {"rib", "rib", "rib (2)", "rib", "\xC3\xA4\xC3\xA4\xC3\xA4", "\xC3\xA4\xC3\xA4"};
    CHECK(distinct_names(names) == Texts{"rib", "rib (2)", "rib (2) (2)", "rib (3)", names[4], names[5]});
    CHECK(distinct_names(std::vector<std::string>(3, "pelvis"), 5) == Texts{"pelvi", "p (2)", "p (3)"});
}

// --- A file that changes

TEST_CASE("a file that shrinks while it is read is an error", "[input]") {
    const auto path = dir.write("a.stl", std::string(1000, 'x'));
    const InputFile file = value_of(InputFile::open(path));
    std::filesystem::resize_file(path, 10);
    std::vector<std::byte> bytes(file.size());
    const Error error = error_of(file.read(bytes, Parallel({.threads = 2})));
    CHECK(error.code == ErrorCode::unreadable_file);
    CHECK_THAT(error.message, Catch::Contains("shrank"));
}

TEST_CASE("a file that changes after it was opened is an error", "[input]") {
    const auto path = dir.write("a.stl", std::string(1000, 'x'));
    const InputFile file = value_of(InputFile::open(path));
    CHECK(file.unchanged().ok());
    SECTION("grown") {
        std::filesystem::resize_file(path, 2000);
    }
    SECTION("shrunk") {
        std::filesystem::resize_file(path, 10);
    }
    SECTION("written") {
        std::filesystem::last_write_time(path, std::filesystem::last_write_time(path) + std::chrono::seconds(1));
    }
    CHECK(code_of(file.unchanged()) == ErrorCode::unreadable_file);
}

// --- The unit of a file reaches every call that is made on it

/// A tetrahedron of 2 x 2 x 2 units.
constexpr std::string_view off = "OFF\n4 4 0\n0 0 0\n2 0 0\n0 2 0\n0 0 2\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";
constexpr double inch_mm = 25.4;

MeshFile in_inches() {
    return value_of(read_mesh(dir.write("inches.off", off), {.mm_per_unit = inch_mm}));
}

TEST_CASE("slicing a file in inches gives layers in mm, and its transform is in mm", "[input][unit]") {
    const MeshFile file = in_inches();
    SliceOptions options = uniform(1);
    const SliceResult result = sliced(file, options);
    CHECK(result.size() == 51);
    CHECK(result.info.box.max_mm[2] == Approx(2 * inch_mm));
    options.frame.transform.m = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 100};
    const Box box = sliced(file, options).info.box;
    CHECK(box.min_mm[2] == 100);
    CHECK(box.max_mm[2] == Approx(100 + 2 * inch_mm));
}

TEST_CASE("checking and welding a file count in mm", "[input][unit]") {
    const MeshFile file = in_inches();
    const double side = 2 * inch_mm;
    for (const bool counts_only : {false, true}) {
        const auto found = value_of(check(file.view(), {.counts_only = counts_only}));
        CHECK(found.volume_mm3 == Approx(side * side * side / 6));
        CHECK(found.box.max_mm[0] == Approx(side));
    }
    const auto apart = value_of(weld(file.view(), side - 1));
    CHECK(apart.joined == 0);
    const auto welded = value_of(weld(file.view(), side + 1));
    CHECK(welded.joined > 0);
    CHECK(welded.mm_per_unit == inch_mm);
    CHECK(welded.tolerance_mm == side + 1);
    CHECK(sliced(apart, uniform(1)).hash() == sliced(file, uniform(1)).hash());
}

TEST_CASE("points and heights of a result are told in mm", "[input][unit]") {
    const SliceResult result = sliced(in_inches(), uniform(1, 0x1p-10));
    const LayerView layer = result[3];
    CHECK(layer.cut_mm() == Approx(layer.plane_mm).margin(2 * 0x1p-10));
    const Contour& contour = layer.contours[0];
    const Point point = layer.points_of(contour)[1];
    CHECK(layer.to_mm(point).x == point.x * 0x1p-10);
    CHECK(layer.to_mm(point).y == point.y * 0x1p-10);
    const double side = 2 * inch_mm - layer.plane_mm;
    CHECK(layer.area_mm2(contour) == Approx(side * side / 2).epsilon(1e-3));
    CHECK(layer.area_mm2() == layer.area_mm2(contour));
}

}  // namespace
}  // namespace lamella
