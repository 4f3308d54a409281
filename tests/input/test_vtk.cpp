// Legacy VTK and VTP in every form. What is refused or warned of: cases/vtk.txt and cases/vtp.txt.
#include <limits>

#include "read.hpp"

namespace lamella::input_test {

namespace {

/// The middle half of the sheet's files are quads; many tasks read them.
PolygonMesh vtk_sheet(std::uint32_t side) {
    return sheet(side, side * side / 2);
}

Triangles vtk_triangles(const std::string& bytes) {
    return read_triangles(dir.write("a.vtk", bytes));
}

Triangles vtp_triangles(const std::string& bytes) {
    return read_triangles(dir.write("a.vtp", bytes));
}

}  // namespace

TEST_CASE("legacy VTK in every form gives the same triangles", "[input][vtk][threads]") {
    const PolygonMesh mesh = GENERATE(cube(), cube_with_strips(), vtk_sheet(200));
    const bool text = GENERATE(false, true);
    const Triangles expected = mesh.triangles();
    for (const int version : {1, 2, 3, 4}) {
        CHECK((vtk_triangles(Vtk{text, version}(mesh)) == expected));
    }
    for (const char* integers : {"vtktypeint64", "vtktypeint32", "unsigned_int", "vtkIdType"}) {  // the last: 32 bits
        CHECK((vtk_triangles(Vtk{text, 5, "float", integers}(mesh)) == expected));
    }
    const Contents contents = read(dir.write("b.vtk", Vtk{text}(mesh)));
    CHECK(contents.mesh.text == text);
    CHECK(contents.mesh.vertex_count == mesh.points());
    CHECK(contents.warnings.empty());
}

TEST_CASE("legacy VTK takes points of every type", "[input][vtk]") {
    const PolygonMesh mesh = cube_with_strips();
    const bool text = GENERATE(false, true);
    for (const char* type : {"float", "double", "char", "unsigned_char", "short", "unsigned_short", "int", "unsigned_int",
                             "long", "unsigned_long", "vtktypeint64"}) {
        CHECK(vtk_triangles(Vtk{text, 4, type}(mesh)) == mesh.triangles());
    }
    PolygonMesh fine = cube();
    fine.xyz[0] = 1.0 / 3;  // no float
    const Contents contents = read(dir.write("b.vtk", Vtk{false, 4, "double"}(fine)));
    CHECK(contents.mesh.vertex_type == Number::f64);
    CHECK(contents.triangles == fine.triangles());
}

TEST_CASE("data other than the surface are skipped in legacy VTK", "[input][vtk]") {
    const bool text = GENERATE(false, true);
    Vtk form{text, GENERATE(3, 5)};
    const std::string strings = text ? "one%20two\n\nPOLYGONS%201\n" : std::string("\xC3") + "1\n2\xC0\x80\x03" + "abc\n";
    const std::string bits = text ? "0 1 0 1 0 1 0 1 1\n" : "ab\n";
    form.extra = "METADATA\nCOMPONENT_NAMES\nx\ny\nINFORMATION 1\nNAME POLYGONS LOCATION y\nDATA 1\n\n" +
                 form.cells("VERTICES", {{0}, {1}}) + form.cells("LINES", {{0, 1, 2}}) + "FIELD FieldData 4\n" +
                 "notes 1 3 string\n" + strings + "flags 3 3 bit\n" + bits + "METADATA\nINFORMATION 0\n\n" +
                 "time 1 2 double\n" + form.array("double", {1, 2}) + "none 0 0 int\n\n";
    CHECK(vtk_triangles(form(cube())) == cube().triangles());
}

TEST_CASE("a FIELD of legacy VTK may state the patient frame", "[input][vtk]") {
    const bool text = GENERATE(false, true);
    struct Stated {
        std::string head;
        Texts values;
        PatientFrame frame;
        std::string title = "a title";
    };
    for (const auto& [head, values, frame, title] :
         {Stated{"SPACE 1 1", {"LPS"}, PatientFrame::lps}, Stated{"SPACE 1 1", {"RAS"}, PatientFrame::ras},
          Stated{"SPACE 1 1", {"RAS"}, PatientFrame::ras, "SPACE=RAS"},
          Stated{"SPACE 1 1", {"RASP"}, PatientFrame::unstated}, Stated{"SPACE 1 2", {"LPS", "RAS"}, PatientFrame::unstated},
          Stated{"OTHER 1 1", {"LPS"}, PatientFrame::unstated},
          Stated{"SPACE 1 1", {"RAS"}, PatientFrame::unstated, "3D Slicer output. SPACE=LPS"}}) {
        Vtk form{.text = text, .version = 5, .extra = "FIELD FieldData 2\n" + head + " string\n", .title = title};
        for (const std::string& value : values) {
            form.extra += text ? value + "\n" : static_cast<char>(0xC0 + value.size()) + value;
        }
        form.extra += "\ntime 1 1 double\n" + form.array("double", {1});
        CHECK(read_one(dir.write("a.vtk", form(cube()))).patient_frame == frame);
    }
    CHECK(warnings_of(dir / "a.vtk") == Texts{"states the patient frame 'LPS' and then 'RAS', so that neither is taken"});
}

TEST_CASE("cells of binary VTK without an area are ignored with a warning", "[input][vtk]") {
    PolygonMesh mesh = cube();
    mesh.faces.insert(mesh.faces.begin() + 2, {{0, 1}, {}, {3}});
    const Contents contents = read(dir.write("a.vtk", Vtk{false, GENERATE(3, 5)}(mesh)));
    CHECK(contents.triangles == cube().triangles());
    CHECK(contents.warnings == Texts{"ignored 3 cells of POLYGONS with fewer than three corners, the first being cell 2"});
    mesh.faces.clear();
    refuses(dir.write("a.vtk", Vtk{false}(mesh) + "POLYGONS 0 0\n"), "", ErrorCode::empty_mesh);
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
    const std::vector<PolygonMesh> pieces =
        GENERATE(std::vector<PolygonMesh>{cube_with_strips()},
                 std::vector<PolygonMesh>{cube(3), {}, cube_with_strips(), vtk_sheet(90)},
                 std::vector<PolygonMesh>{triangulated(cube(3)), {}, triangulated(cube(5))});
    Triangles expected;
    for (const PolygonMesh& piece : pieces) {
        const Triangles triangles = piece.triangles();
        expected.insert(expected.end(), triangles.begin(), triangles.end());
    }
    const std::string format = GENERATE(as<std::string>(), "ascii", "binary", "raw", "base64");
    for (unsigned ways = 0; ways < 8; ++ways) {
        Vtp form{format, ways % 2 != 0 && format != "ascii", ways / 2 % 2 != 0, ways / 4 != 0};
        form.block = pieces.size() == 1 ? 64 : 32768;
        const Contents contents = read(dir.write("a.vtp", form(pieces)));
        CHECK(contents.triangles == expected);
        CHECK(contents.mesh.text == (format == "ascii"));
        CHECK(contents.warnings.empty());
    }
}

TEST_CASE("VTP takes arrays of every type", "[input][vtp]") {
    const PolygonMesh mesh = cube_with_strips();
    const std::string format = GENERATE(as<std::string>(), "ascii", "raw", "base64");
    const bool big_endian = GENERATE(false, true);
    for (const char* type : {"Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64"}) {
        CHECK(vtp_triangles(Vtp{format, false, big_endian, true, type, type}({mesh})) == mesh.triangles());
    }
    const Contents contents = read(dir.write("a.vtp", Vtp{format, false, big_endian, true, "Float64"}({mesh})));
    CHECK(contents.triangles == mesh.triangles());
    CHECK(contents.mesh.vertex_type == Number::f64);
}

TEST_CASE("field data of VTP may state the patient frame", "[input][vtp]") {
    const std::string format = GENERATE(as<std::string>(), "ascii", "binary");
    const auto frame = [&](const std::string& name, const std::string& bytes) {
        Vtp form{format};
        std::string codes;
        for (const char c : bytes) {
            codes += format == "ascii" ? std::to_string(int{c}) + " " : std::string(1, c);
        }
        form.field = form.element("type=\"String\" Name=\"" + name + "\" NumberOfTuples=\"1\"", codes);
        form.field = "<FieldData>" + replaced(form.field, "DataArray", "Array") + "</FieldData>";
        return read_one(dir.write("a.vtp", form({cube()}))).patient_frame;
    };
    CHECK(frame("SPACE", std::string("LPS\0", 4)) == PatientFrame::lps);
    CHECK(frame("SPACE", std::string("RAS\0", 4)) == PatientFrame::ras);
    CHECK(frame("OTHER", std::string("LPS\0", 4)) == PatientFrame::unstated);
    for (const std::string value : {"LPSX", "lps", "left-posterior-superior"}) {
        CHECK(frame("SPACE", value) == PatientFrame::unstated);
    }
}

TEST_CASE("base64 may hold white space and padding anywhere", "[input][vtp]") {
    Vtp form{"binary"};
    const std::string plain = form({cube()});
    std::string spaced;
    bool data = false;
    for (std::size_t i = 0; i < plain.size(); ++i) {
        data = plain[i] == '>' || (data && plain[i] != '<');
        spaced += plain[i];
        spaced += data && i % 5 == 0 ? "\n " : "";
    }
    CHECK(vtp_triangles(spaced) == cube().triangles());
    // Some writers pad the header by itself.
    std::string coordinates;
    for (const double coordinate : cube().xyz) {
        coordinates += input_test::bytes_of(static_cast<float>(coordinate));
    }
    const std::string joined = base64(form.header({96}) + coordinates);
    REQUIRE(plain.find(joined) != std::string::npos);
    CHECK(vtp_triangles(replaced(plain, joined, base64(form.header({96})) + base64(coordinates))) == cube().triangles());
}

TEST_CASE("compressed VTP blocks with wrong sizes are refused", "[input][vtp]") {
    Vtp form{"raw", true};
    const std::string plain = form({cube()});
    // The header of the points: two blocks, of 64 and 32 bytes.
    const std::size_t header = plain.find(form.header({2, 64, 32}));
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
