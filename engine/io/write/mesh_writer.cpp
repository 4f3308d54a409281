#include "lamella/io/mesh_writer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>

#include "base/guard.hpp"
#include "base/little_endian.hpp"
#include "base/parallel.hpp"
#include "io/read/input_file.hpp"
#include "io/write/output_file.hpp"

namespace lamella {

namespace {

constexpr std::size_t stl_header_bytes = 80;
constexpr std::size_t stl_facet_bytes = 50;
constexpr std::size_t ply_face_bytes = 13;

/// As 3D Slicer states it, which the readers understand.
std::string frame_words(const MeshFile& mesh) {
    return mesh.patient_frame == PatientFrame::unstated ? "" : "SPACE=" + std::string(name_of(mesh.patient_frame));
}

class MeshWriter {
public:
    MeshWriter(const MeshFile& mesh, OutputFile& file, const StopCheck& stop)
        : mesh_(mesh), view_(mesh.view()), file_(file), stop_(stop), is_soup_(view_.indices == nullptr) {}

    /// Returns what is wrong, or nothing.
    std::string write_stl() {
        if (mesh_.triangle_count > std::numeric_limits<std::uint32_t>::max()) {
            return "STL counts triangles in 32 bits, of which there are more";
        }
        std::array<char, stl_header_bytes> header{};
        const std::string words = "lamella " + frame_words(mesh_);
        std::copy(words.begin(), words.end(), header.begin());
        append(header.data(), header.size());
        const auto count = static_cast<std::uint32_t>(mesh_.triangle_count);
        append(&count, sizeof count);
        each(mesh_.triangle_count, [&](std::size_t t) {
            std::array<char, stl_facet_bytes> facet{};
            for (std::size_t corner = 0; corner < 3; ++corner) {
                const std::array<float, 3> xyz = floats_at(vertex_at(corner_of(t, corner)));
                std::memcpy(facet.data() + (1 + corner) * sizeof xyz, xyz.data(), sizeof xyz);
            }
            append(facet.data(), facet.size());
        });
        return beyond_ ? "a coordinate is too large for the floats of STL; PLY takes it" : "";
    }

    std::string write_ply() {
        if (vertices() > std::uint64_t{std::numeric_limits<std::int32_t>::max()}) {
            return "PLY counts vertices in 31 bits, of which there are more";
        }
        file_.append(ply_header());
        each(vertices(), [&](std::size_t vertex) { append(vertex_at(vertex), vertex_bytes()); });
        each(mesh_.triangle_count, [&](std::size_t t) {
            std::array<char, ply_face_bytes> face{3};
            for (std::size_t corner = 0; corner < 3; ++corner) {
                const auto vertex = static_cast<std::uint32_t>(corner_of(t, corner));
                std::memcpy(face.data() + 1 + corner * sizeof vertex, &vertex, sizeof vertex);
            }
            append(face.data(), face.size());
        });
        return "";
    }

    bool rounded() const noexcept { return rounded_; }

private:
    bool is_double() const noexcept { return view_.vertex_type == Number::f64; }
    std::size_t vertex_bytes() const noexcept { return 3 * size_of(view_.vertex_type); }
    std::uint64_t vertices() const noexcept { return is_soup_ ? 3 * mesh_.triangle_count : mesh_.vertex_count; }
    const std::byte* vertex_at(std::uint64_t vertex) const noexcept {
        return is_soup_ ? view_.vertex_at(vertex / 3) + vertex % 3 * vertex_bytes() : view_.vertex_at(vertex);
    }
    std::uint64_t corner_of(std::size_t triangle, std::size_t corner) const noexcept {
        return is_soup_ ? 3 * std::uint64_t{triangle} + corner : view_.vertex_of(triangle, corner);
    }

    std::string ply_header() const {
        const std::string words = frame_words(mesh_);
        const std::string number = is_double() ? "double " : "float ";
        return "ply\nformat binary_little_endian 1.0\n" + (words.empty() ? "" : "comment " + words + "\n") +
               "element vertex " + std::to_string(vertices()) + "\nproperty " + number + "x\nproperty " + number +
               "y\nproperty " + number + "z\nelement face " + std::to_string(mesh_.triangle_count) +
               "\nproperty list uchar int vertex_indices\nend_header\n";
    }

    std::array<float, 3> floats_at(const std::byte* at) noexcept {
        std::array<float, 3> xyz{};
        if (!is_double()) {
            std::memcpy(xyz.data(), at, sizeof xyz);
            return xyz;
        }
        std::array<double, 3> from{};
        std::memcpy(from.data(), at, sizeof from);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (std::abs(from[axis]) > static_cast<double>(std::numeric_limits<float>::max())) {
                beyond_ = true;
                return {};
            }
            xyz[axis] = static_cast<float>(from[axis]);
            rounded_ = rounded_ || static_cast<double>(xyz[axis]) != from[axis];
        }
        return xyz;
    }

    template <class Write>
    void each(std::uint64_t count, Write write) {
        constexpr std::uint64_t between_stops = 1 << 14;
        for (std::uint64_t i = 0; i < count && !file_.failed(); ++i) {
            if (i % between_stops == 0) {
                stop_.stop_if_asked();
            }
            write(i);
        }
    }
    void append(const void* from, std::size_t bytes) { file_.append({static_cast<const char*>(from), bytes}); }

    const MeshFile& mesh_;
    const MeshView view_;
    OutputFile& file_;
    PacedStop stop_;
    bool is_soup_;
    bool rounded_ = false;
    bool beyond_ = false;
};

Result<WrittenMesh> write_guarded(const MeshFile& mesh, const std::filesystem::path& path, const Context& context) {
    if (!is_written_as_mesh(path)) {
        return Error{ErrorCode::invalid_argument, "'" + path_text(path) + "' ends neither in .stl nor in .ply"};
    }
    if (mesh.vertex_type != Number::f32 && mesh.vertex_type != Number::f64) {
        return Error{ErrorCode::invalid_argument, "only meshes of floats or doubles are written"};
    }
    OutputFile file = require(OutputFile::create(path));
    MeshWriter writer(mesh, file, context.stop);
    if (const std::string why = has_extension(path.native(), ".stl") ? writer.write_stl() : writer.write_ply();
        !why.empty()) {
        return Error{ErrorCode::invalid_argument, "cannot write '" + path_text(path) + "': " + why};
    }
    require(file.commit());
    return WrittenMesh{writer.rounded()};
}

}  // namespace

bool is_written_as_mesh(const std::filesystem::path& path) noexcept {
    return has_extension(path.native(), ".stl") || has_extension(path.native(), ".ply");
}

Result<WrittenMesh> write_mesh(const MeshFile& mesh, const std::filesystem::path& path, const Context& context) noexcept {
    return guarded(context, [&] { return write_guarded(mesh, path, context); });
}

}  // namespace lamella
