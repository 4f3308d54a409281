// A stop that comes while a file is read ends the reading soon, in every format and on every way through its reader.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "cpu_time.hpp"
#include "files.hpp"
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

/// A sheet of side * side quads, each of two triangles.
constexpr std::uint32_t vertices = (side + 1) * (side + 1);
constexpr std::uint32_t quads = side * side;

std::array<float, 3> vertex(std::uint32_t i) {
    const std::uint32_t x = i % (side + 1);
    const std::uint32_t y = i / (side + 1);
    return {0.1F * static_cast<float>(x), 0.1F * static_cast<float>(y), 0.01F * static_cast<float>((x * y) % 7)};
}

std::array<std::uint32_t, 4> quad(std::uint32_t i) {
    const std::uint32_t first = i / side * (side + 1) + i % side;
    return {first, first + 1, first + side + 2, first + side + 1};
}

std::array<std::uint32_t, 3> triangle(std::uint32_t i) {
    const auto [a, b, c, d] = quad(i / 2);
    return i % 2 == 0 ? std::array{a, b, c} : std::array{a, c, d};
}

std::vector<Facet> facets() {
    std::vector<Facet> all;
    for (std::uint32_t t = 0; t < 2 * quads; ++t) {
        Facet& facet = all.emplace_back();
        for (std::size_t i = 0; i < 9; ++i) {
            facet[i] = vertex(triangle(t)[i / 3])[i % 3];
        }
    }
    return all;
}

/// "BEFORE x BETWEEN y BETWEEN z AFTER" for each vertex.
std::string vertex_text(const std::string& before, const std::string& between, const std::string& after) {
    std::string text;
    for (std::uint32_t v = 0; v < vertices; ++v) {
        const auto [x, y, z] = vertex(v);
        text += before + std::to_string(x) + between + std::to_string(y) + between + std::to_string(z) + after;
    }
    return text;
}

std::string triangle_text(const std::string& before, const std::string& after, std::uint32_t first_vertex = 0) {
    std::string text;
    for (std::uint32_t t = 0; t < 2 * quads; ++t) {
        const auto [a, b, c] = triangle(t);
        text += before + std::to_string(a + first_vertex) + " " + std::to_string(b + first_vertex) + " " +
                std::to_string(c + first_vertex) + after;
    }
    return text;
}

std::string quad_text(const std::string& before, std::uint32_t first_vertex = 0) {
    std::string text;
    for (std::uint32_t q = 0; q < quads; ++q) {
        text += before;
        for (const std::uint32_t corner : quad(q)) {
            text += " " + std::to_string(corner + first_vertex);
        }
        text += "\n";
    }
    return text;
}

std::string without(const std::string& text, const std::string& what) {
    std::string left;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = std::min(text.find(what, at), text.size());
        left.append(text, at, end - at);
        at = end + what.size();
    }
    return left;
}

std::string repeated(const std::string& text, std::size_t count) {
    std::string all;
    for (std::size_t i = 0; i < count; ++i) {
        all += text;
    }
    return all;
}

std::string off_counts() {
    return std::to_string(vertices) + " " + std::to_string(2 * quads) + " 0\n";
}

std::string ply_header(const std::string& encoding, std::uint32_t faces) {
    return "ply\nformat " + encoding + " 1.0\nelement vertex " + std::to_string(vertices) +
           "\nproperty float x\nproperty float y\nproperty float z\nelement face " + std::to_string(faces) +
           "\nproperty list uchar int vertex_indices\nend_header\n";
}

std::string binary_ply_of_quads() {
    std::string bytes = ply_header("binary_little_endian", quads);
    const auto put = [&bytes](auto value) {
        std::array<char, sizeof value> raw;
        std::memcpy(raw.data(), &value, sizeof value);
        bytes.append(raw.data(), raw.size());
    };
    for (std::uint32_t v = 0; v < vertices; ++v) {
        for (const float coordinate : vertex(v)) {
            put(coordinate);
        }
    }
    for (std::uint32_t q = 0; q < quads; ++q) {
        put(std::uint8_t{4});
        for (const std::uint32_t corner : quad(q)) {
            put(corner);
        }
    }
    return bytes;
}

std::string vtk_text() {
    return "# vtk DataFile Version 3.0\nsheet\nASCII\nDATASET POLYDATA\nPOINTS " + std::to_string(vertices) + " float\n" +
           vertex_text("", " ", "\n") + "POLYGONS " + std::to_string(quads) + " " + std::to_string(5 * quads) + "\n" +
           quad_text("4");
}

std::string vtp_text() {
    std::string ends;
    for (std::uint32_t q = 1; q <= quads; ++q) {
        ends += std::to_string(4 * q) + " ";
    }
    return "<VTKFile type=\"PolyData\"><PolyData><Piece NumberOfPoints=\"" + std::to_string(vertices) +
           "\" NumberOfPolys=\"" + std::to_string(quads) +
           "\"><Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">" + vertex_text("", " ", "\n") +
           "</DataArray></Points><Polys><DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">" + quad_text("") +
           "</DataArray><DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">" + ends +
           "</DataArray></Polys></Piece></PolyData></VTKFile>";
}

/// The build holds the sheet so many times. Stored, as deflating it takes seconds.
std::string three_mf(int items) {
    std::string mesh = "<mesh><vertices>";
    for (std::uint32_t v = 0; v < vertices; ++v) {
        const auto [x, y, z] = vertex(v);
        mesh +=
            "<vertex x=\"" + std::to_string(x) + "\" y=\"" + std::to_string(y) + "\" z=\"" + std::to_string(z) + "\"/>\n";
    }
    mesh += "</vertices><triangles>";
    for (std::uint32_t t = 0; t < 2 * quads; ++t) {
        const auto [a, b, c] = triangle(t);
        mesh += "<triangle v1=\"" + std::to_string(a) + "\" v2=\"" + std::to_string(b) + "\" v3=\"" + std::to_string(c) +
                "\"/>\n";
    }
    std::string build;
    for (int i = 0; i < items; ++i) {
        build += item(1, "transform=\"1 0 0 0 1 0 0 0 1 0 0 " + std::to_string(i) + "\"");
    }
    const std::string model = model_text(object(1, mesh + "</triangles></mesh>"), build);
    return zip({content_types(), relationships(), {"3D/3dmodel.model", model, false}});
}

struct File {
    const char* name;
    std::function<std::string()> bytes;
};

/// Each format, and each way that a reader takes through one.
const std::vector<File> files = {
    {"binary.stl", [] { return binary_stl(facets()); }},
    {"text.stl", [] { return ascii_stl(facets()); }},
    {"sloppy.stl", [] { return without(ascii_stl(facets()), "    outer loop\n"); }},
    {"name.stl", [] { return ascii_stl(numbered_facets(1)) + "solid" + repeated(" of a long name", 4 * quads) + "\n"; }},
    {"comments.stl", [] { return ascii_stl(numbered_facets(1)) + repeated("a comment\n", 4 * quads); }},
    {"triangles.obj", [] { return vertex_text("v ", " ", "\n") + triangle_text("f ", "\n", 1); }},
    {"quads.obj", [] { return vertex_text("v ", " ", "\n") + quad_text("f", 1); }},
    {"lines.off", [] { return "OFF\n" + off_counts() + vertex_text("", " ", "\n") + triangle_text("3 ", "\n"); }},
    {"words.off", [] { return "OFF\n" + off_counts() + vertex_text("", " ", " ") + triangle_text("3 ", " "); }},
    {"lines.ply", [] { return ply_header("ascii", 2 * quads) + vertex_text("", " ", "\n") + triangle_text("3 ", "\n"); }},
    {"words.ply", [] { return ply_header("ascii", 2 * quads) + vertex_text("", "\n", "\n") + triangle_text("3\n", "\n"); }},
    {"quads.ply", binary_ply_of_quads},
    {"text.vtk", vtk_text},
    {"text.vtp", vtp_text},
    {"one.3mf", [] { return three_mf(1); }},
    {"many.3mf", [] { return three_mf(20); }},
    {"quads.obj.gz", [] { return deflated(vertex_text("v ", " ", "\n") + quad_text("f", 1), 16 + MAX_WBITS); }},
};

Result<MeshFile> read_with(const std::filesystem::path& path, int threads, const StopCheck& stop = {}) {
    return read_mesh(path, {.memory_limit_bytes = std::uint64_t{2} << 30, .control = {.threads = threads, .stop = stop}});
}

/// Says yes from a moment on.
class StopAt {
public:
    explicit StopAt(double ms) : at_(cpu_ms() + ms) {}

    StopCheck check() {
        return {[](void* context) noexcept { return static_cast<StopAt*>(context)->ms_late() >= 0; }, this};
    }
    double ms_late() const { return cpu_ms() - at_; }

private:
    double at_;
};

/// Notes the longest time in which it is not asked.
class Interval {
public:
    StopCheck check() {
        return {[](void* context) noexcept {
                    static_cast<Interval*>(context)->end();
                    return false;
                },
                this};
    }
    void end() {
        longest_ms_ = std::max(longest_ms_, cpu_ms() - last_);
        last_ = cpu_ms();
    }
    double longest_ms() const { return longest_ms_; }

private:
    double last_ = cpu_ms();
    double longest_ms_ = 0;
};

double ms_to_read(const std::filesystem::path& path, int threads, const StopCheck& stop = {}) {
    const double start = cpu_ms();
    const Result<MeshFile> mesh = read_with(path, threads, stop);
    INFO((mesh ? "" : mesh.error().message));
    REQUIRE(mesh.ok());
    return cpu_ms() - start;
}

/// All but the slowest of some reads must keep the bound.
void check_stops(const std::filesystem::path& path, int threads, std::mt19937& random) {
    const double whole = ms_to_read(path, threads);
    std::vector<double> late;
    for (int round = 0; round < 3; ++round) {
        StopAt stop(std::uniform_real_distribution<double>(0, whole)(random));
        const Result<MeshFile> mesh = read_with(path, threads, stop.check());
        if (!mesh.ok()) {
            CHECK(mesh.error().code == ErrorCode::cancelled);
            late.push_back(stop.ms_late());
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
        Interval interval;
        whole = std::min(whole, ms_to_read(path, 1, interval.check()));
        interval.end();
        longest = std::min(longest, interval.longest_ms());
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
