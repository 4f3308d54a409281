#include <cstring>
#include <map>
#include <utility>

#include "base/words.hpp"
#include "input/files.hpp"
#include "medical/support.hpp"

using namespace medical;

namespace {

/// An oblique image, left-handed where asked for.
ImageGeometry oblique(bool left_handed) {
    ImageGeometry image = image_of({5, 6, 7}, {0.5, 0.75, 2}, {10, -20, 30});
    const double c = std::cos(0.3);
    const double s = std::sin(0.3);
    image.axes = {{{c, s, 0}, {-s, c, 0}, {0, 0, left_handed ? -1.0 : 1.0}}};
    return image;
}

/// An image file that lamella writes, as far as its header.
std::string image_file(const ImageGeometry& image, const std::string& name) {
    const SliceResult result = sliced(box({0, 0, 0}, {1, 1, 1}), {.heights_mm = image.slice_heights_mm()});
    const MaskPart part{&result, "a"};
    const TempFolder folder;
    REQUIRE(write_mask({&part, 1}, image, folder / name).ok());
    return bytes_of(folder / name);
}

/// NIfTI-2 (bytes from nifti2.h) of the NIfTI-1 header of a file, in either byte order.
std::string as_nifti_2(const std::string& one, bool big) {
    const auto number = [&](std::size_t at, auto value) {
        std::memcpy(&value, one.data() + at, sizeof value);
        return value;
    };
    const auto real = [&](std::size_t at) { return input_test::bytes_of(static_cast<double>(number(at, 0.0F)), big); };
    std::string two = input_test::bytes_of(std::int32_t{540}, big) + std::string("n+2\0\r\n\x1a\n", 8);
    two.resize(544, '\0');
    for (std::size_t i = 0; i < 8; ++i) {
        two.replace(16 + 8 * i, 8, input_test::bytes_of(std::int64_t{number(40 + 2 * i, std::int16_t{0})}, big));
        two.replace(104 + 8 * i, 8, real(76 + 4 * i));
    }
    for (std::size_t i = 0; i < 18; ++i) {  // quatern, qoffset, srow
        two.replace(352 + 8 * i, 8, real(256 + 4 * i));
    }
    two.replace(344, 4, input_test::bytes_of(std::int32_t{1}, big));
    two.replace(348, 4, input_test::bytes_of(std::int32_t{1}, big));
    return two.replace(500, 4, input_test::bytes_of(std::int32_t{2}, big));
}

std::string numbers_text(const std::array<double, 3>& numbers) {
    std::string text;
    for (const double number : numbers) {
        text += exact_text(number) + " ";
    }
    return text;
}

/// As it is written, but for lines that are exchanged by their keys.
std::string meta_image(const ImageGeometry& image, const std::map<std::string, std::string>& other = {}) {
    std::string text = image_file(image, "a.mha");
    for (const auto& [key, line] : other) {
        const std::size_t at = text.find(key + " =");
        text.replace(at, text.find('\n', at) - at, line);
    }
    return text;
}

void check_same(const ImageGeometry& read, const ImageGeometry& image) {
    CHECK(read.warnings.empty());
    CHECK(read.size == image.size);
    for (std::size_t i = 0; i < 3; ++i) {
        CHECK(read.spacing_mm[i] == Approx(image.spacing_mm[i]).epsilon(1e-6));
        CHECK(read.origin_mm[i] == Approx(image.origin_mm[i]).epsilon(1e-6));
        for (std::size_t j = 0; j < 3; ++j) {
            CHECK(read.axes[i][j] == Approx(image.axes[i][j]).margin(1e-6));
        }
    }
}

std::array<double, 3> moved_by(const Transform& by, const std::array<double, 3>& from) {
    std::array<double, 3> to{};
    for (std::size_t row = 0; row < 3; ++row) {
        const double* const m = by.m.data() + 4 * row;
        to[row] = m[0] * from[0] + m[1] * from[1] + m[2] * from[2] + m[3];
    }
    return to;
}

}  // namespace

TEST_CASE("geometry: the frame of slicing puts voxels where their indices say, and leads back to the patient", "[medical]") {
    for (const bool left_handed : {false, true}) {
        const ImageGeometry image = oblique(left_handed);
        const std::vector<double> heights = image.slice_heights_mm();
        std::array<double, 3> at = image.origin_mm;  // of voxel (2, 3, 4)
        for (std::size_t i = 0; i < 9; ++i) {
            at[i % 3] += image.axes[i / 3][i % 3] * image.spacing_mm[i / 3] * static_cast<double>(2 + i / 3);
        }
        const std::array<double, 3> sliced = moved_by(image.slicing_frame(PatientFrame::lps), at);
        const std::array<double, 3> of_ras = moved_by(image.slicing_frame(PatientFrame::ras), {-at[0], -at[1], at[2]});
        const std::array<double, 3> expected = {1, 2.25, heights[4]};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            CHECK(sliced[axis] == Approx(expected[axis]));
            CHECK(of_ras[axis] == Approx(expected[axis]));
            CHECK(image.to_lps(sliced)[axis] == Approx(at[axis]));
        }
        CHECK(image.slice_axis() == 2);
        CHECK(image.height_lps_mm(sliced[2]) == Approx(at[2]));
        CHECK((heights[1] < heights[0]) == left_handed);  // so the frame turns, and mirrors nothing
    }
    ImageGeometry coronal;  // i x j points to the front, away from posterior
    coronal.axes = {{{1, 0, 0}, {0, 0, 1}, {0, -1, 0}}};
    coronal.origin_mm = {0, 80, 0};
    CHECK(coronal.slice_axis() == 1);
    CHECK(coronal.height_lps_mm(30) == 50);
}

TEST_CASE("geometry: an image around a box is centred on it", "[medical]") {
    const auto [low, high, spacing, voxels, first] = GENERATE(table<double, double, double, std::uint64_t, double>({
        {0, 44, 1, 44, 0.5},
        {-10, 34.5, 1, 45, -9.75},
        {0, 0.3, 0.1, 3, 0.05},
        {0, 1.1, 0.1, 11, 0.05},
        {0, static_cast<double>(4.4F), 0.1, 44, 0.05},
        {7, 7, 2, 1, 7},
    }));
    const ImageGeometry image =
        value_of(geometry_around({{low, low, low}, {high, high, high}}, {spacing, spacing, spacing}));
    for (std::size_t axis = 0; axis < 3; ++axis) {
        CHECK(image.size[axis] == voxels);
        CHECK(image.origin_mm[axis] == Approx(first).margin(1e-6));
        CHECK(static_cast<double>(static_cast<float>(image.origin_mm[axis])) == image.origin_mm[axis]);
    }
}

TEST_CASE("geometry: units that a header states become mm, others are refused by name", "[medical]") {
    const TempFolder folder;
    const std::string nrrd = image_file(oblique(false), "a.nrrd");
    const auto with_field = [&](const std::string& field) {
        std::string text = nrrd;
        return read_image_geometry(folder.write("a.nrrd", text.insert(text.find("sizes:"), field + "\n")));
    };
    const auto require_unit = [](const Result<ImageGeometry>& read, double mm) {
        const ImageGeometry image = value_of(read);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            CHECK(image.spacing_mm[axis] == Approx(mm * oblique(false).spacing_mm[axis]));
            CHECK(image.origin_mm[axis] == Approx(mm * oblique(false).origin_mm[axis]));
        }
    };
    using Units = std::vector<std::string>;
    for (const auto& [mm, units] : {std::pair{1.0, Units{"", "mm", "Millimetres"}},
                                    {1e-3, {"microns", "um", "\xc2\xb5m", "micrometer"}},
                                    {1e-6, {"nm"}},
                                    {10, {"cm"}},
                                    {1000, {"m"}},
                                    {25.4, {"inches"}}}) {
        for (const std::string& unit : units) {
            INFO(unit);
            const std::string quoted = "\"" + unit + "\" ";
            require_unit(with_field("space units: " + quoted + quoted + quoted), mm);
        }
    }
    CHECK_THAT(error_of(with_field("space units: \"mm\" \"parsec\" \"mm\"")).message,
               Contains("unit \"parsec\" is not known"));
    CHECK_THAT(error_of(with_field("space units: \"mm\" \"mm\"")).message, Contains("2, not one for each"));
    CHECK_THAT(error_of(with_field("units: \"um\" \"um\" \"um\"")).message, Contains("state 'space units'"));

    std::string nifti = image_file(oblique(false), "a.nii");
    const auto with_code = [&](int code) {
        nifti[123] = static_cast<char>(code);
        return read_image_geometry(folder.write("a.nii", nifti));
    };
    for (const auto& [code, mm] : {std::pair{0, 1.0}, {1, 1000.0}, {2, 1.0}, {3, 0.001}, {2 | 8, 1.0}}) {
        require_unit(with_code(code), mm);
    }
    CHECK_THAT(error_of(with_code(5)).message, Contains("unit of length 5"));
}

TEST_CASE("geometry: what is written is read back, and no damaged header crashes or hangs the reader", "[medical]") {
    const TempFolder folder;
    for (const char* name : {"a.nii", "a.nii.gz", "a.nrrd", "a.seg.nrrd"}) {
        for (const bool left_handed : {false, true}) {
            const ImageGeometry image = oblique(left_handed);
            const ImageGeometry read = value_of(read_image_geometry(folder.write(name, image_file(image, name))));
            check_same(read, image);
        }
    }
    for (const char* name : {"a.nii", "a.nrrd"}) {
        const auto read = [&](const std::string& bytes) { return read_image_geometry(folder.write("b", bytes)); };
        CHECK(refused_of_damaged(image_file(oblique(false), name), 352, 3, read) > 50);
    }
}

TEST_CASE("geometry: NIfTI-2 and MetaImage say the same in every form, and no damaged one crashes the reader", "[medical]") {
    const TempFolder folder;
    const auto read = [&](const std::string& bytes) { return read_image_geometry(folder.write("b", bytes)); };
    for (const bool left_handed : {false, true}) {
        const ImageGeometry image = oblique(left_handed);
        const std::string nifti = image_file(image, "a.nii");
        check_same(value_of(read(as_nifti_2(nifti, false))), image);
        check_same(value_of(read(as_nifti_2(nifti, true))), image);
        std::string pair = as_nifti_2(nifti, false);
        pair.replace(4, 3, "ni2");
        pair.resize(540);
        check_same(value_of(read(pair)), image);
        const std::string matrix = numbers_text(image.axes[0]) + numbers_text(image.axes[1]) + numbers_text(image.axes[2]);
        for (const std::map<std::string, std::string>& form : std::vector<std::map<std::string, std::string>>{
                 {},
                 {{"BinaryDataByteOrderMSB", "ElementByteOrderMSB = True\nCompressedData = True\nHeaderSize = -1"}},
                 {{"TransformMatrix", "Rotation = " + matrix}, {"Offset", "Origin=" + numbers_text(image.origin_mm)}},
                 {{"TransformMatrix", "Orientation =" + matrix + "\r"},
                  {"Offset", "\nPosition = " + numbers_text(image.origin_mm)}},
                 {{"ElementDataFile", "ElementDataFile = LIST\na.raw"},
                  {"ObjectType", "Comment = " + std::string(9000, 'x')}},
                 {{"NDims", "NDims = 4"},
                  {"TransformMatrix", "TransformMatrix = " + numbers_text(image.axes[0]) + "0 " +
                                          numbers_text(image.axes[1]) + "0 " + numbers_text(image.axes[2]) + "0 0 0 0 1"},
                  {"Offset", "Offset = " + numbers_text(image.origin_mm) + "0"},
                  {"ElementSpacing", "ElementSpacing = " + numbers_text(image.spacing_mm) + "1"},
                  {"DimSize", "DimSize = 5 6 7 1"}}}) {
            check_same(value_of(read(meta_image(image, form))), image);
        }
    }
    const ImageGeometry image = oblique(false);
    ImageGeometry straight = image;
    straight.axes = ImageGeometry{}.axes;
    check_same(value_of(read(meta_image(straight, {{"TransformMatrix", "Comment = none"}}))), straight);
    for (const auto& [key, line, complaint] : std::vector<std::array<std::string, 3>>{
             {"NDims", "NDims = 2", "of 2 dimensions"},
             {"NDims", "NDims = 1e99", "dimensions, not of 3"},
             {"NDims", "Comment = ", "of 0 dimensions"},
             {"TransformMatrix", "TransformMatrix = 1 0 0 0 1 0 0.3 0 0.95", "sheared"},
             {"TransformMatrix", "TransformMatrix = 1 0 0 0 1 0 0 0", "TransformMatrix is not 9 numbers"},
             {"TransformMatrix", "TransformMatrix = 0 0 0 0 0 0 0 0 0", "no finite length"},
             {"Offset", "Comment = ", "do not say"},
             {"Offset", "Offset = 1 2 nan", "Offset is not 3 numbers"},
             {"ElementSpacing", "Comment = ", "do not say"},
             {"DimSize", "DimSize = 5 6 -7", "0 voxels along k"},
             {"DimSize", "DimSize = 5 6 1e300", "voxels along k"},
             {"DimSize", "DimSize 5 6 7", "line 12 of its header"},
             {"ElementDataFile", "", "line 15 of its header"}}) {
        CHECK_THAT(error_of(read(meta_image(image, {{key, line}}))).message, Contains(complaint));
    }
    const std::string whole = meta_image(image);
    CHECK_THAT(error_of(read(whole.substr(0, whole.find("ElementDataFile")))).message, Contains("does not end with"));
    CHECK(refused_of_damaged(whole, 500, 1, read) > 200);
    CHECK(refused_of_damaged(as_nifti_2(image_file(image, "a.nii"), true), 544, 3, read) > 50);
}

TEST_CASE("geometry: images that say too little or too much are refused by name", "[medical]") {
    const TempFolder folder;
    const std::string whole = image_file(oblique(false), "a.nrrd");
    for (const auto& [field, value, complaint] :
         std::vector<std::array<std::string, 3>>{{"space: ", "scanner-xyz", "'scanner-xyz'"},
                                                 {"space directions: ", "(1,0,0) (0.5,1,0) (0,0,1)", "sheared"},
                                                 {"space directions: ", "(1,0,0) (0,1,0)", "do not say"},
                                                 {"sizes: ", "5 6 0", "0 voxels along k"},
                                                 {"space origin: ", "(1,2)", "do not say"}}) {
        std::string text = whole;
        const std::size_t at = text.find(field) + field.size();
        text.replace(at, text.find('\n', at) - at, value);
        CHECK_THAT(error_of(read_image_geometry(folder.write("a.nrrd", text))).message, Contains(complaint));
    }
    std::string nifti = image_file(oblique(false), "a.nii");
    nifti[252] = nifti[254] = 0;
    CHECK_THAT(read_image_geometry(folder.write("n.nii", nifti)).error().message, Contains("sform"));
    std::string torn = image_file(oblique(false), "a.nii");
    torn[254] = 1;
    torn.replace(268, 4, 4, '\0');
    const ImageGeometry disagreeing = value_of(read_image_geometry(folder.write("d.nii", torn)));
    REQUIRE(disagreeing.warnings.size() == 1);
    CHECK_THAT(disagreeing.warnings[0], Contains("disagree"));
    CHECK(read_image_geometry(folder / "none").error().code == ErrorCode::unreadable_file);
}

TEST_CASE("record: what is written is read back, and what is none is refused", "[medical]") {
    const TempFolder folder;
    Record record;
    record.version = "1";
    record.command = "slice";
    record.source_date_epoch = "1700000000";
    record.output = *seal_file(folder.write("abc", "abc"));
    CHECK(record.output.sha256 == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    record.options = {"--frame", "ras"};
    record.grid_mm = {0x1p-20};
    REQUIRE(write_record(record, folder / "r.json").ok());
    const Record again = value_of(read_record(folder / "r.json"));
    CHECK(again == record);
    CHECK_THAT(read_record(folder.write("x", "{")).error().message, Contains("at byte 2"));
    CHECK(read_record(folder.write("x", "{}")).error().code == ErrorCode::malformed_mesh);
}
