// A stop that comes while a file is read ends the reading soon, in every format and on every way through its reader.
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "cpu_time.hpp"
#include "engine/slicing.hpp"
#include "golden/mesh_files.hpp"
#include "lamella/io.hpp"
#include "zip.hpp"

namespace lamella {
namespace {

using namespace input_test;

#ifdef LAMELLA_TESTS_SANITIZED
constexpr std::uint32_t side = 80;
constexpr double most_ms_late = 2000;
constexpr double always_short_ms = 200;
#else
constexpr std::uint32_t side = 390;  // 304,200 triangles
constexpr double most_ms_late = 100;
constexpr double always_short_ms = 10;  // of a piece of text, and of a row of pages
#endif

/// A sheet of side * side quads, or twice as many triangles.
golden::Polygons sheet(bool quads) {
    golden::Polygons mesh;
    for (std::uint32_t y = 0; y <= side; ++y) {
        for (std::uint32_t x = 0; x <= side; ++x) {
            mesh.xyz.insert(mesh.xyz.end(), {double(x), double(y), (x * y) % 7 / 64.0});
        }
    }
    for (std::uint32_t i = 0; i < side * side; ++i) {
        const std::uint32_t first = i / side * (side + 1) + i % side;
        const std::uint32_t above = first + side + 1;
        if (quads) {
            mesh.faces.push_back({first, first + 1, above + 1, above});
        } else {
            mesh.faces.push_back({first, first + 1, above + 1});
            mesh.faces.push_back({first, above + 1, above});
        }
    }
    return mesh;
}

shapes::Indexed indexed_sheet() {
    const golden::Polygons mesh = sheet(false);
    shapes::Indexed indexed{mesh.xyz, {}};
    for (const auto& face : mesh.faces) {
        indexed.indices.insert(indexed.indices.end(), face.begin(), face.end());
    }
    return indexed;
}

shapes::Soup soup() {
    const golden::Polygons mesh = sheet(false);
    shapes::Soup corners;
    for (const auto& face : mesh.faces) {
        for (const std::uint32_t index : face) {
            corners.insert(corners.end(), mesh.xyz.begin() + 3 * index, mesh.xyz.begin() + 3 * index + 3);
        }
    }
    return corners;
}

std::string repeated(const std::string& text, std::size_t count) {
    std::string all;
    for (std::size_t i = 0; i < count; ++i) {
        all += text;
    }
    return all;
}

/// Behind the header another white space than the usual one, which another way of the reader takes.
std::string respaced(std::string text, const std::string& header_end, char usual, char other) {
    const std::size_t begin = text.find(header_end) + header_end.size();
    std::replace(text.begin() + static_cast<std::ptrdiff_t>(begin), text.end(), usual, other);
    return text;
}

/// The build holds the sheet so many times.
std::string three_mf(int items) {
    std::string build;
    for (int i = 0; i < items; ++i) {
        build += item(1, "transform=\"1 0 0 0 1 0 0 0 1 0 0 " + std::to_string(i) + "\"");
    }
    return golden::three_mf(indexed_sheet(), build);
}

struct File {
    const char* name;
    std::function<std::string()> bytes;
};

/// Each format, and each way that a reader takes through one.
const std::vector<File> files = {
    {"binary.stl", [] { return golden::binary_stl(soup()); }},
    {"text.stl", [] { return golden::text_stl(soup()); }},
    {"sloppy.stl", [] { return replaced(golden::text_stl(soup()), " outer loop\n", ""); }},
    {"name.stl",
     [] { return ascii_stl(numbered_facets(1)) + "solid" + repeated(" of a long name", 4 * side * side) + "\n"; }},
    {"comments.stl", [] { return ascii_stl(numbered_facets(1)) + repeated("a comment\n", 4 * side * side); }},
    {"triangles.obj", [] { return golden::obj(sheet(false)); }},
    {"quads.obj", [] { return golden::obj(sheet(true)); }},
    {"lines.off", [] { return golden::off(sheet(false)); }},
    {"words.off", [] { return respaced(golden::off(sheet(false)), " 0\n", '\n', ' '); }},
    {"lines.ply", [] { return golden::text_ply(sheet(false)); }},
    {"words.ply", [] { return respaced(golden::text_ply(sheet(false)), "end_header\n", ' ', '\n'); }},
    {"quads.ply", [] { return golden::little_ply(sheet(true)); }},
    {"text.vtk", [] { return golden::text_vtk(sheet(true)); }},
    {"text.vtp", [] { return golden::text_vtp(sheet(true)); }},
    {"one.3mf", [] { return three_mf(1); }},
    {"many.3mf", [] { return three_mf(20); }},
    {"quads.obj.gz", [] { return deflated(golden::obj(sheet(true)), 16 + MAX_WBITS); }},
};

Result<MeshFile> read_with(const std::filesystem::path& path, int threads, const Callback<bool()>& stop = {}) {
    return read_mesh(path, {.memory_limit_bytes = std::uint64_t{2} << 30}, {.threads = threads, .stop = stop});
}

double ms_to_read(const std::filesystem::path& path, int threads, const Callback<bool()>& stop = {}) {
    const double start = cpu_ms();
    value_of(read_with(path, threads, stop));
    return cpu_ms() - start;
}

/// All but the slowest of some reads must keep the bound.
void check_stops(const std::filesystem::path& path, int threads, std::mt19937& random) {
    const double whole = ms_to_read(path, threads);
    std::vector<double> late;
    for (int round = 0; round < 3; ++round) {
        const double end = cpu_ms() + std::uniform_real_distribution<double>(0, whole)(random);
        auto stop = [end]() noexcept { return cpu_ms() >= end; };
        const Result<MeshFile> mesh = read_with(path, threads, stop);
        if (!mesh.ok()) {
            CHECK(mesh.error().code == ErrorCode::cancelled);
            late.push_back(cpu_ms() - end);
        }
    }
    std::sort(late.begin(), late.end());
    INFO("of " << whole << " ms");
    CHECK((late.size() < 2 || late[late.size() - 2] <= threads * most_ms_late));
}

/// A file of a gigabyte takes a hundred times as long: what asks only once in each pass over this one would ask too late.
void check_intervals(const std::filesystem::path& path) {
    double longest = std::numeric_limits<double>::max();
    double whole = longest;
    for (int round = 0; round < 3; ++round) {
        double last = cpu_ms();
        double not_asked = 0;
        auto note = [&]() noexcept {
            not_asked = std::max(not_asked, cpu_ms() - last);
            last = cpu_ms();
            return false;
        };
        whole = std::min(whole, ms_to_read(path, 1, note));
        note();
        longest = std::min(longest, not_asked);
    }
    INFO("not asked for " << longest << " of " << whole << " ms");
    CHECK(longest <= std::max(always_short_ms, whole / 4));
}

TEST_CASE("a stop that comes at any moment ends the reading of a file within 100 ms", "[input][control][stops]") {
    const TempFolder dir;
    std::mt19937 random(1);
    for (const File& file : files) {
        const std::filesystem::path path = dir.write(file.name, file.bytes());
        for (const int threads : {1, 2}) {
            INFO(file.name << " on " << threads << " threads");
            check_stops(path, threads, random);
        }
        INFO(file.name);
        check_intervals(path);
    }
}

}  // namespace
}  // namespace lamella
