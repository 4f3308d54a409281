#include <algorithm>
#include <string>

#include <catch2/catch.hpp>

#include "engine/shapes.hpp"
#include "ply_writer.hpp"
#include "read.hpp"

namespace lamella::ply_test {

using namespace input_test;

using Catch::Contains;

namespace {

const shapes::Indexed& cube() {
    static const shapes::Indexed mesh = shapes::indexed(shapes::box({1, 2, 3}, {21, 22, 23}));
    return mesh;
}

/// Nine numbers a triangle, as they were read.
shapes::Soup soup_of(const MeshFile& mesh) {
    shapes::Soup soup;
    for (const std::array<double, 9>& triangle : input_test::triangles_of(mesh)) {
        soup.insert(soup.end(), triangle.begin(), triangle.end());
    }
    return soup;
}

MeshFile read_ply_file(const std::filesystem::path& path, int threads = 1) {
    Result<MeshFile> mesh = read_mesh(path, {.control = {.threads = threads}});
    INFO((mesh ? "" : mesh.error().message));
    REQUIRE(mesh.ok());
    CHECK(mesh->format == MeshFormat::ply);
    return std::move(mesh).value();
}

/// The triangles of a file that must be readable.
shapes::Soup read_soup(const std::filesystem::path& path) {
    return same_every_way(path, [](const MeshFile& mesh) { return soup_of(mesh); });
}

shapes::Soup read_soup(const TempFolder& dir, const std::string& bytes) {
    return read_soup(dir.write("a.ply", bytes));
}

shapes::Soup soup_of(const shapes::Indexed& mesh) {
    shapes::Soup soup;
    for (const std::uint32_t index : mesh.indices) {
        soup.insert(soup.end(), mesh.xyz.begin() + 3 * index, mesh.xyz.begin() + 3 * index + 3);
    }
    return soup;
}

double volume_of(const shapes::Soup& soup) {
    double volume = 0;
    for (std::size_t t = 0; t < soup.size(); t += 9) {
        const double* p = soup.data() + t;
        volume +=
            p[0] * (p[4] * p[8] - p[5] * p[7]) + p[1] * (p[5] * p[6] - p[3] * p[8]) + p[2] * (p[3] * p[7] - p[4] * p[6]);
    }
    return volume / 6;
}

}  // namespace

TEST_CASE("PLY of every encoding and type of number gives the same mesh", "[input][ply]") {
    const TempFolder dir;
    const shapes::Soup expected = soup_of(cube());
    const std::string_view encoding = GENERATE(from_range(ply_encodings));
    const std::size_t coordinate = GENERATE(range<std::size_t>(0, 8));
    for (std::size_t count = 0; count < 8; ++count) {
        for (std::size_t index = 0; index < 8; ++index) {
            PlyVariant how;
            how.encoding = encoding;
            how.coordinate = count % 2 == 0 ? ply_types[coordinate] : ply_sized_types[coordinate];
            how.count = index % 2 == 0 ? ply_types[count] : ply_sized_types[count];
            how.index = count % 2 == 0 ? ply_types[index] : ply_sized_types[index];
            CAPTURE(how.encoding, how.coordinate, how.count, how.index);
            CHECK(read_soup(dir, ply(how, cube())) == expected);
        }
    }
}

TEST_CASE("PLY elements and properties in any order, with unknown ones between, give the same mesh", "[input][ply]") {
    const TempFolder dir;
    const shapes::Soup expected = soup_of(cube());
    PlyVariant how;
    how.encoding = GENERATE(from_range(ply_encodings));
    how.coordinate = GENERATE(as<std::string_view>(), "float", "double", "short");
    how.faces_first = GENERATE(false, true);
    how.index_name = how.faces_first ? "vertex_index" : "vertex_indices";
    for (int extras = 0; extras < 8; ++extras) {
        how.extra_numbers = (extras & 1) != 0;
        how.extra_lists = (extras & 2) != 0;
        how.extra_elements = (extras & 4) != 0;
        how.axes = {0, 1, 2};
        do {
            CAPTURE(how.encoding, how.coordinate, how.faces_first, extras, how.axes);
            CHECK(read_soup(dir, ply(how, cube())) == expected);
        } while (std::next_permutation(how.axes.begin(), how.axes.end()));
    }
}

TEST_CASE("PLY slices to the same bytes as STL", "[input][ply]") {
    const TempFolder dir;
    std::vector<Facet> facets;
    const shapes::Soup soup = soup_of(cube());
    for (std::size_t t = 0; t < soup.size(); t += 9) {
        Facet& facet = facets.emplace_back();
        std::copy_n(soup.begin() + static_cast<std::ptrdiff_t>(t), 9, facet.begin());
    }
    const std::uint64_t expected = hash_of(dir.write("a.stl", binary_stl(facets)));
    for (const std::string_view encoding : ply_encodings) {
        for (const std::string_view type : ply_types) {
            for (const bool faces_first : {false, true}) {
                PlyVariant how;
                how.encoding = encoding;
                how.coordinate = type;
                how.faces_first = faces_first;
                CAPTURE(encoding, type, faces_first);
                CHECK(hash_of(dir.write("a.ply", ply(how, cube()))) == expected);
            }
        }
    }
}

TEST_CASE("PLY coordinates keep their precision", "[input][ply]") {
    const TempFolder dir;
    const std::string_view encoding = GENERATE(from_range(ply_encodings));
    const auto read = [&](std::string_view type, double x) {
        PlyVariant how;
        how.encoding = encoding;
        how.coordinate = type;
        const MeshFile mesh = read_ply_file(dir.write("a.ply", ply(how, {x, 0, 0, 1, 0, 0, 0, 1, 0}, {{0, 1, 2}})));
        CHECK((mesh.coordinate_type == CoordinateType::f64) == (type == "double" || type == "int" || type == "uint"));
        CHECK(mesh.text == (encoding == "ascii"));
        return soup_of(mesh)[0];
    };
    CHECK(read("double", 0.1 + 0x1p-40) == Approx(0.1 + 0x1p-40).epsilon(encoding == "ascii" ? 1e-5 : 1e-16));
    CHECK(read("int", -2147483648.0) == -2147483648.0);
    CHECK(read("int", 16777217) == 16777217);
    CHECK(read("uint", 4294967295.0) == 4294967295.0);
    CHECK(read("float", -0.375) == -0.375);
    CHECK(read("short", -32768) == -32768);
    CHECK(read("ushort", 65535) == 65535);
    CHECK(read("char", -128) == -128);
    CHECK(read("uchar", 255) == 255);
}

TEST_CASE("PLY floats of the machine's own byte order stay where they lie", "[input][ply]") {
    const TempFolder dir;
    PlyVariant how;
    how.encoding = "binary_little_endian";
    how.faces_first = GENERATE(false, true);
    how.coordinate = GENERATE(as<std::string_view>(), "float", "double");
    const std::string bytes = ply(how, cube());
    const MeshFile mesh = read_ply_file(dir.write("a.ply", bytes));
    CHECK(mesh.bytes.size() == bytes.size());
    CHECK(mesh.first_offset + mesh.vertex_count * mesh.stride <= bytes.size());
    how.axes = {0, 2, 1};
    CHECK(read_ply_file(dir.write("a.ply", ply(how, cube()))).first_offset == 0);
}

TEST_CASE("PLY polygons are cut into triangles", "[input][ply]") {
    const TempFolder dir;
    PlyVariant how;
    how.encoding = GENERATE(from_range(ply_encodings));
    how.faces_first = GENERATE(false, true);
    // A prism over an L of six corners, concave at the last one, 2 high.
    const std::vector<double> xyz = {0, 0, 0, 3, 0, 0, 3, 1, 0, 1, 1, 0, 1, 3, 0, 0, 3, 0,
                                     0, 0, 2, 3, 0, 2, 3, 1, 2, 1, 1, 2, 1, 3, 2, 0, 3, 2};
    const Faces faces = {{5, 4, 3, 2, 1, 0}, {6, 7, 8, 9, 10, 11}, {0, 1, 7, 6},   {1, 2, 8, 7},
                         {2, 3, 9, 8},       {3, 4, 10, 9},        {4, 5, 11, 10}, {5, 0, 6, 11}};
    const shapes::Soup soup = read_soup(dir, ply(how, xyz, faces));
    CHECK(soup.size() == 9 * (2 * 4 + 6 * 2));
    CHECK(volume_of(soup) == Approx(10));
    const Result<MeshInfo> info = inspect(view_of(soup));
    REQUIRE(info.ok());
    CHECK(info->closed);
    CHECK(info->area_mm2 == Approx(2 * 5 + 12 * 2));
}

TEST_CASE("PLY faces of fewer than three vertices are left out and reported", "[input][ply]") {
    const TempFolder dir;
    PlyVariant how;
    how.encoding = GENERATE(from_range(ply_encodings));
    Faces faces = triangles_of(cube());
    faces.insert(faces.begin() + 1, {{}, {0}, {0, 1}});
    const auto path = dir.write("a.ply", ply(how, cube().xyz, faces));
    CHECK(read_soup(path) == soup_of(cube()));
    CHECK(warnings_of(path) == std::vector<std::string>{"left out 3 faces of fewer than three vertices"});
    CHECK(read_error(dir.write("b.ply", ply(how, cube().xyz, {{0, 1}}))).code == ErrorCode::empty_mesh);
}

TEST_CASE("PLY triangle strips alternate and begin again after -1", "[input][ply]") {
    const TempFolder dir;
    const std::string_view encoding = GENERATE(from_range(ply_encodings));
    const bool strips_first = GENERATE(false, true);
    const std::vector<double> xyz = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0};
    PlyWriter out(encoding);
    const auto strips = [&] {
        out.list("int", "int", {0, 1, 2, 3, 4, -1, 2, 1, 0, -1, -1, 0, 1, 4, -1, 0, 1, -1}).end_row();
        out.list("int", "int", {0, 1, 1, 2, 3}).end_row();
    };
    const auto declare_strips = [&] { out.header("element tristrips 2").header("property list int int vertex_indices"); };
    PlyVariant how;
    if (strips_first) {
        declare_strips();
    }
    detail::declare_vertices(out, how, 5);
    if (!strips_first) {
        declare_strips();
    }
    if (strips_first) {
        strips();
    }
    detail::write_vertices(out, how, xyz);
    if (!strips_first) {
        strips();
    }
    const MeshFile mesh = read_ply_file(dir.write("a.ply", out.file()));
    const std::vector<std::uint32_t> indices(mesh.indices.begin(), mesh.indices.end());
    CHECK(indices == std::vector<std::uint32_t>{0, 1, 2, 2, 1, 3, 2, 3, 4, 2, 1, 0, 0, 1, 4, 1, 2, 3});
}

TEST_CASE("PLY comments may state the patient frame", "[input][ply]") {
    const TempFolder dir;
    const std::string plain = ply({}, cube());
    const auto frame_of = [&](const std::string& line) {
        return read_ply_file(dir.write("a.ply", replaced(plain, "element vertex", line + "\nelement vertex"))).patient_frame;
    };
    CHECK(frame_of("comment made by hand") == PatientFrame::unstated);
    CHECK(frame_of("comment SPACE=LPS") == PatientFrame::lps);
    CHECK(frame_of("comment 3D Slicer output. SPACE=RAS") == PatientFrame::ras);
    CHECK(frame_of("obj_info SPACE=LPS") == PatientFrame::lps);
    CHECK(frame_of("comment SPACE=XYZ") == PatientFrame::unstated);
    CHECK(frame_of("comment end_header\ncomment\ncomment element vertex 3") == PatientFrame::unstated);
    CHECK(frame_of("obj_info SPACE=RAS\ncomment SPACE=RAS") == PatientFrame::ras);
    CHECK(frame_of("obj_info SPACE=RAS\ncomment SPACE=LPS") == PatientFrame::unstated);
}

TEST_CASE("PLY headers are read with any line ends and white space", "[input][ply]") {
    const TempFolder dir;
    PlyVariant how;
    how.encoding = GENERATE(from_range(ply_encodings));
    how.coordinate = "int";
    // The first byte of the data is one that ends lines: it is data.
    std::vector<double> xyz = cube().xyz;
    xyz[0] = how.encoding == "binary_big_endian" ? 0x0A000000 : 0x0A;
    const std::string bytes = ply(how, xyz, triangles_of(cube()));
    const std::size_t body = bytes.find("end_header\n") + 11;
    const shapes::Soup expected = read_soup(dir, bytes);
    const auto reads = [&](const std::string& what, const std::string& by) {
        return read_soup(dir, replaced(bytes.substr(0, body), what, by) + bytes.substr(body)) == expected;
    };
    CHECK(reads("\n", "\r\n"));
    CHECK(reads("\n", "\r"));
    CHECK(reads("\n", " \t\n"));
    CHECK(reads(" ", " \t "));
    CHECK(reads("property", "\tproperty"));
    CHECK(reads("\nproperty", "\n\n \nproperty"));
}

TEST_CASE("ASCII PLY rows need not be lines", "[input][ply]") {
    const TempFolder dir;
    PlyVariant how;
    how.extra_elements = GENERATE(false, true);
    how.faces_first = GENERATE(false, true);
    const std::string bytes = ply(how, cube());
    const std::size_t body = bytes.find("end_header\n") + 11;
    const auto reads = [&](const std::string& what, const std::string& by) {
        return read_soup(dir, bytes.substr(0, body) + replaced(bytes.substr(body), what, by)) == soup_of(cube());
    };
    CHECK(reads("\n", "\r\n"));
    CHECK(reads("\n", "\r"));
    CHECK(reads("\n", " "));
    CHECK(reads("\n", "\n\n"));
    CHECK(reads("\n", " \n \t\n"));
    CHECK(reads(" ", "\n"));
    CHECK(reads(" ", "\t \t"));
    CHECK(read_soup(dir, bytes.substr(0, bytes.size() - 1)) == soup_of(cube()));
    CHECK(read_soup(dir, bytes + "\n \r\n\n") == soup_of(cube()));
    CHECK(read_soup(dir, "\xEF\xBB\xBF" + bytes) == soup_of(cube()));
}

TEST_CASE("ASCII PLY is read in every accepted spelling of numbers", "[input][ply]") {
    const TempFolder dir;
    const std::string header =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty float y\nproperty int z\n"
        "element face 1\nproperty list uchar uint vertex_indices\nend_header\n";
    const std::string vertices = "+1.5e0 -.5 1e1\n1E-400 5. 0007\n-0.0 +0 3.25\n";
    const shapes::Soup expected = {1.5, -0.5, 10, 0, 5, 7, 0, 0, 3.25};
    CHECK(read_soup(dir, header + vertices + "3 0 1 2\n") == expected);
    CHECK(read_soup(dir, header + vertices + "+3 0.0 1e0 2.\n") == expected);
    CHECK(read_soup(dir, header + vertices + "003 -0 0000000000000000000000001 2\n") == expected);
}

TEST_CASE("ASCII PLY parsed in many pieces gives every face once, in order", "[input][ply][threads]") {
    const TempFolder dir;
    const shapes::Indexed sphere = shapes::indexed(shapes::octasphere({1, 2, 3}, 20, 7));  // 5 MB
    Faces faces = triangles_of(sphere);
    std::size_t small = 0;
#ifdef LAMELLA_TESTS_SANITIZED
    const bool some_small = true;
    const bool faces_first = true;
#else
    const bool some_small = GENERATE(false, true);
    const bool faces_first = GENERATE(false, true);
#endif
    if (some_small) {  // fewer triangles in a piece than its lines and words let expect
        for (std::size_t at = 20; at < 120'000; at += 30'000) {
            faces.insert(faces.begin() + static_cast<std::ptrdiff_t>(at), {{0}, {1, 2}});
            small += 2;
        }
    }
    PlyVariant how;
    how.faces_first = faces_first;
    how.extra_elements = how.faces_first;
    const std::string by_lines = ply(how, sphere.xyz, faces);
    const auto path = dir.write("a.ply", by_lines);
    const shapes::Soup soup = read_soup(path);
    CHECK(soup.size() == 9 * (faces.size() - small));
    const MeshFile mesh = read_ply_file(path, 3);
    CHECK(std::equal(mesh.indices.begin(), mesh.indices.end(), sphere.indices.begin(), sphere.indices.end()));
    CHECK(mesh.warnings.size() == (small > 0 ? 1 : 0));
    const std::size_t body = by_lines.find("end_header\n") + 11;
    CHECK(read_soup(dir, by_lines.substr(0, body) + "\n" + by_lines.substr(body)) == soup);
}

TEST_CASE("bytes after the last PLY element give a warning", "[input][ply]") {
    const TempFolder dir;
    PlyVariant how;
    how.encoding = GENERATE(from_range(ply_encodings));
    const auto path = dir.write("a.ply", ply(how, cube()) + "tail");
    CHECK(read_soup(path) == soup_of(cube()));
    CHECK(warnings_of(path) == std::vector<std::string>{"ignored 4 bytes after the last element"});
}

TEST_CASE("PLY is known by its content", "[input][ply]") {
    const TempFolder dir;
    PlyVariant how;
    how.encoding = GENERATE(from_range(ply_encodings));
    const std::string bytes = ply(how, cube());
    CHECK(read_soup(dir.write("a", bytes)) == soup_of(cube()));
    CHECK(read_soup(dir.write("a.PLY", bytes)) == soup_of(cube()));
    CHECK_THAT(warnings_of(dir.write("a.stl", bytes)).at(0), Contains("is a file of format PLY, not STL as its name says"));
}

}  // namespace lamella::ply_test
