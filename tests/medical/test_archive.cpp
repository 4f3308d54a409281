#include <optional>
#include <type_traits>
#include <utility>

#include "medical/support.hpp"

using namespace medical;

namespace {

namespace fs = std::filesystem;

/// A box with a cavity and an open sheet beside it: outers, holes and open polylines.
Soup specimen() {
    return joined({box({0, 0, 0}, {9, 8, 7}), flipped(box({2, 2, 1}, {4, 5, 6})), octasphere({20, 4, 3}, 3.3, 2),
                   triangle({30, 0, 0}, {35, 1, 0}, {31, 2, 6.5})});
}

fs::path written(const TempFolder& folder, const std::string& name, const SliceResult& result,
                 const ArchiveInfo& info = {}) {
    require_ok(write_archive(result, info, folder / name));
    return folder / name;
}

/// The archive of a file: what was read writes the same bytes, and what follows from the columns is as in `result`.
Archive read_back(const TempFolder& folder, const fs::path& path, const SliceResult& result) {
    Archive again = value_of(read_archive(path));
    CHECK(bytes_of(written(folder, "again.h5", again.result, again.info)) == bytes_of(path));
    CHECK(again.result.hash() == result.hash());
    CHECK(again.result.info.options == result.info.options);
    CHECK(again.result.info.layer_of == result.info.layer_of);
    for (const auto count :
         {&SliceInfo::layers, &SliceInfo::contours, &SliceInfo::points, &SliceInfo::stitches, &SliceInfo::segments,
          &SliceInfo::holes, &SliceInfo::open_contours, &SliceInfo::emptied_layers, &SliceInfo::triangles}) {
        CHECK(again.result.info.*count == result.info.*count);
    }
    return again;
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
std::vector<fs::path> write_parts(const TempFolder& folder, SliceOptions options, const std::vector<std::uint64_t>& ends,
                                  const ArchiveInfo& info = {}) {
    std::vector<fs::path> paths;
    std::uint64_t first = 0;
    for (const std::uint64_t end : ends) {
        options.planes.first_layer = std::exchange(first, end);
        options.planes.end_layer = end;
        paths.push_back(written(folder, "to" + std::to_string(end) + ".h5", sliced(specimen(), options), info));
    }
    return paths;
}

/// Another value than the default.
template <class Option>
void change(Option& value) {
    if constexpr (std::is_enum_v<Option>) {
        value = static_cast<Option>(1);
    } else if constexpr (std::is_same_v<Option, Transform>) {
        value = Transform::scale(2);
    } else if constexpr (std::is_same_v<Option, std::optional<std::vector<double>>>) {
        value = {7, 3};
    } else if constexpr (std::is_same_v<Option, std::vector<Slab>>) {
        value = {{6, 8}, {1, 3.5}};
    } else if constexpr (std::is_same_v<Option, std::vector<FillFrom>>) {
        value = {{4, FillRule::positive}, {5, FillRule::even_odd}};
    } else if constexpr (std::is_same_v<Option, std::uint64_t>) {
        value = 0;  // the range of layers, which the root and the rows say
    } else if constexpr (std::is_same_v<Option, bool>) {
        value = !value;
    } else {
        value = 1.25;
    }
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
    (void)read_back(folder, written(folder, "a.h5", result), result);
}

TEST_CASE("an archive reads back as it was written, and parts joined in any order are the bytes of the whole") {
    CHECK(has_archives());
    const TempFolder folder;
    SliceOptions options{.layer_height_mm = 0.1, .stitch_mm = 50, .origins = true};
    SECTION("uniform") {}
    SECTION("given heights, twice one, and outside") {
        options.heights_mm = std::vector<double>{3, 1.5, 99, 1.5, -2, 6.25};
        for (int i = 0; i < 70; ++i) {
            options.heights_mm->push_back(7 - 0.1 * i);
        }
        options.planes.side = PlaneSide::above;
    }
    SECTION("given slabs") {
        for (int i = 0; i < 70; ++i) {
            options.slabs.push_back({7 - 0.1 * i, 7.1 - 0.1 * i});
        }
    }
    SECTION("regions") {
        options.region.fill_rule = FillRule::non_zero;
        options.region.fill_from = {{4, FillRule::even_odd}, {30, FillRule::outermost}};
        options.region.offset_mm = -0.1;
    }
    SECTION("moved") {
        options.frame.transform = Transform::from_normal(1, 2, 3);
        options.planes.first_height_mm = 0.07;
    }
    const SliceResult result = sliced(specimen(), options);
    ImageGeometry image = image_of({3, 4, 5}, {1, 2, 3}, {-1.5, 2, 7});
    image.uneven_slices_mm = {0, 1, 3, 4, 9};
    image.shear_mm = {0.5, -2};
    const ArchiveInfo info{.name = "left \xc3\xa4 lung\xff",
                           .mesh_sha256 = std::string(64, 'a'),
                           .frame = PatientFrame::ras,
                           .weld = ArchiveWeld{0.01, 7},
                           .geometry = image,
                           .subslices = 3,
                           .measures = true};
    const fs::path whole = written(folder, "whole.h5", result, info);
    const Archive again = read_back(folder, whole, result);
    CHECK(std::ranges::equal(again.result.contours, result.contours, {}, &Contour::twice_area, &Contour::twice_area));
    CHECK(std::ranges::equal(again.result.origins, result.origins));
    CHECK(again.info.name == info.name);
    CHECK(again.info.frame == PatientFrame::ras);
    CHECK(again.info.weld.value().joined == 7);
    CHECK(again.info.geometry.value().axes == image.axes);
    CHECK(again.info.geometry->uneven_slices_mm == image.uneven_slices_mm);
    CHECK(again.info.geometry->shear_mm == image.shear_mm);
    CHECK(again.info.subslices == 3);
    CHECK(again.info.measures);

    std::vector<fs::path> parts = write_parts(folder, options, {1, 2, 25, 60, 1000}, info);
    for (int round = 0; round < 3; ++round) {
        const MergedArchive merged = value_of(merge_archives(parts, folder / "m.h5"));
        CHECK(merged.hash == result.hash());
        CHECK(merged.info.name == info.name);
        CHECK(bytes_of(folder / "m.h5") == bytes_of(whole));
        std::rotate(parts.begin(), parts.begin() + 2, parts.end());
    }
    CHECK(merge_archives(std::vector{whole}, folder / "m.h5").ok());
    CHECK(bytes_of(folder / "m.h5") == bytes_of(whole));
}

TEST_CASE("equal results are equal archives, of any size") {
    const TempFolder folder;
    // More rows than a block holds.
    const Soup soup = octasphere({0, 0, 0}, 30, 5);
    const SliceResult result = sliced(soup, uniform(0.02));
    REQUIRE(result.points.size() > (std::size_t{1} << 18));
    const fs::path one = written(folder, "a.h5", result);
    CHECK(bytes_of(written(folder, "b.h5", sliced(shuffled(soup, 3), uniform(0.02)))) == bytes_of(one));
    (void)read_back(folder, one, result);
    for (const SliceOptions& options : {at_heights({50, 60}), uniform(100)}) {
        const SliceResult none = sliced(specimen(), options);  // no layers, no contours
        (void)read_back(folder, written(folder, "a.h5", none), none);
    }
    CHECK(folder.names() == std::vector<std::string>{"a.h5", "again.h5", "b.h5"});
}

TEST_CASE("no flipped byte of an archive goes unnoticed, and none that is cut off is read") {
    const TempFolder folder;
    const Soup hollow = joined({box({0, 0, 0}, {9, 8, 7}), flipped(box({2, 2, 1}, {4, 5, 6}))});
    const SliceResult result = sliced(hollow, {.layer_height_mm = 2, .origins = true});
    const ArchiveInfo info{.name = "box", .geometry = image_of({1, 1, 1}, {1, 1, 1}, {0, 0, 0})};
    const std::string bytes = bytes_of(written(folder, "a.h5", result, info));
    for (std::size_t i = 0; i < bytes.size(); i += i < 1024 || i + 64 > bytes.size() ? 1U : 3U) {
        std::string damaged = bytes;
        damaged[i] = static_cast<char>(damaged[i] ^ (1 << (i % 8)));
        CHECK_THAT(complaint_of(folder.write("d.h5", damaged)), Contains("d.h5: "));
        if (i % 37 == 0 || i < 1024 || i + 64 > bytes.size()) {
            CHECK(!read_archive(folder.write("d.h5", bytes.substr(0, i))).ok());
        }
    }
}

TEST_CASE("what is no archive is refused by name") {
    const TempFolder folder;
    const std::string bytes = bytes_of(written(folder, "a.h5", sliced(specimen(), uniform(2))));
    const std::string other = bytes_of(written(folder, "b.h5", sliced(specimen(), uniform(1))));
    const auto last_line = [](const std::string& all) { return all.rfind('\n', all.size() - 2); };
    CHECK(bytes.substr(last_line(bytes)).starts_with("\nlamella archive 3, CRC-32 of all before: "));
    std::string older = bytes;
    older[last_line(bytes) + std::string_view("\nlamella archive ").size()] = '2';
    const std::vector<std::pair<std::string, const char*>> refused = {
        {"", "no HDF5 file"},
        {"solid of some words", "no HDF5 file"},
        {bytes.substr(0, 5), "no HDF5 file"},
        {bytes.substr(0, bytes.size() / 2), "cut off"},
        {older, "an archive of form 2, not 3"},
        {bytes + "x", "last line"},
        {bytes.substr(0, last_line(bytes)) + other.substr(last_line(other)), "damaged"},
    };
    for (const auto& [content, complaint] : refused) {
        CHECK_THAT(complaint_of(folder.write("d.h5", content)), Contains(complaint));
    }
    CHECK_THAT(complaint_of(folder / "none.h5"), Contains("cannot be opened"));
    CHECK_THAT(complaint_of(folder.path()), Contains("is a directory"));
}

TEST_CASE("an archive that cannot be written leaves nothing") {
    const TempFolder folder;
    const SliceResult result = sliced(specimen(), uniform(2));
    CHECK(error_of(write_archive(result, {.name = std::string(5000, 'n')}, folder / "a.h5")).code ==
          ErrorCode::invalid_argument);
    if (fs::exists("/dev/full")) {
        CHECK(error_of(write_archive(result, {}, "/dev/full")).message ==
              "cannot write '/dev/full': No space left on device");
    }
    CHECK(folder.names().empty());
    written(folder, "a.h5", result);
    CHECK(error_of(merge_archives(std::vector{folder / "a.h5"}, folder / "b.h5", {.stop = always})).code ==
          ErrorCode::cancelled);
    CHECK(folder.names() == std::vector<std::string>{"a.h5"});
}

TEST_CASE("parts that do not make a whole are refused by their names") {
    const TempFolder folder;
    const std::vector<fs::path> parts = write_parts(folder, uniform(0.5), {4, 8, 1000});
    const fs::path to = folder / "m.h5";
    for (const auto& [some, complaint] : std::vector<std::pair<std::vector<fs::path>, const char*>>{
             {{}, "no archives to join"},
             {{parts[0], parts[2]}, "layers 4 to 7 lie in neither"},
             {{parts[1], parts[2]}, "layers 0 to 3 are missing before"},
             {{parts[0], parts[1]}, "are missing after"},
             {{parts[0], parts[1], parts[1], parts[2]}, "both hold layers 4 to 7"}}) {
        CHECK_THAT(merge_complaint(some, to), Contains(complaint));
    }
    const auto check_difference = [&](const char* place, const Soup& soup, SliceOptions options,
                                      const ArchiveInfo& info = {}) {
        options.planes.first_layer = 4;
        options.planes.end_layer = 8;
        const fs::path other = written(folder, "o.h5", sliced(soup, options), info);
        CHECK_THAT(merge_complaint({parts[0], other, parts[2]}, to), Contains(std::string("they differ in ") + place));
    };
    check_difference("/options/layer_height_mm", specimen(), uniform(0.51));
    check_difference("/options/origins", specimen(), {.layer_height_mm = 0.5, .origins = true});
    check_difference("/grid_mm", specimen(), uniform(0.5, default_grid_mm * 2));
    check_difference("/mesh/min_mm", moved(specimen(), {1, 0, 0}), uniform(0.5));
    check_difference("/measures", specimen(), uniform(0.5), {.measures = true});
    check_difference("/mesh/sha256", specimen(), uniform(0.5), {.mesh_sha256 = "1"});
    SliceOptions listed = uniform(0.5);
    std::vector<fs::path> with_heights;
    for (const double last : {3.0, 4.0, 4.0}) {
        listed.heights_mm = std::vector<double>{1, 2, last};
        listed.planes.first_layer = with_heights.size();
        listed.planes.end_layer = with_heights.size() + 1;
        with_heights.push_back(written(folder, "h" + std::to_string(with_heights.size()), sliced(specimen(), listed)));
    }
    CHECK_THAT(merge_complaint(with_heights, to), Contains("they differ in the columns of /options"));
}
