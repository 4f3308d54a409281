// Legacy VTK and VTP in every form. What is refused or warned of: cases/vtk.txt and cases/vtp.txt.
#include <cmath>
#include <limits>
#include <random>

#include "read.hpp"

namespace lamella::input_test {

namespace {

/// The second half of the sheet are quads; many tasks read it.
PolygonMesh vtk_sheet(std::uint32_t side) {
    return sheet(side, side * side / 2);
}

}  // namespace

TEST_CASE("legacy VTK of every form and type gives the same triangles", "[input][vtk][threads]") {
    constexpr const char* types[] = {"float",          "double",       "char",         "unsigned_char", "short",
                                     "unsigned_short", "int",          "unsigned_int", "long",          "unsigned_long",
                                     "vtktypeint64",   "vtktypeint32", "vtkIdType"};
    std::mt19937 random(1);
    PolygonMesh degenerate = cube_with_strips();
    degenerate.faces.insert(degenerate.faces.begin() + 2, {{0, 1}, {}, {3}});
    const PolygonMesh meshes[] = {cube(), triangulated(cube()), cube_with_strips(), degenerate, vtk_sheet(200)};
    for (std::size_t draw = 0; draw < 300; ++draw) {
        const std::size_t which = draw < 5 ? 4 : draw % 4;
        const bool text = random() % 2 == 0;
        const Vtk form{text, 1 + static_cast<int>(random() % 5), which == 4 ? "float" : types[random() % 12],
                       types[which == 4 ? 10 + random() % 3 : 2 + random() % 11]};
        CAPTURE(draw, form.text, form.version, form.points, form.integers);
        const Contents contents = read(dir.write("a.vtk", form(meshes[which])));
        CHECK((contents.triangles == (which == 3 ? meshes[2] : meshes[which]).triangles()));
        CHECK(contents.mesh.text == text);
        CHECK(contents.mesh.vertex_count == meshes[which].points());
        CHECK(contents.warnings == (which == 3 ? Texts{"left out 3 faces of fewer than three corners"} : Texts{}));
    }
    PolygonMesh fine = cube();
    fine.xyz[0] = 1.0 / 3;  // no float
    const Contents contents = read(dir.write("b.vtk", Vtk{false, 4, "double"}(fine)));
    CHECK(contents.mesh.vertex_type == Number::f64);
    CHECK(contents.triangles == fine.triangles());
    refuses(dir.write("a.vtk", Vtk{false}({})), "", ErrorCode::empty_mesh);
}

TEST_CASE("wrong numbers of binary legacy VTK are refused with the byte", "[input][vtk]") {
    const int version = GENERATE(3, 5);
    const PolygonMesh mesh = triangulated(sheet(120, 0));
    const auto refused = [&](const PolygonMesh& bad, const std::string& says) {
        return refuses(dir.write("a.vtk", Vtk{false, version, "float", "int"}(bad)), says);
    };
    PolygonMesh bad = mesh;
    for (const std::size_t cell : {std::size_t{5}, bad.faces.size() / 3, bad.faces.size() - 2}) {
        bad.faces[cell][2] = 14641;
    }
    const Error error = refused(bad, "point 14641 of POLYGONS does not exist: there are 14641");
    const std::string bytes = ::bytes_of(dir / "a.vtk");
    const std::size_t cells = bytes.find('\n', bytes.find(version == 5 ? "CONNECTIVITY" : "POLYGONS ")) + 1;
    CHECK(error.byte_offset == static_cast<std::int64_t>(cells + 4 * (version == 5 ? 5 * 3 + 2 : 5 * 4 + 3)));
    bad = mesh;
    bad.faces.back()[1] = 0x80000000;
    refused(bad, version == 5 ? "point -2147483648 of POLYGONS does not exist" : "of POLYGONS does not exist");
    bad = cube();
    bad.xyz[10] = GENERATE(std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity());
    refused(bad, "vertex 3 of this face has a coordinate that is not finite");
}

// --- VTP

TEST_CASE("VTP gives the same triangles however its arrays are stored", "[input][vtp]") {
    // The last are triangles alone, which are read another way.
    const std::vector<PolygonMesh> meshes[] = {{cube_with_strips()},
                                               {cube(3), {}, cube_with_strips(), vtk_sheet(90)},
                                               {triangulated(cube(3)), {}, triangulated(cube(5))}};
    constexpr const char* types[] = {"Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64"};
    std::mt19937 random(1);
    for (std::size_t draw = 0; draw < 400; ++draw) {
        const std::size_t which = draw < 8 ? 1 : draw % 2 * 2;
        Triangles expected;
        for (const PolygonMesh& piece : meshes[which]) {
            const Triangles triangles = piece.triangles();
            expected.insert(expected.end(), triangles.begin(), triangles.end());
        }
        Vtp form{std::array{"ascii", "binary", "raw", "base64"}[draw / 2 % 4]};
        form.zlib = random() % 2 == 0 && form.format != "ascii";
        form.big_endian = random() % 2 == 0;
        form.wide = random() % 2 == 0;
        form.points = which != 1 && random() % 2 == 0 ? types[random() % 8] : random() % 2 == 0 ? "Float32" : "Float64";
        form.integers = types[which == 1 ? 4 + random() % 4 : random() % 8];
        form.block = which == 1 ? 32768 : 64;
        CAPTURE(draw, form.format, form.zlib, form.big_endian, form.wide, form.points, form.integers);
        const Contents contents = read(dir.write("a.vtp", form(meshes[which])));
        CHECK((contents.triangles == expected));
        CHECK(contents.mesh.text == (form.format == "ascii"));
        CHECK((form.points != "Float64" || contents.mesh.vertex_type == Number::f64));
        CHECK(contents.warnings.empty());
        check_scalars(dir / "a.vtp", "Points");
    }
}

TEST_CASE("compressed points of VTP keep the sign of wide integers", "[input][vtp]") {
    PolygonMesh mesh = cube();
    for (double& number : mesh.xyz) {
        number = std::round(number) - 5;
    }
    Vtp form{.format = "binary", .zlib = true, .big_endian = GENERATE(false, true), .points = "Int64"};
    CHECK(read_triangles(dir.write("a.vtp", form({mesh}))) == mesh.triangles());
}

TEST_CASE("compressed VTP blocks with wrong sizes are refused", "[input][vtp]") {
    Vtp form{"raw", true};
    const std::string plain = form({cube()});
    // The header of the points, the last such: two blocks, of 64 and 32 bytes.
    const std::size_t header = plain.rfind(form.header({2, 64, 32}));
    REQUIRE(header != std::string::npos);
    const auto refused = [&](std::size_t word, std::uint64_t value, const std::string& says) {
        INFO(word << " " << value);
        std::string file = plain;
        refuses(dir.write("a.vtp", file.replace(header + 8 * word, 8, form.header({value}))), says);
    };
    for (const std::uint64_t value : {std::uint64_t{0}, std::uint64_t{1}, std::uint64_t{3}, std::uint64_t{1} << 31,
                                      std::uint64_t{1} << 61, ~std::uint64_t{0}}) {
        for (std::size_t word = 0; word < 5; ++word) {
            refused(word, value, "Points");
        }
    }
    refused(0, 1U << 31, "counts 2147483648 compressed blocks");
    refused(1, 65, "should have 96 bytes, which its compressed blocks do not hold");
    std::string damaged = plain;
    damaged[header + 8 * 5 + 20] ^= 0x55;
    refuses(dir.write("a.vtp", damaged), "its compressed block 0 does not expand");
    // A count that the compressed bytes cannot hold is not asked of the limit.
    refuses(dir.write("b.vtp", replaced(plain, "NumberOfPoints=\"8\"", "NumberOfPoints=\"1000000\"")), "");
}

TEST_CASE("compressed integers of 64 bits are held in 32, unless they are larger", "[input][vtp]") {
    Vtp form{"raw", true, GENERATE(false, true)};
    form.block = 32768;
    const auto path = dir.write("a.vtp", form({vtk_sheet(200)}));
    const std::uint64_t limit = 3'000'000;  // 2.5 MB are needed so, and 3.5 otherwise
    CHECK((triangles_of(value_of(read_mesh(path, {.memory_limit_bytes = limit}))) == vtk_sheet(200).triangles()));
    for (const std::int64_t point : {std::int64_t{9}, std::int64_t{0xFFFFFFFF}}) {
        PolygonMesh bad = cube();
        bad.faces[5][3] = point;
        for (const char* format : {"binary", "raw", "base64"}) {
            form.format = format;
            refuses(dir.write("a.vtp", form({bad})),
                    "point " + std::to_string(point) + " of Polys does not exist: there are 8");
        }
    }
}

}  // namespace lamella::input_test
