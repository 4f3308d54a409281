#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "input/files.hpp"
#include "medical/dicom_file.hpp"
#include "medical/support.hpp"

using namespace medical;
using namespace dicom_file;

namespace {

/// Slices at 30, 33, 36, not in the order of their names.
void write_series(const TempFolder& folder, Syntax syntax = Syntax::explicit_little) {
    int index = 0;
    for (const double z : {36.0, 30.0, 33.0}) {
        CtSlice slice = at_height(z, index);
        slice.syntax = syntax;
        folder.write(std::to_string(index++) + ".dcm", slice.bytes());
    }
}

/// Why a folder is refused: one line.
std::string refusal(const TempFolder& folder) {
    const Error error = error_of(read_image_geometry(folder.path()));
    CHECK(error.code == ErrorCode::malformed_mesh);
    return error.message;
}

}  // namespace

TEST_CASE("dicom: slices are sorted along their normal in every transfer syntax", "[medical]") {
    for (const Syntax syntax : {Syntax::implicit_little, Syntax::explicit_little, Syntax::explicit_big}) {
        const TempFolder folder;
        write_series(folder, syntax);
        folder.write("notes.txt", "no DICOM");
        folder.write("empty", "");
        folder.write("DICOMDIR", meta("1.2.840.10008.1.2.1") +
                                     element(Syntax::explicit_little, 0x00080016, "UI", "1.2.840.10008.1.3.10"));
        const ImageGeometry read = value_of(read_image_geometry(folder.path()));
        CHECK(read.size == std::array<std::uint64_t, 3>{6, 4, 3});
        CHECK(read.spacing_mm == std::array<double, 3>{0.5, 2, 3});
        CHECK(read.origin_mm == std::array<double, 3>{-10, -20, 30});
        CHECK(read.uneven_slices_mm.empty());
        CHECK(read.slice_heights_mm() == std::vector<double>{0, 3, 6});
        REQUIRE(read.series);
        CHECK(read.series->slices[0].sop_instance_uid == "1.2.3.1.1");
        CHECK(read.series->slices[2].sop_instance_uid == "1.2.3.1.0");
        CHECK(read.series->patient_name == "Doe^Jane");
        CHECK(read.series->frame_of_reference_uid == "1.2.3.9");
    }
}

TEST_CASE("dicom: headers of deflated and compressed files are read", "[medical]") {
    const TempFolder folder;
    folder.write("deflated", meta("1.2.840.10008.1.2.1.99") + input_test::deflated(at_height(0, 0).data()));
    folder.write("jpeg", meta("1.2.840.10008.1.2.4.70") + at_height(3, 1).data());
    const ImageGeometry read = value_of(read_image_geometry(folder.path()));
    CHECK(read.size[2] == 2);
    folder.write("deflated", meta("1.2.840.10008.1.2.1.99") + "\x07 no deflate");
    CHECK_THAT(refusal(folder), Contains("deflated"));
}

TEST_CASE("dicom: sequences are passed over, however they are nested", "[medical]") {
    for (const Syntax syntax : {Syntax::implicit_little, Syntax::explicit_little, Syntax::explicit_big}) {
        const TempFolder folder;
        CtSlice slice = at_height(0, 0);
        slice.syntax = syntax;
        // A place within a sequence is not that of the slice.
        const std::string inner = element(syntax, 0x00200032, "DS", "9\\9\\9");
        slice.extra = sequence(syntax, 0x00101002, sequence(syntax, 0x00101002, inner) + inner);
        if (syntax == Syntax::explicit_little) {
            slice.extra += sequence(syntax, 0x00110010, element(Syntax::implicit_little, 0x00200032, "DS", "8\\8\\8"), "UN");
        }
        folder.write("a.dcm", slice.bytes());
        const ImageGeometry read = value_of(read_image_geometry(folder.path()));
        CHECK(read.origin_mm[0] == -10);
        CHECK(read.spacing_mm[2] == 3);
    }
    // 200,000 levels.
    std::string nested = meta("1.2.840.10008.1.2.1");
    for (int i = 0; i < 200000; ++i) {
        nested +=
            tag(0x00081140, false) + std::string("SQ\0\0\xff\xff\xff\xff", 8) + tag(0xfffee000, false) + "\xff\xff\xff\xff";
    }
    const TempFolder folder;
    folder.write("a.dcm", nested);
    CHECK_THAT(refusal(folder), Contains("cut off"));
}

TEST_CASE("dicom: oblique series are honoured, uneven slices are kept", "[medical]") {
    const TempFolder folder;
    const double c = std::cos(0.4);
    const double s = std::sin(0.4);
    for (const int step : {0, 1, 3}) {
        CtSlice slice = at_height(0, step);
        char text[200];
        (void)std::snprintf(text, sizeof text, "%.7f\\0\\%.7f\\0\\1\\0", c, s);
        slice.orientation = text;
        (void)std::snprintf(text, sizeof text, "%.6f\\5\\%.6f", -2.5 * s * step, 2.5 * c * step);
        slice.position = text;
        folder.write(std::to_string(step), slice.bytes());
    }
    const ImageGeometry read = value_of(read_image_geometry(folder.path()));
    CHECK(read.axes[2][0] == Approx(-s).margin(1e-6));
    CHECK(read.axes[2][2] == Approx(c).margin(1e-6));
    REQUIRE(read.uneven_slices_mm.size() == 3);
    const std::vector<double> heights = read.slice_heights_mm();
    CHECK(heights[1] == Approx(2.5).margin(1e-5));
    CHECK(heights[2] == Approx(7.5).margin(1e-5));
    CHECK(read.slice_heights_mm(2)[2] == Approx(2.5 - read.spacing_mm[2] / 4).margin(1e-5));
}

TEST_CASE("dicom: folders that are no one image are refused by name", "[medical]") {
    {
        const TempFolder folder;
        CHECK_THAT(refusal(folder), Contains("without DICOM files"));
        folder.write("a.dcm", meta("1.2.840.10008.1.2.1") + element(Syntax::explicit_little, 0x00080016, "UI", "1.2") +
                                  element(Syntax::explicit_little, 0x30060002, "SH", "RT"));
        CHECK_THAT(refusal(folder), Contains("none of which is an image"));
    }
    using Change = void (*)(CtSlice&);
    for (const auto& [change, complaint] : std::vector<std::pair<Change, const char*>>{
             {[](CtSlice& s) { s.series = "1.2.4", s.description = "Neck\nlow"; },
              "2 DICOM series in the folder, and one is taken: 1.2.3 'Thorax' (1 slice); 1.2.4 'Neck low' (1 slice)"},
             {[](CtSlice& s) { s.frames = "12"; }, "b.dcm: a DICOM file of several frames (12)"},
             {[](CtSlice& s) { s.position = "-10\\-20\\0"; }, "b.dcm: lies at the same place as"},
             {[](CtSlice& s) { s.position = "-10\\-19\\3"; }, "b.dcm: sheared, as by a tilted gantry"},
             {[](CtSlice& s) { s.position = ""; }, "b.dcm: its header states no ImagePositionPatient (0020,0032)"},
             {[](CtSlice& s) { s.orientation = ""; }, "no ImageOrientationPatient (0020,0037)"},
             {[](CtSlice& s) { s.spacing = ""; }, "no PixelSpacing (0028,0030)"},
             {[](CtSlice& s) { s.series = ""; }, "no SeriesInstanceUID (0020,000e)"},
             {[](CtSlice& s) { s.spacing = "1"; }, "not 2 numbers"},
             {[](CtSlice& s) { s.spacing = "0\\1"; }, "not above 0"},
             {[](CtSlice& s) { s.position = "1\\2\\nan"; }, "not 3 numbers"},
             {[](CtSlice& s) { s.position = "1\\2\\1e300"; }, "farther than"},
             {[](CtSlice& s) { s.orientation = "1\\0\\0\\0\\2\\0"; }, "no unit vectors"},
             {[](CtSlice& s) { s.orientation = "1\\0\\0\\1\\0\\0"; }, "other ImageOrientationPatient than"},
             {[](CtSlice& s) { s.orientation = "0\\1\\0\\1\\0\\0"; }, "b.dcm: other ImageOrientationPatient than"},
             {[](CtSlice& s) { s.columns = 5; }, "other Rows and Columns than"},
             {[](CtSlice& s) { s.frame_of_reference = "1.2.3.8"; }, "other FrameOfReferenceUID than"}}) {
        const TempFolder folder;
        folder.write("a.dcm", at_height(0, 0).bytes());
        CtSlice slice = at_height(3, 1);
        change(slice);
        folder.write("b.dcm", slice.bytes());
        CHECK_THAT(refusal(folder), Contains(complaint));
    }
    const TempFolder folder;
    CHECK_THAT(error_of(read_image_geometry(folder.write("a.dcm", at_height(0, 0).bytes()))).message,
               Contains("name the folder"));
    CtSlice parallel = at_height(0, 0);
    parallel.orientation = "1\\0\\0\\1\\0\\0";
    folder.write("a.dcm", parallel.bytes());
    (void)refusal(folder);
}

TEST_CASE("dicom: no damaged header crashes the reader", "[medical]") {
    for (const Syntax syntax : {Syntax::implicit_little, Syntax::explicit_little, Syntax::explicit_big}) {
        const TempFolder folder;
        write_series(folder, syntax);
        CtSlice slice = at_height(39, 9);
        slice.syntax = syntax;
        slice.extra = sequence(syntax, 0x00101002, element(syntax, 0x00200032, "DS", "9\\9\\9"));
        const std::string whole = slice.bytes();
        int refused = 0;
        for (std::size_t at = 0; at < whole.size(); ++at) {
            std::vector<std::string> variants = {whole.substr(0, at), whole, whole};
            variants[1][at] = static_cast<char>(variants[1][at] ^ 0xff);
            variants[2][at] = static_cast<char>(variants[2][at] ^ 0x01);
            for (const std::string& bytes : variants) {
                folder.write("9.dcm", bytes);
                const Result<ImageGeometry> read = read_image_geometry(folder.path());
                if (read) {
                    REQUIRE(std::isfinite(read->slicing_frame(PatientFrame::lps).m[3]));
                    continue;
                }
                ++refused;
                REQUIRE(read.error().code == ErrorCode::malformed_mesh);
                REQUIRE(read.error().message.find('\n') == std::string::npos);
            }
        }
        CHECK(refused > 300);
    }
}

TEST_CASE("dicom: uneven slices are refused for masks, and a folder is sealed by its slices", "[medical]") {
    const TempFolder folder;
    write_series(folder);
    const FileSeal seal = value_of(seal_file(folder.path()));
    folder.write("other.txt", "beside");
    CHECK(*seal_file(folder.path()) == seal);
    folder.write("3.dcm", at_height(40, 3).bytes());
    CHECK(seal_file(folder.path())->sha256 != seal.sha256);
    const ImageGeometry image = value_of(read_image_geometry(folder.path()));
    SliceResult result;
    const MaskPart part{.result = &result, .name = "a"};
    CHECK_THAT(error_of(write_mask({&part, 1}, image, folder / "m.nii")).message, Contains("not evenly spaced"));
}
