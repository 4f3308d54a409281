// The voxels of many meshes, and shares: tests/readers/solid.py and masks.py.
#include <set>

#include "medical/support.hpp"

using namespace medical;

namespace {

constexpr std::size_t nifti_header_bytes = 352;

/// Writes a mask of these meshes.
MaskSummary summary_of(const std::vector<Soup>& soups, const ImageGeometry& image) {
    std::vector<SliceResult> results(soups.size());
    std::vector<MaskPart> parts(soups.size());
    for (std::size_t i = 0; i < soups.size(); ++i) {
        results[i] = cut(soups[i], image);
        parts[i] = {&results[i], "part"};
    }
    const TempFolder folder;
    return value_of(write_mask(parts, image, folder / "mask.nii"));
}

}  // namespace

TEST_CASE("mask: centres on left and bottom edges are inside, on right and top edges outside", "[medical]") {
    const ImageGeometry image = image_of({8, 8, 3}, {1, 1, 1}, {0, 0, 0});
    const SliceResult result = cut(box({2, 3, -1}, {5, 7, 1.5}), image);
    const MaskPart part{&result, "a"};
    const TempFolder folder;
    value_of(write_mask({&part, 1}, image, folder / "mask.nii"));
    std::string expected;
    for (int i = 0; i < 8 * 8 * 3; ++i) {
        const bool inside = i % 8 >= 2 && i % 8 < 5 && i / 8 % 8 >= 3 && i / 8 % 8 < 7 && i / 64 < 2;
        expected += inside ? '\1' : '\0';
    }
    CHECK(bytes_of(folder / "mask.nii").substr(nifti_header_bytes) == expected);
}

TEST_CASE("mask: the summary tells overlaps, what is open, what the image cuts off, and thin walls", "[medical]") {
    const Soup large = box({0, 0, 0}, {10, 10, 10});
    const MaskSummary overlapping =
        summary_of({large, large, box({2, 2, 2}, {4, 4, 4})}, image_of({12, 12, 12}, {1, 1, 1}, {-0.5, -0.5, -0.5}));
    CHECK(overlapping.overlapped_voxels == 1000);  // once, though some voxels are in three meshes
    CHECK(overlapping.voxels == std::vector<std::uint64_t>{0, 992, 8});

    const Soup open = open_box({0, 0, 10}, {12, 20, 20});
    const MaskSummary half_open =
        summary_of({joined({box({0, 0, 0}, {12, 20, 10}), open}), open}, image_of({6, 20, 20}, {1, 1, 1}, {0.5, 0.5, 0.5}));
    CHECK(half_open.open[0].layers == 10);
    CHECK(half_open.open[0].share() == Approx(0.5));
    CHECK(half_open.open[1].share() == 1);
    CHECK(half_open.cut_off_share[0] == Approx(0.5));  // of areas that are known
    CHECK(std::isnan(half_open.cut_off_share[1]));

    const Soup pierced = joined({octasphere({0, 0, 0}, 9, 4), flipped(octasphere({0, 0, 0}, 5, 3))});
    for (const ImageGeometry& half :
         {image_of({13, 25, 25}, {1, 1, 1}, {-12.5, -12, -12}), image_of({25, 13, 25}, {1, 1, 1}, {-12, 0.5, -12})}) {
        CHECK(summary_of({pierced}, half).cut_off_share[0] == Approx(0.5).margin(0.001));
    }

    const MaskSummary walls = summary_of({box({0, 0, 0}, {10, 0.25, 3}), box({0, 0, 0}, {1.5, 1.5, 3})},
                                         image_of({12, 12, 4}, {1, 1, 1}, {-1, -1, -0.5}));
    CHECK(walls.mean_wall_mm[0] == Approx(0.25));
    CHECK(walls.mean_wall_mm[1] == Approx(1.5));
}

TEST_CASE("mask: shares count once what several contours enclose", "[medical]") {
    const ImageGeometry image = image_of({4, 4, 2}, {1, 1, 1}, {-1, -1, 0.5});
    const Soup body = box({-0.25, 0, 0}, {1.25, 1, 1});
    const TempFolder folder;
    std::set<std::string> masks;
    for (const Soup& soup :
         {body, joined({body, body}), joined({body, flipped(body)}), joined({body, box({0, 0, 0}, {1, 1, 1})})}) {
        const SliceResult result = cut(soup, image);
        const MaskPart part{&result, "a"};
        CHECK(value_of(write_mask({&part, 1}, image, folder / "mask.nii", {.coverage = true})).voxels[0] == 4);
        masks.insert(bytes_of(folder / "mask.nii"));
    }
    CHECK(masks.size() == 1);
}

TEST_CASE("mask: of a sheared image each slice has its own voxels", "[medical]") {
    const ImageGeometry straight = image_of({20, 24, 9}, {1, 0.75, 2}, {-8, -9, -7});
    for (const bool left_handed : {false, true}) {
        ImageGeometry image = straight;
        image.axes[2][2] = left_handed ? -1 : 1;
        ImageGeometry sheared = image;
        sheared.shear_mm = {0.37, -0.61};
        const Soup body = joined(
            {octasphere({1.013, 0.987, left_handed ? -14.1 : 0.1}, 7, 3), box({-30, 0.013, -40}, {2.103, 1.307, 40})});
        Soup moved = body;  // as the image would be if it was not sheared
        for (std::size_t i = 0; i < moved.size(); i += 3) {
            const double slices = (moved[i + 2] + 7) / (left_handed ? -2 : 2);
            moved[i] -= 0.37 * slices;
            moved[i + 1] += 0.61 * slices;
        }
        const SliceResult in_sheared = cut(body, sheared);
        const SliceResult in_straight = cut(moved, image);
        const MaskPart part{&in_sheared, "a"};
        const MaskPart expected{&in_straight, "a"};
        const TempFolder folder;
        for (const bool coverage : {false, true}) {
            const MaskOptions options{.coverage = coverage};
            const MaskSummary found = value_of(write_mask({&part, 1}, sheared, folder / "a.nii", options));
            const MaskSummary wanted = value_of(write_mask({&expected, 1}, image, folder / "b.nii", options));
            const std::string a = bytes_of(folder / "a.nii");
            const std::string b = bytes_of(folder / "b.nii");
            int most = 0;
            for (std::size_t at = nifti_header_bytes; at < a.size(); ++at) {
                most = std::max(most, std::abs(static_cast<unsigned char>(a[at]) - static_cast<unsigned char>(b[at])));
            }
            CHECK(most <= (coverage ? 1 : 0));
            CHECK(found.voxels[0] > 900);
            CHECK(found.cut_off_share[0] == Approx(wanted.cut_off_share[0]));
        }
        value_of(write_mask({&part, 1}, sheared, folder / "a.nrrd"));
        for (const char* name : {"a.nii", "a.nrrd"}) {
            const ImageGeometry read = value_of(read_image_geometry(folder / name));
            for (std::size_t i = 0; i < 9; ++i) {
                CHECK(read.steps_mm()[i / 3][i % 3] == Approx(sheared.steps_mm()[i / 3][i % 3]).margin(1e-6));
            }
            CHECK(read.spacing_mm[2] == Approx(2));
        }
        CHECK(bytes_of(folder / "a.nii").substr(252, 2) == std::string(2, '\0'));  // no qform
    }
}

TEST_CASE("mask: more than 255 meshes take two bytes", "[medical]") {
    const ImageGeometry image = image_of({3, 2, 1}, {1, 1, 1}, {0, 0, 0});
    const SliceResult nothing = cut(box({50, 50, -1}, {51, 51, 1}), image);
    const SliceResult all = cut(box({-1, -1, -1}, {9, 9, 1}), image);
    std::vector<MaskPart> parts(299, {&nothing, "none"});
    parts.push_back({&all, "all"});
    const TempFolder folder;
    REQUIRE(write_mask(parts, image, folder / "many.nii").ok());
    CHECK(bytes_of(folder / "many.nii").substr(nifti_header_bytes) == "\x2c\1\x2c\1\x2c\1\x2c\1\x2c\1\x2c\1");  // 300
}

TEST_CASE("mask: drawn in memory it has the voxels and the summary of the file", "[medical]") {
    const ImageGeometry image = image_of({30, 20, 25}, {0.5, 0.75, 0.5}, {-7, -7, -6});
    const SliceResult one = cut(octasphere({0, 0, 0}, 5, 3), image);
    const SliceResult two = cut(octasphere({4, 2, 0}, 4, 3), image);
    const TempFolder folder;
    const auto check_same = [&](const std::vector<MaskPart>& parts, const MaskOptions& options, int threads) {
        std::vector<unsigned char> voxels(30 * 20 * 25 * (parts.size() > 255 ? 2U : 1U), 7);
        const MaskSummary drawn = value_of(draw_mask(parts, image, voxels, options, {.threads = threads}));
        const MaskSummary written = value_of(write_mask(parts, image, folder / "a.nii", options));
        CHECK(bytes_of(folder / "a.nii").substr(nifti_header_bytes) == std::string(voxels.begin(), voxels.end()));
        CHECK(drawn.voxels == written.voxels);
        CHECK(drawn.overlapped_voxels == written.overlapped_voxels);
        CHECK(drawn.cut_off_share[0] == written.cut_off_share[0]);
    };
    for (const int threads : {1, 3}) {
        check_same({{&one, "a"}, {&two, "b"}}, {}, threads);
        check_same({{&one, "a"}}, {.coverage = true}, threads);
        check_same(std::vector<MaskPart>(300, MaskPart{&two, "b"}), {}, threads);
    }
    const MaskPart part{&one, "a"};
    std::vector<unsigned char> whole(30 * 20 * 25);
    (void)value_of(draw_mask({&part, 1}, image, whole));
    std::vector<unsigned char> by_turns(whole.size(), 7);
    for (const auto& [first, count] : {std::pair<std::size_t, std::size_t>{3, 22}, {0, 3}}) {
        const auto slices = std::span(by_turns).subspan(600 * first, 600 * count);
        (void)value_of(draw_mask({&part, 1}, image, slices, {.first_slice = first}));
        CHECK(code_of(draw_mask({&part, 1}, image, slices, {.first_slice = 26 - count})) == ErrorCode::invalid_argument);
    }
    CHECK(by_turns == whole);
    std::vector<unsigned char> short_of_one(30 * 20 * 25 - 1);
    CHECK(error_of(draw_mask({&part, 1}, image, short_of_one)).message ==
          "the voxels do not have the size of slices of the image");
    CHECK(code_of(draw_mask({}, image, short_of_one)) == ErrorCode::invalid_argument);
    ImageGeometry uneven = image;
    uneven.uneven_slices_mm = {0, 1, 3};
    CHECK(code_of(draw_mask({&part, 1}, uneven, short_of_one)) == ErrorCode::invalid_argument);
}

TEST_CASE("mask: what cannot be written is refused, and leaves nothing", "[medical]") {
    const ImageGeometry image = image_of({4, 4, 6}, {1, 1, 1}, {0, 0, 0});
    const Soup body = box({0, 0, -1}, {3, 3, 4.5});
    const SliceResult whole = cut(body, image);
    const TempFolder folder;
    const auto check_refusal = [&](const SliceResult& result, const ImageGeometry& at, const char* name, const char* why) {
        const MaskPart part{&result, "a"};
        const Error error = error_of(write_mask({&part, 1}, at, folder / name));
        CHECK(error.code == ErrorCode::invalid_argument);
        CHECK_THAT(error.message, Contains(why));
        CHECK(folder.names().empty());
    };
    const auto sized = [](std::uint64_t i, std::uint64_t j, std::uint64_t k) {
        return image_of({i, j, k}, {1, 1, 1}, {0, 0, 0});
    };
    const char* const not_cut = "'a' was not cut at the slices of the image";
    check_refusal(whole, image, "a.png", "ends in .nii");
    check_refusal(whole, sized(40000, 4, 4), "a.nii", "32,767");
    check_refusal(whole, sized(10000, 10000, 10000), "a.nrrd", "2^38");
    check_refusal(whole, sized(4, 4, 5), "a.nii", not_cut);
    // Slices that were left out.
    SliceOptions options = at_slices(image);
    for (const auto& [first, end] : {std::pair{0U, 3U}, {2U, 5U}, {3U, 6U}}) {
        options.planes.first_layer = first;
        options.planes.end_layer = end;
        check_refusal(sliced(body, options), image, "a.nii", not_cut);
    }
}
