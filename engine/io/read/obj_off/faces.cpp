#include "io/read/obj_off/faces.hpp"

#include <algorithm>
#include <functional>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "io/read/polygon.hpp"

namespace lamella {

namespace {

constexpr std::size_t vertex_bytes = 3 * sizeof(double);

/// Makes triangles of the faces that FaceWriter stored; one for each thread.
class FaceCutter {
public:
    /// The number of the first face that the triangulator refuses, counted from `indices`, if there is any.
    std::optional<std::size_t> cut(std::span<std::uint32_t> indices, const VertexCoordinates& vertices) {
        std::size_t face = 0;
        for (std::size_t at = 0; at < indices.size(); ++face) {
            if (indices[at] != polygon_mark) {
                at += 3;
                continue;
            }
            const std::span<const std::uint32_t> held = indices.subspan(at + 2, indices[at + 1]);
            corners_.assign(held.begin(), held.end());
            if (triangulator_.triangulate(corners_, vertices, &indices[at]) == 0) {
                return face;
            }
            at += 3 * triangles_in(corners_.size());
        }
        return std::nullopt;
    }

    static constexpr std::size_t scratch_bytes(std::size_t corners) noexcept {
        return PolygonTriangulator::scratch_bytes(corners) + 2 * corners * sizeof(std::uint32_t);
    }

private:
    PolygonTriangulator triangulator_;
    std::vector<std::uint32_t> corners_;
};

/// Of coordinates, indices and the cutters' scratch memory, which grows to that of the largest face that each one meets.
std::size_t bytes_needed(std::size_t vertices, std::size_t triangles, std::span<const FaceRange> pieces, int threads) {
    std::vector<std::size_t> scratch;
    for (const FaceRange& piece : pieces) {
        scratch.push_back(FaceCutter::scratch_bytes(piece.most_corners));
    }
    const auto largest = scratch.begin() + std::min<std::ptrdiff_t>(threads, std::ssize(scratch));
    std::partial_sort(scratch.begin(), largest, scratch.end(), std::greater());
    return std::accumulate(scratch.begin(), largest, vertices * vertex_bytes + triangles * 3 * sizeof(std::uint32_t));
}

std::size_t place_triangles(std::span<FaceRange> pieces) {
    std::size_t triangles = 0;
    for (FaceRange& piece : pieces) {
        piece.first_triangle = std::exchange(triangles, triangles + piece.triangles);
    }
    return triangles;
}

TextFailure cut_faces(std::span<const FaceRange> pieces, MeshFile& mesh, const Parallel& parallel,
                      FunctionRef<const char*(std::size_t piece, std::size_t face)> place) {
    const VertexCoordinates vertices{mesh.bytes.data(), mesh.stride, mesh.coordinate_type};
    std::vector<FaceCutter> cutters(static_cast<std::size_t>(parallel.threads()));
    return parse_pieces<TextFailure>(pieces.size(), parallel, [&](std::size_t i, int worker) {
        const std::span<std::uint32_t> own =
            mesh.indices.span().subspan(3 * pieces[i].first_triangle, 3 * pieces[i].triangles);
        const std::optional<std::size_t> refused = cutters[static_cast<std::size_t>(worker)].cut(own, vertices);
        return refused ? TextFailure{place(i, *refused), "this face is too entangled to be cut into triangles"}
                       : TextFailure();
    });
}

}  // namespace

Result<MeshFile> read_faces(const FileSource& source, std::string_view text, std::size_t vertices,
                            std::span<FaceRange> pieces,
                            FunctionRef<TextFailure(std::size_t piece, std::byte* coordinates, FaceWriter& faces)> parse,
                            FunctionRef<const char*(std::size_t piece, std::size_t face)> place) {
    const Parallel& parallel = source.parallel();
    if (vertices >= polygon_mark) {
        return source.error(ErrorCode::malformed_mesh,
                            "has " + std::to_string(vertices) + " vertices, too many to be numbered");
    }
    const std::size_t triangles = place_triangles(pieces);
    const std::size_t needed = bytes_needed(vertices, triangles, pieces, parallel.threads());
    if (needed > source.memory_limit()) {
        return source.error(ErrorCode::out_of_memory, "expands to " + std::to_string(needed) + " bytes, more than the " +
                                                          std::to_string(source.memory_limit()) +
                                                          " that reading it may take");
    }
    MeshFile mesh;
    mesh.text = true;
    mesh.coordinate_type = CoordinateType::f64;
    mesh.stride = vertex_bytes;
    mesh.vertex_count = vertices;
    mesh.triangle_count = triangles;
    mesh.bytes = Array<std::byte>(source.memory());
    mesh.bytes.resize_discarding(vertices * vertex_bytes);
    mesh.indices = Array<std::uint32_t>(source.memory());
    mesh.indices.resize_discarding(3 * triangles);

    TextFailure failure = parse_pieces<TextFailure>(pieces.size(), parallel, [&](std::size_t i, int) {
        FaceWriter faces(mesh.indices.data() + 3 * pieces[i].first_triangle);
        return parse(i, mesh.bytes.data(), faces);
    });
    if (failure.at == nullptr) {
        failure = cut_faces(pieces, mesh, parallel, place);
    }
    if (failure.at != nullptr) {
        return source.error_in_text(text, failure);
    }
    LeftOut small;
    for (const FaceRange& piece : pieces) {
        small.add(piece.small);
    }
    if (triangles == 0) {
        return source.error(ErrorCode::empty_mesh,
                            small.count == 0 ? "holds no faces" : "holds no face of three corners or more");
    }
    if (small.count > 0) {
        mesh.warnings.push_back(source.name() + ": left out " + std::to_string(small.count) +
                                " faces of fewer than three corners" + first_line_words(small, text));
    }
    return mesh;
}

}  // namespace lamella
