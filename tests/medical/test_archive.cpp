#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "lamella/lamella.hpp"
#include "lamella/medical.hpp"
#include "temp_folder.hpp"

using namespace lamella;
using namespace shapes;
using Catch::Contains;

namespace {

namespace fs = std::filesystem;

/// A box with a cavity and an open sheet beside it: outers, holes and open polylines.
Soup specimen() {
    return joined({box({0, 0, 0}, {9, 8, 7}), flipped(box({2, 2, 1}, {4, 5, 6})), octasphere({20, 4, 3}, 3.3, 2),
                   triangle({30, 0, 0}, {35, 1, 0}, {31, 2, 6.5})});
}

SliceResult cut(const Soup& soup, const SliceOptions& options) {
    return sliced(MeshView::soup(floats(soup)), options);
}

SliceOptions fine(double layer_height_mm = 0.25) {
    return uniform(layer_height_mm);
}

fs::path written(const TempFolder& folder, const std::string& name, const SliceResult& result, const ArchiveInfo& info = {},
                 int threads = 0) {
    require_ok(write_archive(result, info, folder / name, {.threads = threads}));
    return folder / name;
}

Archive read_back(const fs::path& path) {
    return value_of(read_archive(path));
}

ImageGeometry one_voxel() {
    ImageGeometry image;
    image.size = {1, 1, 1};
    return image;
}

void require_equal(const SliceResult& a, const SliceResult& b) {
    CHECK(a.hash() == b.hash());
    CHECK(std::ranges::equal(a.layers, b.layers, [](const Layer& one, const Layer& other) {
        return one.bottom_mm == other.bottom_mm && one.plane_mm == other.plane_mm && one.top_mm == other.top_mm &&
               one.segments == other.segments;
    }));
    CHECK(std::ranges::equal(a.contours, b.contours, [](const Contour& one, const Contour& other) {
        return one.twice_area == other.twice_area && one.parent == other.parent && one.flags == other.flags;
    }));
    CHECK(std::ranges::equal(a.points, b.points));
    CHECK(std::ranges::equal(a.origins, b.origins));
    CHECK(a.info.layer_of == b.info.layer_of);
    CHECK(a.stitches.size() == b.stitches.size());
    CHECK(a.info.options == b.info.options);
    CHECK(a.info.grid_mm == b.info.grid_mm);
    CHECK(a.info.box == b.info.box);
    for (const auto count :
         {&SliceInfo::first_layer, &SliceInfo::planned_layers, &SliceInfo::stitches, &SliceInfo::segments, &SliceInfo::holes,
          &SliceInfo::open_contours, &SliceInfo::emptied_layers, &SliceInfo::triangles}) {
        CHECK(a.info.*count == b.info.*count);
    }
}

/// The message of reading what is no good archive.
std::string complaint_of(const fs::path& path) {
    const std::string message = error_of(read_archive(path)).message;
    CHECK_THAT(message, Contains(path.filename().string()));
    return message;
}

std::string merge_complaint(const std::vector<fs::path>& parts, const fs::path& to) {
    const Error error = error_of(merge_archives(parts, to));
    CHECK(error.code == ErrorCode::invalid_argument);
    CHECK(!fs::exists(to));
    return error.message;
}

/// Ranges of the layers, each ending where the next begins.
std::vector<fs::path> write_parts(const TempFolder& folder, const Soup& soup, SliceOptions options,
                                  const std::vector<std::uint64_t>& ends, const ArchiveInfo& info = {}) {
    std::vector<fs::path> paths;
    std::uint64_t first = 0;
    for (const std::uint64_t end : ends) {
        options.planes.first_layer = first;
        options.planes.end_layer = end;
        paths.push_back(written(folder, "part" + std::to_string(first) + ".h5", cut(soup, options), info));
        first = end;
    }
    return paths;
}

// Another value than the default.
void change(double& value) {
    value = 1.25;
}
void change(bool& value) {
    value = !value;
}
void change(std::uint64_t& value) {
    value = 0;
}
void change(std::optional<double>& value) {
    value = 0.5;
}
void change(Transform& value) {
    value = Transform::scale(2);
}
void change(std::optional<std::vector<double>>& value) {
    value = {7, 3};
}
void change(std::vector<FillFrom>& value) {
    value = {{4, FillRule::positive}, {5, FillRule::even_odd}};
}
template <class Choice>
requires std::is_enum_v<Choice>
void change(Choice& value) {
    value = static_cast<Choice>(1);
}

}  // namespace

TEST_CASE("an archive holds every option") {
    SliceResult result;
    SliceInfo& info = result.info;
#define OPTION(kind, name, path, ...) change(info.options.path);
#include "options/options.inc"
    info.layer_of = {1, 0};
    info.planned_layers = 2;
    const TempFolder folder;
    const Archive again = read_back(written(folder, "a.h5", result));
    CHECK(again.result.info.options == info.options);
    CHECK(again.result.info.layer_of == info.layer_of);
}

TEST_CASE("an archive reads back as it was written") {
    CHECK(has_archives());
    const TempFolder folder;
    SliceOptions options = fine();
    options.origins = true;
    options.stitch_mm = 50;
    SECTION("uniform") {}
    SECTION("given heights, twice one, and outside") {
        options.heights_mm = std::vector<double>{3, 1.5, 99, 1.5, -2, 6.25};
        options.planes.side = PlaneSide::above;
    }
    SECTION("regions") {
        options.region.fill_rule = FillRule::non_zero;
        options.region.fill_from = {{4, FillRule::even_odd}, {9, FillRule::outermost}};
        options.region.offset_mm = -0.1;
    }
    SECTION("moved") {
        options.frame.transform = Transform::from_normal(1, 2, 3);
        options.planes.first_height_mm = 0.07;
    }
    const SliceResult result = cut(specimen(), options);
    ImageGeometry image;
    image.size = {3, 4, 5};
    image.origin_mm = {-1.5, 2, 7};
    image.uneven_slices_mm = {0, 1, 3, 4, 9};
    const ArchiveInfo info{.name = "left \xc3\xa4 lung",
                           .mesh_sha256 = std::string(64, 'a'),
                           .frame = PatientFrame::ras,
                           .weld = ArchiveWeld{0.01, 7},
                           .geometry = image,
                           .subslices = 3};
    const Archive again = read_back(written(folder, "a.h5", result, info));
    require_equal(again.result, result);
    CHECK(again.info.name == info.name);
    CHECK(again.info.mesh_sha256 == info.mesh_sha256);
    CHECK(again.info.frame == PatientFrame::ras);
    REQUIRE(again.info.weld.has_value());
    CHECK(again.info.weld->joined == 7);
    REQUIRE(again.info.geometry.has_value());
    CHECK(again.info.geometry->size == image.size);
    CHECK(again.info.geometry->origin_mm == image.origin_mm);
    CHECK(again.info.geometry->axes == image.axes);
    CHECK(again.info.geometry->uneven_slices_mm == image.uneven_slices_mm);
    CHECK(again.info.subslices == 3);
    // What was read writes the same bytes.
    CHECK(bytes_of(written(folder, "b.h5", again.result, again.info)) == bytes_of(folder / "a.h5"));
}

TEST_CASE("equal results are equal archives, on any number of threads") {
    const TempFolder folder;
    // More rows than a block holds.
    const Soup soup = octasphere({0, 0, 0}, 30, 5);
    SliceOptions options = fine(0.02);
    const SliceResult result = cut(soup, options);
    REQUIRE(result.points.size() > (std::size_t{1} << 18));
    const std::string bytes = bytes_of(written(folder, "a.h5", result, {.name = "a"}, 1));
    CHECK(bytes_of(written(folder, "b.h5", result, {.name = "a"}, 3)) == bytes);
    CHECK(bytes_of(written(folder, "c.h5", cut(shuffled(soup, 3), options), {.name = "a"}, 2)) == bytes);
    require_equal(read_back(folder / "c.h5").result, result);
    CHECK(folder.names() == std::vector<std::string>{"a.h5", "b.h5", "c.h5"});
}

TEST_CASE("an archive of no layers and of no contours reads back") {
    const TempFolder folder;
    SliceOptions options;
    options.heights_mm = std::vector<double>{50, 60};
    require_equal(read_back(written(folder, "a.h5", cut(specimen(), options))).result, cut(specimen(), options));
    options.heights_mm.reset();
    options.layer_height_mm = 100;
    require_equal(read_back(written(folder, "b.h5", cut(specimen(), options))).result, cut(specimen(), options));
}

TEST_CASE("no flipped byte of an archive goes unnoticed") {
    const TempFolder folder;
    SliceOptions options = fine(2);
    options.origins = true;
    const SliceResult result = cut(joined({box({0, 0, 0}, {9, 8, 7}), flipped(box({2, 2, 1}, {4, 5, 6}))}), options);
    const std::string bytes = bytes_of(written(folder, "a.h5", result, {.name = "box", .geometry = one_voxel()}));
    std::size_t harmless = 0;
    for (std::size_t i = 0; i < bytes.size(); i += i < 1024 ? 1 : 3) {
        std::string damaged = bytes;
        damaged[i] = static_cast<char>(damaged[i] ^ (1 << (i % 8)));
        const Result<Archive> read = read_archive(folder.write("d.h5", damaged));
        if (read) {
            ++harmless;
            CHECK(read->result.hash() == result.hash());
        } else {
            CHECK_THAT(read.error().message, Contains("d.h5: "));
            CHECK(read.error().message.find('\n') == std::string::npos);
        }
    }
    INFO(harmless << " of " << bytes.size() << " bytes are of no effect");
    CHECK(harmless == 0);
}

TEST_CASE("an archive that is cut off is refused, wherever it ends") {
    const TempFolder folder;
    const std::string bytes = bytes_of(written(folder, "a.h5", cut(specimen(), fine(2))));
    for (std::size_t end = 0; end < bytes.size(); end += end < 1024 || end + 64 > bytes.size() ? 1U : 37U) {
        CHECK(!read_archive(folder.write("d.h5", bytes.substr(0, end))).ok());
    }
    CHECK_THAT(complaint_of(folder.write("d.h5", bytes.substr(0, 5))), Contains("no HDF5 file"));
    CHECK_THAT(complaint_of(folder.write("d.h5", bytes.substr(0, bytes.size() / 2))), Contains("cut off"));
}

TEST_CASE("what is no archive is refused by name") {
    const TempFolder folder;
    CHECK_THAT(complaint_of(folder / "none.h5"), Contains("cannot be opened"));
    CHECK_THAT(complaint_of(folder.write("empty.h5", "")), Contains("no HDF5 file"));
    CHECK_THAT(complaint_of(folder.write("text.h5", "solid of some words")), Contains("no HDF5 file"));
    CHECK_THAT(complaint_of(folder.path()), Contains("is a directory"));
    CHECK_THAT(complaint_of(folder.write("old.h5", "lamella archive 1\ntree 9216")), Contains("another version"));
    // The last line belongs to the bytes before it.
    const std::string bytes = bytes_of(written(folder, "a.h5", cut(specimen(), fine(2))));
    const std::string other = bytes_of(written(folder, "b.h5", cut(specimen(), fine(1))));
    const auto last_line = [](const std::string& all) { return all.rfind('\n', all.size() - 2); };
    CHECK(bytes.substr(last_line(bytes)).starts_with("\nlamella archive 3, CRC-32 of all before: "));
    CHECK_THAT(complaint_of(folder.write("d.h5", bytes.substr(0, last_line(bytes)) + other.substr(last_line(other)))),
               Contains("damaged"));
    CHECK_THAT(complaint_of(folder.write("d.h5", bytes + "x")), Contains("last line"));
    std::string older = bytes;
    older[last_line(bytes) + std::string_view("\nlamella archive ").size()] = '2';
    CHECK_THAT(complaint_of(folder.write("d.h5", older)), Contains("an archive of form 2, not 3"));
}

TEST_CASE("an archive that cannot be written leaves nothing") {
    const TempFolder folder;
    const SliceResult result = cut(specimen(), fine(2));
    CHECK(write_archive(result, {}, folder / "none" / "a.h5").error().code == ErrorCode::unwritable_file);
    CHECK(write_archive(result, {.name = std::string(5000, 'n')}, folder / "a.h5").error().code ==
          ErrorCode::invalid_argument);
    CHECK(write_archive(result, {}, folder / "a.h5", {.threads = -1}).error().code == ErrorCode::invalid_argument);
    const auto stop = []() noexcept { return true; };
    CHECK(write_archive(result, {}, folder / "a.h5", {.stop = stop}).error().code == ErrorCode::cancelled);
    if (fs::exists("/dev/full")) {
        CHECK(write_archive(result, {}, "/dev/full").error().message == "cannot write '/dev/full': No space left on device");
    }
    CHECK(folder.names().empty());
    written(folder, "a.h5", result);
    CHECK(read_archive(folder / "a.h5", {.stop = stop}).error().code == ErrorCode::cancelled);
    CHECK(merge_archives(std::vector{folder / "a.h5"}, folder / "b.h5", {.stop = stop}).error().code ==
          ErrorCode::cancelled);
    CHECK(folder.names() == std::vector<std::string>{"a.h5"});
}

TEST_CASE("parts joined in any order are the bytes of the whole") {
    const TempFolder folder;
    SliceOptions options = fine(0.1);
    options.origins = true;
    options.stitch_mm = 50;
    const ArchiveInfo info{.name = "whole"};
    SECTION("uniform") {}
    SECTION("given heights") {
        options.heights_mm.emplace();
        for (int i = 0; i < 70; ++i) {
            options.heights_mm->push_back(7 - 0.1 * i);
        }
    }
    SECTION("regions") {
        options.region.fill_rule = FillRule::positive;
        options.region.fill_from = {{30, FillRule::even_odd}};
    }
    const std::string whole = bytes_of(written(folder, "whole.h5", cut(specimen(), options), info));
    std::vector<fs::path> parts = write_parts(folder, specimen(), options, {1, 2, 25, 60, 1000}, info);
    for (int round = 0; round < 3; ++round) {
        const MergedArchive merged = value_of(merge_archives(parts, folder / "m.h5"));
        CHECK(merged.hash == cut(specimen(), options).hash());
        CHECK(merged.info.name == "whole");
        CHECK(bytes_of(folder / "m.h5") == whole);
        std::rotate(parts.begin(), parts.begin() + 2, parts.end());
    }
    CHECK(merge_archives(std::vector{folder / "whole.h5"}, folder / "w.h5").ok());
    CHECK(bytes_of(folder / "w.h5") == whole);
}

TEST_CASE("parts that do not make a whole are refused by their names") {
    const TempFolder folder;
    const std::vector<fs::path> parts = write_parts(folder, specimen(), fine(0.5), {4, 8, 1000});
    const fs::path to = folder / "m.h5";
    CHECK(merge_complaint({}, to) == "no archives to join");
    CHECK_THAT(merge_complaint({parts[0], parts[2]}, to), Contains("layers 4 to 7 lie in neither"));
    CHECK_THAT(merge_complaint({parts[0], parts[2]}, to), Contains("part8.h5"));
    CHECK_THAT(merge_complaint({parts[1], parts[2]}, to), Contains("layers 0 to 3 are missing before"));
    CHECK_THAT(merge_complaint({parts[0], parts[1]}, to), Contains("are missing after"));
    CHECK_THAT(merge_complaint({parts[0], parts[1], parts[1], parts[2]}, to), Contains("both hold layers 4 to 7"));
    const auto other = [&](const std::string& name, const Soup& soup, SliceOptions options, const ArchiveInfo& info = {}) {
        options.planes.first_layer = 4;
        options.planes.end_layer = 8;
        return merge_complaint({parts[0], written(folder, name, cut(soup, options), info), parts[2]}, to);
    };
    CHECK_THAT(other("a.h5", specimen(), fine(0.51)), Contains("/options/layer_height_mm"));
    CHECK_THAT(other("b.h5", moved(specimen(), {1, 0, 0}), fine(0.5)), Contains("they differ in /mesh/min_mm"));
    CHECK_THAT(other("c.h5", specimen(), fine(0.5), {.mesh_sha256 = "1"}), Contains("they differ in /mesh/sha256"));
    SliceOptions coarse = fine(0.5);
    coarse.frame.grid_mm = default_grid_mm * 2;
    CHECK_THAT(other("d.h5", specimen(), coarse), Contains("they differ in /grid_mm"));
    SliceOptions with_origins = fine(0.5);
    with_origins.origins = true;
    CHECK_THAT(other("e.h5", specimen(), with_origins), Contains("/options/origins"));
}
