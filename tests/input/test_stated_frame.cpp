// What a file must say for its patient frame to be known.
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "files.hpp"
#include "read.hpp"

namespace lamella::input_test {

namespace {

MeshFile read_with_comment(const TempFolder& dir, const std::string& comment) {
    return read_one(dir.write("a.obj", "# " + comment + "\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
}

}  // namespace

TEST_CASE("a patient frame is stated by a whole word and never guessed", "[input][frame]") {
    const TempFolder dir;
    const std::string words =
        GENERATE(as<std::string>(), "SPACE=LPSX", "SPACE=LPS-RAS", "SPACE=LP", "SPACE=LPS,RAS", "COLORSPACE=LPS",
                 "MY_SPACE=RAS", "SPACE= LPS", "SPACE=lps", "space=LPS", "SPACE LPS");
    const MeshFile mesh = read_with_comment(dir, words);
    CHECK(mesh.patient_frame == PatientFrame::unstated);
    CHECK(mesh.warnings.empty());
    CHECK(read_with_comment(dir, "SPACE= SPACE=LPS\tSPACE=").patient_frame == PatientFrame::lps);
    CHECK(read_with_comment(dir, "output.SPACE=RAS SPACE=RAS").patient_frame == PatientFrame::ras);
}

TEST_CASE("contradicting patient frames give a warning, and neither is taken", "[input][frame]") {
    const TempFolder dir;
    const std::string second = GENERATE(as<std::string>(), "RAS", "LAS");
    const MeshFile mesh = read_with_comment(dir, "SPACE=LPS SPACE=LPS\n# SPACE=" + second + "\n# SPACE=LPS");
    CHECK(mesh.patient_frame == PatientFrame::unstated);
    CHECK(mesh.warnings ==
          std::vector<std::string>{(dir / "a.obj").string() + ": states the patient frame 'LPS' and then '" + second +
                                   "', so that neither is taken"});
}

TEST_CASE("the header of binary STL may state the patient frame", "[input][frame]") {
    const TempFolder dir;
    const auto frame = [&](const std::string& header) {
        return read_mesh(dir.write("a.stl", binary_stl(numbered_facets(1), 1, header)))->patient_frame;
    };
    CHECK(frame("3D Slicer output. SPACE=LPS") == PatientFrame::lps);
    CHECK(frame(std::string(71, ' ') + "SPACE=RAS") == PatientFrame::ras);
    CHECK(frame(std::string(72, ' ') + "SPACE=RA") == PatientFrame::unstated);
}

}  // namespace lamella::input_test
