// The faults that check() found, as a PLY file to be shown over the mesh.
#include <array>
#include <cstdint>
#include <string>

#include "base/guard.hpp"
#include "io/write/describe.hpp"
#include "io/write/output_file.hpp"
#include "lamella/io/check_report.hpp"

namespace lamella {

namespace {

struct Colour {
    int red;
    int green;
    int blue;
};

/// By fault: reds for boundaries, blues for edges and vertices, greens for faces and shells, yellows for meetings, violets
/// for gaps.
constexpr std::array<Colour, fault_count> colours = {{
    {255, 0, 0},     {160, 0, 0},   {0, 160, 255}, {0, 0, 255},    {0, 0, 140},    {0, 255, 255},   {0, 128, 0},
    {128, 255, 128}, {0, 255, 0},   {0, 200, 80},  {120, 120, 0},  {150, 150, 60}, {160, 160, 160}, {110, 110, 110},
    {0, 90, 60},     {255, 160, 0}, {255, 220, 0}, {200, 170, 90}, {255, 0, 255},  {150, 0, 200},
}};

/// Edges between the points of a place: none, one, or a triangle's three.
int edge_count(const FaultPlace& place) {
    return place.point_count == 3 ? 3 : place.point_count - 1;
}

std::string text(const Colour& colour) {
    return std::to_string(colour.red) + " " + std::to_string(colour.green) + " " + std::to_string(colour.blue);
}

template <class Visit>
void each_place(const MeshCheck& check, Visit visit) {
    for (std::size_t fault = 0; fault < fault_count; ++fault) {
        for (const FaultPlace& place : check.findings[fault].places) {
            visit(place, colours[fault]);
        }
    }
}

std::string header(const MeshCheck& check) {
    std::int64_t points = 0;
    std::int64_t edges = 0;
    each_place(check, [&](const FaultPlace& place, const Colour&) {
        points += place.point_count;
        edges += edge_count(place);
    });
    std::string head = "ply\nformat ascii 1.0\ncomment unit mm\n";
    for (std::size_t fault = 0; fault < fault_count; ++fault) {
        head += "comment " + std::string(key_of(static_cast<Fault>(fault))) + " " + text(colours[fault]) + "\n";
    }
    return head + "element vertex " + std::to_string(points) +
           "\nproperty double x\nproperty double y\nproperty double z\n"
           "property uchar red\nproperty uchar green\nproperty uchar blue\n"
           "element edge " +
           std::to_string(edges) +
           "\nproperty int vertex1\nproperty int vertex2\n"
           "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n";
}

void write_points(const MeshCheck& check, OutputFile& file) {
    each_place(check, [&](const FaultPlace& place, const Colour& colour) {
        for (std::size_t i = 0; i < static_cast<std::size_t>(place.point_count); ++i) {
            for (const double mm : place.points_mm[i]) {
                file.append(exact_text(mm) + " ");
            }
            file.append(text(colour) + "\n");
        }
    });
}

void write_edges(const MeshCheck& check, OutputFile& file) {
    std::int64_t first = 0;
    each_place(check, [&](const FaultPlace& place, const Colour& colour) {
        for (int i = 0; i < edge_count(place); ++i) {
            file.append(std::to_string(first + i) + " " + std::to_string(first + (i + 1) % place.point_count) + " " +
                        text(colour) + "\n");
        }
        first += place.point_count;
    });
}

}  // namespace

Status write_marks(const MeshCheck& check, const std::filesystem::path& path) noexcept {
    return guarded([&]() -> Status {
        Result<OutputFile> file = OutputFile::create(path);
        if (!file) {
            return file.error();
        }
        file->append(header(check));
        write_points(check, file.value());
        write_edges(check, file.value());
        return file->commit();
    });
}

}  // namespace lamella
