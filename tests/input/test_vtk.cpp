#include <limits>
#include <string>

#include "vtk_files.hpp"

namespace lamella::vtk_test {

TEST_CASE("legacy VTK in every form gives the same triangles", "[input][vtk][threads]") {
    const PolyData data = GENERATE(cube(), cube_with_strip(), sheet(200));
    const bool text = GENERATE(false, true);
    for (const int version : {1, 2, 3, 4, 5}) {
        for (const char* integers : {"vtktypeint64", "vtktypeint32", "unsigned_int", "vtkIdType"}) {
            const bool id = std::string(integers) == "vtkIdType";  // 32 bits in the file
            Legacy legacy{text, version, "float", id ? "int" : integers, ""};
            const std::string file = replaced(legacy(data), " int\n", id ? " vtkIdType\n" : " int\n");
            CHECK(read_triangles(dir.write("a.vtk", file)) == triangles_of(data));
            if (version < 5) {
                break;
            }
        }
    }
    const Contents contents = read(dir.write("b.vtk", Legacy{text}(data)));
    CHECK(contents.mesh.text == text);
    CHECK(contents.mesh.vertex_count == data.points.size());
    CHECK(contents.warnings.empty());
}

TEST_CASE("legacy VTK takes points of every type", "[input][vtk]") {
    const PolyData data = cube_with_strip();
    const bool text = GENERATE(false, true);
    for (const char* type : {"float", "double", "char", "unsigned_char", "short", "unsigned_short", "int", "unsigned_int",
                             "long", "unsigned_long", "vtktypeint64"}) {
        CHECK(read_triangles(dir.write("a.vtk", Legacy{text, 4, type}(data))) == triangles_of(data));
    }
    PolyData fine = cube();
    fine.points[0][0] = 1.0 / 3;  // no float
    const Contents contents = read(dir.write("b.vtk", Legacy{false, 4, "double"}(fine)));
    CHECK(contents.mesh.vertex_type == Number::f64);
    CHECK(contents.triangles[0][0] == 1.0 / 3);
    CHECK(read_triangles(dir.write("c.vtk", replaced(Legacy{false, 3}(data), "float\n", "float \r\n"))) ==
          triangles_of(data));
}

TEST_CASE("data other than the surface are skipped in legacy VTK", "[input][vtk]") {
    const PolyData data = cube();
    const bool text = GENERATE(false, true);
    const int version = GENERATE(3, 5);
    Legacy legacy{text, version};
    const std::string strings = text ? "one%20two\n\nPOLYGONS%201\n" : std::string("\xC3") + "1\n2\xC0\x80\x03" + "abc\n";
    const std::string bits = text ? "0 1 0 1 0 1 0 1 1\n" : "ab\n";
    legacy.extra = "METADATA\nCOMPONENT_NAMES\nx\ny\nINFORMATION 1\nNAME POLYGONS LOCATION y\nDATA 1\n\n" +
                   legacy.cells("VERTICES", {{0}, {1}}) + legacy.cells("LINES", {{0, 1, 2}}) + "FIELD FieldData 4\n" +
                   "notes 1 3 string\n" + strings + "flags 3 3 bit\n" + bits + "METADATA\nINFORMATION 0\n\n" +
                   "time 1 2 double\n" + legacy.array("double", {1, 2}) + "none 0 0 int\n\n";
    const std::string file = legacy(data);
    for (const char* rest :
         {"", "POINT_DATA 8\nSCALARS a float\nLOOKUP_TABLE default\nwhatever", "CELL_DATA 6\nPOLYGONS 1 1"}) {
        CHECK(read_triangles(dir.write("a.vtk", file + rest)) == triangles_of(data));
    }
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
        Legacy legacy{text, 5};
        legacy.extra = "FIELD FieldData 2\n" + head + " string\n";
        for (const std::string& value : values) {
            legacy.extra += text ? value + "\n" : static_cast<char>(0xC0 + value.size()) + value;
        }
        legacy.extra += "\ntime 1 1 double\n" + legacy.array("double", {1});
        CHECK(read_one(dir.write("a.vtk", replaced(legacy(cube()), "a title", title))).patient_frame == frame);
    }
    CHECK(warnings_of(dir / "a.vtk") == Texts{"states the patient frame 'LPS' and then 'RAS', so that neither is taken"});
}

TEST_CASE("cells of binary VTK without an area are ignored with a warning", "[input][vtk]") {
    PolyData data = cube();
    data.polygons.insert(data.polygons.begin() + 2, {{0, 1}, {}, {3}});
    const Contents contents = read(dir.write("a.vtk", Legacy{false, GENERATE(3, 5)}(data)));
    CHECK(contents.triangles == triangles_of(cube()));
    CHECK(contents.warnings == Texts{"ignored 3 cells of POLYGONS with fewer than three corners, the first being cell 2"});
    data.polygons.clear();
    refuses(dir.write("a.vtk", Legacy{false}(data) + "POLYGONS 0 0\n"), "", ErrorCode::empty_mesh);
    refuses(dir.write("a.vtk", Legacy{false}({})), "", ErrorCode::empty_mesh);
}

TEST_CASE("legacy VTK cut off anywhere is refused", "[input][vtk]") {
    const bool text = GENERATE(false, true);
    const int version = GENERATE(3, 5);
    Legacy legacy{text, version};
    legacy.extra = std::string("FIELD FieldData 2\nnote 1 1 string\n") + (text ? "" : "\xC3") + "abc\nt 1 1 double\n" +
                   legacy.array("double", {7});
    PolyData data = cube();
    data.polygons.push_back({0, 1, 7});
    const std::string whole = legacy(data);
    const std::size_t complete = whole.size() - (text ? 2 : 1);  // behind the last number
    CHECK(read_triangles(dir.write("a.vtk", whole.substr(0, complete))) == triangles_of(data));
    // Where a section ends, nothing is wrong but what is missing.
    refuses_cuts("a.vtk", whole, 22, complete, true);
}

TEST_CASE("malformed binary legacy VTK is refused with the byte", "[input][vtk]") {
    const int version = GENERATE(3, 5);
    const PolyData data = sheet(120);
    const std::string plain = Legacy{false, version}(data);
    refuses_each("a.vtk", plain,
                 {{"POINTS 14641", "POINTS 14640", ": byte ... : expected POINTS, POLYGONS"},
                  {"POINTS 14641", "POINTS 4294967295", "is truncated: expected 12884901885 numbers of POINTS at 4 bytes"},
                  {"float\n", "float\r", "expected the end of the line before the bytes of POINTS"}});
    PolyData bad = data;
    for (const std::size_t cell : {std::size_t{5}, bad.polygons.size() / 3, bad.polygons.size() - 2}) {
        bad.polygons[cell][2] = 14641;
    }
    const Error error =
        refuses(dir.write("a.vtk", Legacy{false, version}(bad)), "point 14641 of POLYGONS does not exist: there are 14641");
    const std::size_t cells = plain.find(version == 5 ? "CONNECTIVITY vtktypeint64\n" : "POLYGONS ");
    const std::size_t begin = plain.find('\n', cells) + 1;
    CHECK(error.byte_offset == static_cast<std::int64_t>(begin + (version == 5 ? 8 * (5 * 3 + 2) : 4 * (5 * 4 + 3))));
    bad = data;
    bad.polygons.back()[1] = 0x80000000;
    refuses(dir.write("a.vtk", Legacy{false, version, "float", "int"}(bad)), "point -2147483648 of POLYGONS does not exist");
    bad = cube();
    bad.points[3][1] = GENERATE(std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity());
    refuses(dir.write("a.vtk", Legacy{false, version}(bad)), "vertex 3 of this face has a coordinate that is not finite");
}

}  // namespace lamella::vtk_test
