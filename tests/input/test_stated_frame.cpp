// What a file must say for its patient frame to be known, and that none but 3MF says its unit.
#include <string>
#include <utility>
#include <vector>

#include "read.hpp"

namespace lamella::input_test {

namespace {

constexpr PatientFrame lps = PatientFrame::lps;
constexpr PatientFrame ras = PatientFrame::ras;
constexpr PatientFrame unstated = PatientFrame::unstated;

const std::string points = "0 0 0\n1 0 0\n0 1 0\n";
const std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
const std::string off = "OFF\n3 1 0\n" + points + "3 0 1 2\n";

std::string ply(const std::string& lines) {
    return "ply\nformat ascii 1.0\n" + lines +
           "\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
           "property list uchar int vertex_indices\nend_header\n" +
           points + "3 0 1 2\n";
}

/// One triangle in each format that has room for words.
std::vector<std::pair<std::string, std::string>> files_with(const std::string& words) {
    return {{"a.stl", binary_stl(numbered_facets(1), 1, words)},
            {"a.obj", "# " + words + "\n" + obj},
            {"a.off", "# " + words + "\n" + off},
            {"a.ply", ply("comment " + words)},
            {"b.ply", ply("obj_info " + words)},
            {"a.vtk", "# vtk DataFile Version 3.0\n" + words + "\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n" + points +
                          "POLYGONS 1 4\n3 0 1 2\n"}};
}

}  // namespace

TEST_CASE("words about a unit in a header or comment state none: no format but 3MF has one", "[input][unit]") {
    auto files = files_with("File units=cm");
    files.push_back({"b.stl", ascii_stl(numbered_facets(1), "units=cm")});
    for (const auto& [name, bytes] : files) {
        INFO(name);
        const MeshFile mesh = value_of(read_mesh(dir.write(name, bytes), {.mm_per_unit = 25.4}));
        CHECK_FALSE(mesh.states_unit);
        CHECK(mesh.mm_per_unit == 25.4);
    }
}

TEST_CASE("the words of a file may state its patient frame", "[input][frame]") {
    const auto require = [&](const std::string& name, const std::string& bytes, PatientFrame frame) {
        INFO(name << ": " << bytes.substr(0, 80));
        CHECK(read_one(dir.write(name, bytes)).patient_frame == frame);
    };
    for (const auto& [words, frame] : {std::pair{"made by hand", unstated},
                                       {"3D Slicer output. SPACE=LPS", lps},
                                       {"SPACE=RAS", ras},
                                       {"SPACE=", unstated},
                                       {"SPACE", unstated},
                                       {"SPACE=XYZ", unstated}}) {
        for (const auto& [name, bytes] : files_with(words)) {
            require(name, bytes, frame);
        }
    }
    require("a.obj", "# SPACE=RAS\n\n" + obj, ras);
    require("a.obj", "o SPACE=RAS\n# SPACE=LPS\n" + obj, unstated);
    require("a.off", replaced(off, "OFF\n", "OFF\n# SPACE=LPS\n"), lps);
    require("a.off", off + "# SPACE=RAS\n", unstated);
    require("a.ply", ply("comment end_header\ncomment\ncomment element vertex 3"), unstated);
    require("a.ply", ply("obj_info SPACE=RAS\ncomment SPACE=RAS"), ras);
    require("a.ply", ply("obj_info SPACE=RAS\ncomment SPACE=LPS"), unstated);
    require("a.stl", binary_stl(numbered_facets(1), 1, std::string(71, ' ') + "SPACE=RAS"), ras);
    require("a.stl", binary_stl(numbered_facets(1), 1, std::string(72, ' ') + "SPACE=RA"), unstated);
}

TEST_CASE("a patient frame is stated by a whole word and never guessed", "[input][frame]") {
    const auto read = [&](const std::string& words) { return read_one(dir.write("a.obj", "# " + words + "\n" + obj)); };
    const std::string words =
        GENERATE(as<std::string>(), "SPACE=LPSX", "SPACE=LPS-RAS", "SPACE=LP", "SPACE=LPS,RAS", "COLORSPACE=LPS",
                 "MY_SPACE=RAS", "SPACE= LPS", "SPACE=lps", "space=LPS", "SPACE LPS");
    CHECK(read(words).patient_frame == unstated);
    CHECK(read(words).warnings.empty());
    CHECK(read("SPACE= SPACE=LPS\tSPACE=").patient_frame == lps);
    CHECK(read("output.SPACE=RAS SPACE=RAS").patient_frame == ras);
}

TEST_CASE("contradicting patient frames give a warning, and neither is taken", "[input][frame]") {
    const std::string second = GENERATE(as<std::string>(), "RAS", "LAS");
    const auto path = dir.write("a.obj", "# SPACE=LPS SPACE=LPS\n# SPACE=" + second + "\n# SPACE=LPS\n" + obj);
    CHECK(read_one(path).patient_frame == unstated);
    CHECK(warnings_of(path) == Texts{"states the patient frame 'LPS' and then '" + second + "', so that neither is taken"});
}

}  // namespace lamella::input_test
