// Headers in every encoding. Series at any angle, of even and uneven slices: tests/readers/structure_set.py.
#include <map>
#include <string_view>
#include <tuple>
#include <utility>

#include "input/files.hpp"
#include "medical/dicom/data_set.hpp"
#include "medical/support.hpp"

using namespace medical;

namespace {

// --- small DICOM files

enum class Syntax : std::uint8_t { implicit_little, explicit_little, explicit_big };

std::string number(std::uint32_t value, int bytes, bool big) {
    return bytes == 2 ? input_test::bytes_of(static_cast<std::uint16_t>(value), big) : input_test::bytes_of(value, big);
}

std::string tag(std::uint32_t value, bool big) {
    return number(value >> 16, 2, big) + number(value & 0xffff, 2, big);
}

/// `value` of type US: in decimals.
std::string element(Syntax syntax, std::uint32_t at, std::string_view type, std::string value) {
    const bool big = syntax == Syntax::explicit_big;
    value = type == "US" ? number(static_cast<std::uint32_t>(std::stoul(value)), 2, big) : value;
    value.resize((value.size() + 1) / 2 * 2, type == "UI" ? '\0' : ' ');
    const auto length = static_cast<std::uint32_t>(value.size());
    if (syntax == Syntax::implicit_little) {
        return tag(at, false) + number(length, 4, false) + value;
    }
    const bool is_long = type == "OW" || type == "OB" || type == "SQ" || type == "UN";
    return tag(at, big) + std::string(type) +
           (is_long ? std::string(2, '\0') + number(length, 4, big) : number(length, 2, big)) + value;
}

/// A sequence of items: of defined lengths, or of undefined ones.
std::string sequence(Syntax syntax, std::uint32_t at, const std::vector<std::string>& items, bool defined = false,
                     const std::string& type = "SQ") {
    const bool big = syntax == Syntax::explicit_big;
    std::string inner;
    for (const std::string& item : items) {
        const auto length = static_cast<std::uint32_t>(item.size());
        inner += tag(0xfffee000, big) + number(defined ? length : 0xffffffff, 4, big) + item;
        inner += defined ? "" : tag(0xfffee00d, big) + number(0, 4, big);
    }
    inner += defined ? "" : tag(0xfffee0dd, big) + number(0, 4, big);
    const auto length = static_cast<std::uint32_t>(inner.size());
    return tag(at, big) + (syntax == Syntax::implicit_little ? "" : type + std::string(2, '\0')) +
           number(defined ? length : 0xffffffff, 4, big) + inner;
}

/// The begin of a file: up to its data set.
std::string meta(const std::string& syntax_uid) {
    const std::string uid = element(Syntax::explicit_little, 0x00020010, "UI", syntax_uid);
    return std::string(128, '\0') + "DICM" +
           element(Syntax::explicit_little, 0x00020000, "UL", number(static_cast<std::uint32_t>(uid.size()), 4, false)) +
           uid;
}

/// A slice of a CT; an empty text leaves its attribute out.
struct CtSlice {
    Syntax syntax = Syntax::explicit_little;
    std::string extra{};  ///< elements before group 0018
    std::map<std::uint32_t, std::pair<const char*, std::string>> elements = {
        {dicom::sop_class_uid, {"UI", "1.2.840.10008.5.1.4.1.1.2"}},
        {dicom::sop_instance_uid, {"UI", "1.2.3.1"}},
        {dicom::modality, {"CS", "CT"}},
        {dicom::series_description, {"LO", "Thorax"}},
        {0x00100010, {"PN", "Doe^Jane"}},
        {0x00100020, {"LO", "17"}},
        {dicom::slice_thickness, {"DS", "3"}},
        {dicom::study_instance_uid, {"UI", "1.2"}},
        {dicom::series_instance_uid, {"UI", "1.2.3"}},
        {dicom::image_position_patient, {"DS", "-10\\-20\\30"}},
        {dicom::image_orientation_patient, {"DS", "1\\0\\0\\0\\1\\0"}},
        {dicom::frame_of_reference_uid, {"UI", "1.2.3.9"}},
        {dicom::number_of_frames, {"IS", ""}},
        {dicom::rows, {"US", "4"}},
        {dicom::columns, {"US", "6"}},
        {dicom::pixel_spacing, {"DS", "2\\0.5"}},
        {0x00280100, {"US", "16"}},
        {0x7fe00010, {"OW", std::string(2 * 4 * 6, '\0')}},
    };

    std::string& operator[](std::uint32_t at) { return elements[at].second; }

    std::string data() const {
        std::string all;
        for (const auto& [at, value] : elements) {
            all += at == dicom::slice_thickness ? extra : "";
            all += value.second.empty() ? "" : element(syntax, at, value.first, value.second);
        }
        return all;
    }

    std::string bytes() const {
        static constexpr const char* syntaxes[] = {"1.2.840.10008.1.2", "1.2.840.10008.1.2.1", "1.2.840.10008.1.2.2"};
        return meta(syntaxes[static_cast<int>(syntax)]) + data();
    }
};

/// An enhanced CT, whose frames lie at these heights.
struct EnhancedCt {
    Syntax syntax = Syntax::explicit_little;
    bool defined = true;          ///< lengths
    bool shared_measures = true;  ///< else a frame each
    std::vector<double> heights = {36, 30, 39, 33};
    std::string frames = "4";

    std::string bytes() const {
        CtSlice top;
        top.syntax = syntax;
        top[dicom::sop_class_uid] = "1.2.840.10008.5.1.4.1.1.2.1";
        for (const dicom::Tag at : {dicom::slice_thickness, dicom::image_position_patient, dicom::image_orientation_patient,
                                    dicom::pixel_spacing}) {
            top[at].clear();
        }
        top[dicom::number_of_frames] = frames;
        const auto group = [&](dicom::Tag at, const std::string& inner) { return sequence(syntax, at, {inner}, defined); };
        const std::string measures = group(dicom::pixel_measures, element(syntax, dicom::slice_thickness, "DS", "3") +
                                                                      element(syntax, dicom::pixel_spacing, "DS", "2\\0.5"));
        const std::string upright =
            group(dicom::plane_orientation, element(syntax, dicom::image_orientation_patient, "DS", "1\\0\\0\\0\\1\\0"));
        // A place in another group is not that of the frame.
        const std::string elsewhere = group(0x00089124, element(syntax, dicom::image_position_patient, "DS", "9\\9\\9"));
        std::vector<std::string> items;
        for (std::size_t i = 0; i < heights.size(); ++i) {
            items.push_back(elsewhere +
                            group(dicom::plane_position, element(syntax, dicom::image_position_patient, "DS",
                                                                 "-10\\-20\\" + std::to_string(heights[i]))) +
                            (shared_measures ? "" : measures));
        }
        std::string all = top.bytes();
        const std::string pixels = element(syntax, 0x7fe00010, "OW", top[0x7fe00010]);
        all.resize(all.size() - pixels.size());
        return all + sequence(syntax, dicom::shared_groups, {upright + (shared_measures ? measures : "")}, defined) +
               sequence(syntax, dicom::per_frame_groups, items, defined) + pixels;
    }
};

CtSlice at_height(double z, int index) {
    CtSlice slice;
    slice[dicom::image_position_patient] = "-10\\-20\\" + std::to_string(z);
    slice[dicom::sop_instance_uid] = "1.2.3.1." + std::to_string(index);
    return slice;
}

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

TEST_CASE("dicom: frames of an enhanced CT are what as many files would be, in any order", "[medical]") {
    for (const Syntax syntax : {Syntax::implicit_little, Syntax::explicit_little, Syntax::explicit_big}) {
        for (const bool defined : {false, true}) {
            const TempFolder folder;
            const std::filesystem::path file =
                folder.write("a.dcm", EnhancedCt{.syntax = syntax, .defined = defined, .shared_measures = defined}.bytes());
            for (const std::filesystem::path& path : {file, folder.path()}) {
                const ImageGeometry read = value_of(read_image_geometry(path));
                CHECK(read.size == std::array<std::uint64_t, 3>{6, 4, 4});
                CHECK(read.spacing_mm == std::array<double, 3>{0.5, 2, 3});
                CHECK(read.origin_mm == std::array<double, 3>{-10, -20, 30});
                CHECK(read.axes == ImageGeometry{}.axes);
                std::vector<std::uint64_t> frames;
                for (const DicomSeries::Instance& slice : read.series->slices) {
                    CHECK(slice.sop_instance_uid == "1.2.3.1");
                    frames.push_back(slice.frame);
                }
                CHECK(frames == std::vector<std::uint64_t>{2, 4, 1, 3});
            }
            CHECK(value_of(seal_file(folder.path())).bytes == std::filesystem::file_size(file));
            EnhancedCt many{.syntax = syntax, .defined = defined, .heights = {}, .frames = "2000"};
            for (int i = 0; i < 2000; ++i) {
                many.heights.push_back(i * 7 % 2000);
            }
            CHECK(value_of(read_image_geometry(folder.write("a.dcm", many.bytes()))).size[2] == 2000);
            const auto read = [&](const std::string& bytes) { return read_image_geometry(folder.write("a.dcm", bytes)); };
            const std::string bytes = EnhancedCt{.syntax = syntax, .defined = defined}.bytes();
            CHECK(refused_of_damaged(bytes, bytes.size(), 2, read) > 300);
        }
    }
    const TempFolder folder;
    const auto check_refusal = [&](const EnhancedCt& ct, const char* complaint) {
        folder.write("a.dcm", ct.bytes());
        CHECK_THAT(refusal(folder), Contains(complaint));
    };
    check_refusal({.heights = {30, 33, 33, 30}}, "a.dcm: frame 4: lies at the same place as frame 1 of ");
    check_refusal({.heights = {30, 33, 36}}, "groups are of 3 frames, its NumberOfFrames is 4");
    check_refusal({.heights = {}}, "its frames (4) have no functional groups");
    check_refusal({.heights = {0, 3, 6, 1e300}}, "a.dcm: frame 4: ImagePositionPatient lies farther than");
}

TEST_CASE("dicom: the series of a folder are listed, and one is chosen by its UID", "[medical]") {
    const TempFolder folder;
    write_series(folder);
    CtSlice scout = at_height(0, 7);
    scout[dicom::series_instance_uid] = "1.2.4";
    scout[dicom::series_description] = "Scout";
    scout[dicom::image_position_patient].clear();
    folder.write("scout", scout.bytes());
    const std::vector<DicomSeriesInfo> list = value_of(list_series(folder.path()));
    REQUIRE(list.size() == 2);
    CHECK(std::tie(list[0].uid, list[0].modality, list[0].description, list[0].refusal) ==
          std::tuple("1.2.3", "CT", "Thorax", ""));
    CHECK(list[0].files == 3);
    CHECK(list[1].uid == "1.2.4");
    CHECK_THAT(list[1].refusal, Contains("ImagePositionPatient"));
    CHECK(value_of(read_image_geometry(folder.path(), {.series_uid = "1.2.3"})).size[2] == 3);
    CHECK_THAT(refusal(folder), Contains("2 DICOM series"));
    CHECK_THAT(error_of(read_image_geometry(folder.path(), {.series_uid = "1.2"})).message,
               Contains("no images of the series 1.2; there is 1.2.3 'Thorax' (3 slices); 1.2.4 'Scout' (1 slice)"));
    CHECK(error_of(read_image_geometry(folder / "scout", {.series_uid = "1.2.4"})).code == ErrorCode::invalid_argument);
    CHECK(error_of(seal_file(folder.path())).code == ErrorCode::malformed_mesh);
    CHECK(value_of(seal_file(folder.path(), {}, {.series_uid = "1.2.3"})).bytes ==
          3 * std::filesystem::file_size(folder / "0.dcm"));
    const Context stopped{.stop = always};
    CHECK(error_of(list_series(folder.path(), stopped)).code == ErrorCode::cancelled);
    CHECK(error_of(read_image_geometry(folder.path(), {}, stopped)).code == ErrorCode::cancelled);
    CHECK(error_of(list_series(folder / "none")).code == ErrorCode::unreadable_file);
}

TEST_CASE("dicom: a tilted gantry is a sheared image; slices off its line and gaps are named", "[medical]") {
    const double tilt = std::tan(0.2617993877991494);  // 15 degrees
    const TempFolder folder;
    const auto write = [&](int k, double aside) {
        CtSlice slice = at_height(30 + 3 * k, k);
        slice[dicom::image_position_patient] =
            "-10\\" + std::to_string(-20 + 3 * k * tilt + aside) + "\\" + std::to_string(30 + 3 * k);
        return folder.write(std::to_string(k) + ".dcm", slice.bytes());
    };
    for (int k = 0; k < 12; ++k) {
        write(k, 0);
    }
    const ImageGeometry read = value_of(read_image_geometry(folder.path()));
    CHECK(read.shear_mm[0] == 0);
    CHECK(read.shear_mm[1] == Approx(3 * tilt).epsilon(1e-6));
    CHECK(read.spacing_mm[2] == Approx(3));
    CHECK(read.axes == ImageGeometry{}.axes);
    REQUIRE(read.warnings.size() == 1);
    CHECK_THAT(read.warnings[0], Contains("0.dcm: the image is sheared, as by a tilted gantry: each slice lies 0.804 mm"));
    for (const int off : {0, 4, 11}) {
        write(off, 0.3);
        CHECK_THAT(refusal(folder), Contains(std::to_string(off) + ".dcm: lies 0.3 mm aside of the line"));
        write(off, 0);
    }
    std::filesystem::remove(folder / "7.dcm");
    const ImageGeometry uneven = value_of(read_image_geometry(folder.path()));
    CHECK(uneven.shear_mm[1] / uneven.spacing_mm[2] == Approx(tilt).epsilon(1e-6));
    const std::string words = uneven.uneven_words();
    CHECK(words == "6 mm from " + (folder / "6.dcm").string() + " to " + (folder / "8.dcm").string() + ", else 3 mm");
}

TEST_CASE("dicom: headers of deflated and compressed files are read", "[medical]") {
    const TempFolder folder;
    folder.write("deflated", meta("1.2.840.10008.1.2.1.99") + input_test::deflated(at_height(0, 0).data()));
    folder.write("jpeg", meta("1.2.840.10008.1.2.4.70") + at_height(3, 1).data());
    CHECK(value_of(read_image_geometry(folder.path())).size[2] == 2);
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
        slice.extra = sequence(syntax, 0x00101002, {sequence(syntax, 0x00101002, {inner}) + inner});
        if (syntax == Syntax::explicit_little) {
            slice.extra +=
                sequence(syntax, 0x00110010, {element(Syntax::implicit_little, 0x00200032, "DS", "8\\8\\8")}, false, "UN");
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

TEST_CASE("dicom: folders that are no one image are refused by name", "[medical]") {
    const TempFolder empty;
    CHECK_THAT(refusal(empty), Contains("without DICOM files"));
    empty.write("a.dcm", meta("1.2.840.10008.1.2.1") + element(Syntax::explicit_little, 0x00080016, "UI", "1.2") +
                             element(Syntax::explicit_little, 0x30060002, "SH", "RT"));
    CHECK_THAT(refusal(empty), Contains("none of which is an image"));
    for (const auto& [tag, value, complaint] : std::vector<std::tuple<dicom::Tag, const char*, const char*>>{
             // of the second of two slices, and a part of the message
             {dicom::series_instance_uid, "1.2.4",
              "2 DICOM series, of which --series UID takes one: 1.2.3 'Thorax' (1 slice); 1.2.4 'Thorax' (1 slice)"},
             {dicom::number_of_frames, "12",
              "b.dcm: its frames (12) have no functional groups, which would say where each lies, as a file of the class"},
             {dicom::image_position_patient, "-10\\-20\\0", "b.dcm: lies at the same place as"},
             {dicom::image_position_patient, "", "b.dcm: its header states no ImagePositionPatient (0020,0032)"},
             {dicom::image_orientation_patient, "", "no ImageOrientationPatient (0020,0037)"},
             {dicom::pixel_spacing, "", "no PixelSpacing (0028,0030)"},
             {dicom::series_instance_uid, "", "no SeriesInstanceUID (0020,000e)"},
             {dicom::pixel_spacing, "1", "not 2 numbers"},
             {dicom::pixel_spacing, "0\\1", "not above 0"},
             {dicom::image_position_patient, "1\\2\\nan", "not 3 numbers"},
             {dicom::image_position_patient, "1\\2\n\\3\\4", "is '1\\2?\\3\\4', not 3 numbers"},
             {dicom::image_position_patient, "1\\2\\1e300", "farther than"},
             {dicom::image_orientation_patient, "1\\0\\0\\0\\2\\0", "no unit vectors"},
             {dicom::image_orientation_patient, "0\\1\\0\\1\\0\\0", "b.dcm: other ImageOrientationPatient than"},
             {dicom::columns, "5", "other Rows and Columns than"},
             {dicom::frame_of_reference_uid, "1.2.3.8", "other FrameOfReferenceUID than"}}) {
        const TempFolder folder;
        folder.write("a.dcm", at_height(0, 0).bytes());
        CtSlice slice = at_height(3, 1);
        slice[tag] = value;
        folder.write("b.dcm", slice.bytes());
        CHECK_THAT(refusal(folder), Contains(complaint));
    }
    const TempFolder folder;
    CHECK_THAT(error_of(read_image_geometry(folder.write("a.dcm", at_height(0, 0).bytes()))).message,
               Contains("name the folder"));
    CtSlice parallel = at_height(0, 0);
    parallel[dicom::image_orientation_patient] = "1\\0\\0\\1\\0\\0";
    folder.write("a.dcm", parallel.bytes());
    (void)refusal(folder);
}

TEST_CASE("dicom: no damaged header crashes the reader", "[medical]") {
    for (const Syntax syntax : {Syntax::implicit_little, Syntax::explicit_little, Syntax::explicit_big}) {
        const TempFolder folder;
        write_series(folder, syntax);
        CtSlice slice = at_height(39, 9);
        slice.syntax = syntax;
        slice.extra = sequence(syntax, 0x00101002, {element(syntax, 0x00200032, "DS", "9\\9\\9")});
        const auto read = [&](const std::string& bytes) {
            folder.write("9.dcm", bytes);
            return read_image_geometry(folder.path());
        };
        CHECK(refused_of_damaged(slice.bytes(), slice.bytes().size(), 1, read) > 300);
    }
}

TEST_CASE("dicom: a folder is sealed by its slices", "[medical]") {
    const TempFolder folder;
    write_series(folder);
    const FileSeal seal = value_of(seal_file(folder.path()));
    folder.write("other.txt", "beside");
    CHECK(*seal_file(folder.path()) == seal);
    folder.write("3.dcm", at_height(40, 3).bytes());
    CHECK(seal_file(folder.path()).value().sha256 != seal.sha256);
}
