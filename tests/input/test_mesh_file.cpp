// read_mesh() for every format: formats are told apart, gzip is unpacked, units reach every call, changing files are errors.
#include <chrono>

#include <sys/stat.h>

#include "golden/inputs.hpp"
#include "io/read/input_file.hpp"
#include "lamella/io.hpp"
#include "read.hpp"

namespace lamella::input_test {

TEST_CASE("gzip of any form of STL is unpacked", "[input][gzip]") {
    const Soup facets = numbered_facets(3000);
    const bool text = GENERATE(false, true);
    const std::string bytes = text ? text_stl(facets) : binary_stl(facets);
    const auto half = bytes.size() / 2;
    for (const std::string& packed : {gzipped(bytes), gzipped(bytes.substr(0, half)) + gzipped(bytes.substr(half))}) {
        const Contents contents = read(dir.write("a.stl.gz", packed));
        CHECK(contents.triangles == triangles_of(facets));
        CHECK(contents.mesh.compressed);
        CHECK(contents.mesh.text == text);
        CHECK(contents.warnings.empty());
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
    CHECK(error_of(read_mesh("no\nsuch\tfile.stl")).message.starts_with("no?such?file.stl: "));
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

TEST_CASE("a .gz name without gzip data, gzip data without the name, and bytes after them give a warning", "[input][gzip]") {
    const std::string plain = binary_stl(numbered_facets(3));
    const std::string packed = gzipped(plain);
    const std::string unnamed = "is compressed by gzip, which its name does not say";
    for (const auto& [name, bytes, warnings] :
         {std::tuple<std::string, std::string, Texts>{"a.stl", plain, {}},
          {"a.stl.GZ", packed, {}},
          {"a.gz", packed, {}},
          {"a.stl.gz", packed + "tail", {"ignored 4 bytes after the gzip data"}},
          {"a.stl.gz", plain, {"is not compressed by gzip, as its name says"}},
          {"a.stl", packed, {unnamed}},
          {"a", packed, {unnamed}},
          {"a.obj", packed, {unnamed, "is a file of format STL, not OBJ as its name says"}}}) {
        INFO(name);
        CHECK(warnings_of(dir.write(name, bytes)) == warnings);
    }
}

TEST_CASE("gzip data that end too early, are damaged, hold no mesh or more gzip are refused", "[input][gzip]") {
    const std::string packed = gzipped(binary_stl(numbered_facets(40)));
    const auto refused = [](const std::string& bytes, const std::string& says) {
        refuses(dir.write("a.stl.gz", bytes), says, says == "is empty" ? ErrorCode::empty_mesh : ErrorCode::malformed_mesh);
    };
    for (std::size_t length = 2; length < packed.size(); ++length) {
        refused(packed.substr(0, length), "is truncated: its gzip data end too early");
    }
    std::string damaged = packed;
    damaged[packed.size() - 6] ^= 1;  // the checksum
    refused(damaged, "is damaged: no valid gzip data");
    refused("\x1F\x8B" + std::string(100, 'x'), "");
    refused(gzipped(""), "is empty");
    refused(gzipped("<xml>"), "'<xml>'");
    refused(gzipped(packed), "is compressed twice");
}

TEST_CASE("the format of a file is told by its content, and the name of another one gives a warning", "[input]") {
    for (const auto& [name, bytes] : golden::mesh_files()) {
        INFO(name);
        const MeshFile mesh = read_one(dir.write(name, bytes));
        CHECK(mesh.warnings.empty());
        const std::string own(name_of(mesh.format));
        CHECK_THAT(name, Catch::EndsWith("." + own, Catch::CaseSensitive::No));
        const MeshFile unnamed = read_one(dir.write("a", bytes));
        CHECK(unnamed.format == mesh.format);
        CHECK(unnamed.warnings.empty());
        const bool is_stl = mesh.format == MeshFormat::stl;
        CHECK(warnings_of(dir.write(is_stl ? "a.ply" : "a.stl", bytes)) ==
              Texts{"is a file of format " + own + ", not " + (is_stl ? "PLY" : "STL") + " as its name says"});
    }
}

TEST_CASE("an STL file may have any name, and be reached by a link", "[input]") {
    const Soup facets = numbered_facets(20);
    std::filesystem::create_symlink(dir.write("to.stl", binary_stl(facets)), dir / "link.stl");
    CHECK(read_triangles(dir / "link.stl") == triangles_of(facets));
    for (const char* name : {"a", "a.STL", "a.bin", "a.gz"}) {
        CHECK(read_triangles(dir.write(name, binary_stl(facets))) == triangles_of(facets));
        CHECK(read_triangles(dir.write(name, text_stl(facets))) == triangles_of(facets));
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
    std::filesystem::create_directory(dir / "directory.stl");
    REQUIRE(::mkfifo((dir / "fifo.stl").c_str(), 0600) == 0);
    refuses(dir / "missing.stl", "No such file", ErrorCode::unreadable_file);
    refuses(dir / "directory.stl", "is a directory", ErrorCode::unreadable_file);
    refuses(dir / "fifo.stl", "is a FIFO", ErrorCode::unreadable_file);
    refuses("/dev/zero", "is a device", ErrorCode::unreadable_file);
}

TEST_CASE("names that repeat or are cut are told apart", "[input]") {
    const std::vector<std::string> names = {"rib", "rib", "rib (2)", "rib", "\xC3\xA4\xC3\xA4\xC3\xA4", "\xC3\xA4\xC3\xA4"};
    CHECK(distinct_names(names) == Texts{"rib", "rib (2)", "rib (2) (2)", "rib (3)", names[4], names[5]});
    CHECK(distinct_names(std::vector<std::string>(3, "pelvis"), 5) == Texts{"pelvi", "p (2)", "p (3)"});
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
        std::vector<std::byte> bytes(file.size());
        const Error error = error_of(file.read(bytes, Parallel({.threads = 2})));
        CHECK(error.code == ErrorCode::unreadable_file);
        CHECK_THAT(error.message, Catch::Contains("shrank"));
    }
    SECTION("written") {
        std::filesystem::last_write_time(path, std::filesystem::last_write_time(path) + std::chrono::seconds(1));
    }
    CHECK(code_of(file.unchanged()) == ErrorCode::unreadable_file);
}

TEST_CASE("the unit of a file reaches every call that is made on it", "[input][unit]") {
    constexpr double inch_mm = 25.4;
    constexpr double side = 2 * inch_mm;
    const PolygonMesh tetrahedron{{0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0, 2}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
    const MeshFile file = value_of(read_mesh(dir.write("inches.off", off(tetrahedron)), {.mm_per_unit = inch_mm}));
    SliceOptions options = uniform(1, 0x1p-10);
    const SliceResult result = sliced(file, options);
    CHECK(result.size() == 51);
    CHECK(result.info.box.max_mm[2] == Approx(side).margin(0x1p-10));
    const LayerView layer = result[3];
    CHECK(layer.cut_mm() == Approx(layer.plane_mm).margin(2 * 0x1p-10));
    const Contour& contour = layer.contours[0];
    const Point point = layer.points_of(contour)[1];
    CHECK(layer.to_mm(point).x == point.x * 0x1p-10);
    CHECK(layer.to_mm(point).y == point.y * 0x1p-10);
    const double left = side - layer.plane_mm;
    CHECK(layer.area_mm2(contour) == Approx(left * left / 2).epsilon(1e-3));
    CHECK(layer.area_mm2() == layer.area_mm2(contour));
    // A transform is in mm.
    options.frame.transform.m = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 100};
    CHECK(sliced(file, options).info.box.min_mm[2] == 100);
    for (const bool counts_only : {false, true}) {
        const auto found = value_of(check(file.view(), {.counts_only = counts_only}));
        CHECK(found.volume_mm3 == Approx(side * side * side / 6));
        CHECK(found.box.max_mm[0] == Approx(side));
    }
    const auto apart = value_of(weld(file.view(), side - 1));
    CHECK(apart.joined == 0);
    CHECK(sliced(apart, uniform(1)).hash() == sliced(file, uniform(1)).hash());
    const auto welded = value_of(weld(file.view(), side + 1));
    CHECK(welded.joined > 0);
    CHECK(welded.mm_per_unit == inch_mm);
    CHECK(welded.tolerance_mm == side + 1);
}

}  // namespace lamella::input_test
