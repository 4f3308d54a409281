#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/shapes.hpp"
#include "lamella/lamella.hpp"
#include "lamella/medical.hpp"
#include "temp_folder.hpp"

using namespace lamella;
using namespace shapes;

namespace {

/// An oblique image, left-handed where asked for.
ImageGeometry oblique(bool left_handed) {
    ImageGeometry image;
    image.size = {5, 6, 7};
    image.spacing_mm = {0.5, 0.75, 2};
    image.origin_mm = {10, -20, 30};
    const double c = std::cos(0.3);
    const double s = std::sin(0.3);
    image.axes = {{{c, s, 0}, {-s, c, 0}, {0, 0, left_handed ? -1.0 : 1.0}}};
    return image;
}

/// An image file that lamella writes, as far as its header.
std::string image_file(const ImageGeometry& image, const std::string& name) {
    SliceOptions options;
    options.plan.spacing = ExplicitPlanes{image.slice_heights_mm()};
    const Result<SliceResult> result = slice(MeshView::soup(floats(box({0, 0, 0}, {1, 1, 1}))), options);
    REQUIRE(result.ok());
    const MaskPart part{&*result, "a"};
    const TempFolder folder;
    REQUIRE(write_mask({&part, 1}, image, folder / name).ok());
    return bytes_of(folder / name);
}

}  // namespace

TEST_CASE("geometry: the frame of slicing puts voxels where their indices say", "[medical]") {
    for (const bool left_handed : {false, true}) {
        const ImageGeometry image = oblique(left_handed);
        const Transform frame = image.slicing_frame(PatientFrame::lps);
        const Transform of_ras = image.slicing_frame(PatientFrame::ras);
        const std::vector<double> heights = image.slice_heights_mm();
        REQUIRE(heights.size() == 7);
        const std::array<double, 3> index = {2, 3, 4};
        std::array<double, 3> at = image.origin_mm;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            for (std::size_t i = 0; i < 3; ++i) {
                at[i] += image.axes[axis][i] * image.spacing_mm[axis] * index[axis];
            }
        }
        const auto moved_by = [](const Transform& by, const std::array<double, 3>& from, std::size_t row) {
            return by.m[4 * row] * from[0] + by.m[4 * row + 1] * from[1] + by.m[4 * row + 2] * from[2] + by.m[4 * row + 3];
        };
        CHECK(moved_by(frame, at, 0) == Approx(1.0));
        CHECK(moved_by(frame, at, 1) == Approx(2.25));
        CHECK(moved_by(frame, at, 2) == Approx(heights[4]));
        CHECK(moved_by(of_ras, {-at[0], -at[1], at[2]}, 0) == Approx(1.0));
        CHECK((heights[1] < heights[0]) == left_handed);
        // A rotation: facets keep their orientation.
        const auto& m = frame.m;
        CHECK(m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) +
                  m[2] * (m[4] * m[9] - m[5] * m[8]) ==
              Approx(1.0));
    }
}

TEST_CASE("geometry: what is written is read back", "[medical]") {
    const TempFolder folder;
    for (const char* name : {"a.nii", "a.nii.gz", "a.nrrd", "a.seg.nrrd"}) {
        for (const bool left_handed : {false, true}) {
            const ImageGeometry image = oblique(left_handed);
            const Result<ImageGeometry> read = read_image_geometry(folder.write(name, image_file(image, name)));
            INFO(name << (read ? "" : read.error().message));
            REQUIRE(read.ok());
            CHECK(read->warnings.empty());
            CHECK(read->size == image.size);
            for (std::size_t i = 0; i < 3; ++i) {
                CHECK(read->spacing_mm[i] == Approx(image.spacing_mm[i]).epsilon(1e-6));
                CHECK(read->origin_mm[i] == Approx(image.origin_mm[i]).epsilon(1e-6));
                for (std::size_t j = 0; j < 3; ++j) {
                    CHECK(read->axes[i][j] == Approx(image.axes[i][j]).margin(1e-6));
                }
            }
        }
    }
}

TEST_CASE("geometry: no damaged header crashes or hangs the reader", "[medical]") {
    const TempFolder folder;
    int refused = 0;
    for (const char* name : {"a.nii", "a.nrrd"}) {
        const std::string whole = image_file(oblique(false), name);
        for (std::size_t at = 0; at < std::min<std::size_t>(whole.size(), 352); at += 3) {
            std::string damaged = whole;
            damaged[at] = static_cast<char>(damaged[at] ^ 0xff);
            for (const std::string& bytes : {damaged, whole.substr(0, at)}) {
                const Result<ImageGeometry> read = read_image_geometry(folder.write("b", bytes));
                if (!read) {
                    ++refused;
                    CHECK(read.error().message.find('\n') == std::string::npos);
                    CHECK(read.error().code == ErrorCode::malformed_mesh);
                } else {
                    CHECK(std::isfinite(read->slicing_frame(PatientFrame::lps).m[3]));
                }
            }
        }
    }
    CHECK(refused > 100);
}

TEST_CASE("geometry: images that say too little or too much are refused by name", "[medical]") {
    const TempFolder folder;
    const std::string whole = image_file(oblique(false), "a.nrrd");
    const auto refusal = [&](const std::string& from, const std::string& to) {
        std::string text = whole;
        const std::size_t at = text.find(from);
        REQUIRE(at != std::string::npos);
        text.replace(at, text.find('\n', at) - at, to);
        const Result<ImageGeometry> read = read_image_geometry(folder.write("a.nrrd", text));
        REQUIRE_FALSE(read.ok());
        return read.error().message;
    };
    CHECK(refusal("space: ", "space: scanner-xyz").find("'scanner-xyz'") != std::string::npos);
    CHECK(refusal("space directions: ", "space directions: (1,0,0) (0.5,1,0) (0,0,1)").find("sheared") != std::string::npos);
    CHECK(refusal("space directions: ", "space directions: (1,0,0) (0,1,0)").find("do not say") != std::string::npos);
    CHECK(refusal("sizes: ", "sizes: 5 6 0").find("0 voxels along k") != std::string::npos);
    CHECK(refusal("space origin: ", "space origin: (1,2)").find("do not say") != std::string::npos);
    std::string nifti = image_file(oblique(false), "a.nii");
    nifti[252] = nifti[254] = 0;
    CHECK(read_image_geometry(folder.write("n.nii", nifti)).error().message.find("sform") != std::string::npos);
    std::string torn = image_file(oblique(false), "a.nii");
    torn[254] = 1;
    torn[268] = 0;
    torn[269] = 0;
    torn[270] = 0;
    torn[271] = 0;
    const Result<ImageGeometry> disagreeing = read_image_geometry(folder.write("d.nii", torn));
    REQUIRE(disagreeing.ok());
    REQUIRE(disagreeing->warnings.size() == 1);
    CHECK(disagreeing->warnings[0].find("disagree") != std::string::npos);
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
    const Result<Record> again = read_record(folder / "r.json");
    REQUIRE(again.ok());
    CHECK(*again == record);
    CHECK(read_record(folder.write("x", "{")).error().message.find("at byte 2") != std::string::npos);
    CHECK(read_record(folder.write("x", "{}")).error().code == ErrorCode::malformed_mesh);
}
