#include "io/read/faces.hpp"

#include <functional>
#include <numeric>

#include "io/read/number_type.hpp"

namespace lamella {

namespace {

/// Makes triangles of the faces that FaceWriter stored; one for each thread.
struct FaceCutter {
    /// The first of `indices` that cannot be cut, if there is any.
    std::optional<RefusedFace> cut(std::span<std::uint32_t> indices, const VertexCoordinates& vertices) {
        std::size_t face = 0;
        for (std::size_t at = 0; at < indices.size(); ++face) {
            if (indices[at] != polygon_mark) {
                at += 3;
                continue;
            }
            const std::span<const std::uint32_t> stored = indices.subspan(at + 2, indices[at + 1]);
            corners.assign(stored.begin(), stored.end());  // triangles are about to take their place
            const auto odd = std::find_if(corners.begin(), corners.end(),
                                          [&](std::uint32_t vertex) { return !vertices.is_finite(vertex); });
            if (odd != corners.end()) {
                return RefusedFace{face, *odd};
            }
            if (triangulator.triangulate(corners, vertices, &indices[at]) == 0) {
                return RefusedFace{face, std::nullopt};
            }
            at += 3 * triangles_in(corners.size());
        }
        return std::nullopt;
    }

    PolygonTriangulator triangulator;
    std::vector<std::uint32_t> corners;
};

/// Bytes that coordinates, indices and cutting take. The scratch memory of a thread grows to that of the largest face that
/// it meets.
std::size_t bytes_needed(std::size_t vertices, std::size_t triangles, std::span<const FaceRange> pieces, int threads) {
    std::vector<std::size_t> scratch;
    for (const FaceRange& piece : pieces) {
        scratch.push_back(cutting_bytes(piece.most_corners));
    }
    const auto largest = scratch.begin() + std::min<std::ptrdiff_t>(threads, std::ssize(scratch));
    std::partial_sort(scratch.begin(), largest, scratch.end(), std::greater());
    return std::accumulate(scratch.begin(), largest, vertices * 3 * sizeof(double) + triangles * 3 * sizeof(std::uint32_t));
}

}  // namespace

void cut_faces(std::span<const FaceRange> pieces, std::span<std::uint32_t> indices, const VertexCoordinates& vertices,
               const Parallel& parallel, FunctionRef<void(std::size_t piece, const RefusedFace& face)> refuse) {
    std::vector<FaceCutter> cutters(static_cast<std::size_t>(parallel.threads()));
    parse_pieces(pieces.size(), parallel, [&](std::size_t i, int worker) {
        const std::span<std::uint32_t> own = indices.subspan(3 * pieces[i].first_triangle, 3 * pieces[i].triangles);
        if (const std::optional<RefusedFace> refused = cutters[static_cast<std::size_t>(worker)].cut(own, vertices)) {
            refuse(i, *refused);
        }
    });
}

void allocate_vertices(std::size_t count, Number type, const Memory* memory, MeshFile& mesh) {
    mesh.vertex_type = type;
    mesh.stride = 3 * size_of(type);
    mesh.first_offset = 0;
    mesh.vertex_count = count;
    mesh.bytes = Array<std::byte>(memory);
    mesh.bytes.resize_discarding(count * mesh.stride);
}

void read_faces(const FileContents& file, std::size_t vertices, std::span<FaceRange> pieces,
                FunctionRef<void(std::size_t piece, std::byte* coordinates, FaceWriter& faces)> parse,
                FunctionRef<const char*(std::size_t piece, std::size_t face)> place, MeshFile& mesh) {
    const FileSource& source = file.source;
    const Parallel& parallel = source.parallel();
    if (vertices >= polygon_mark) {
        source.refuse(ErrorCode::malformed_mesh, "has " + std::to_string(vertices) + " vertices, too many to be numbered");
    }
    std::size_t triangles = 0;
    LeftOut small;
    for (FaceRange& piece : pieces) {
        piece.first_triangle = std::exchange(triangles, triangles + piece.triangles);
        small.add(piece.small);
    }
    source.must_fit(bytes_needed(vertices, triangles, pieces, parallel.threads()));
    allocate_vertices(vertices, Number::f64, source.memory(), mesh);
    mesh.indices = Array<std::uint32_t>(source.memory());
    mesh.indices.resize_discarding(3 * triangles);
    mesh.triangle_count = triangles;
    mesh.text = true;
    parse_pieces(pieces.size(), parallel, [&](std::size_t i, int) {
        FaceWriter faces(mesh.indices.span(), pieces[i]);
        parse(i, mesh.bytes.data(), faces);
    });
    cut_faces(pieces, mesh.indices.span(), {mesh.bytes.data(), mesh.stride, mesh.vertex_type}, parallel,
              [&](std::size_t piece, const RefusedFace& face) {
                  throw TextError{place(piece, face.number), "this face is too entangled to be cut into triangles"};
              });
    if (triangles == 0) {
        source.refuse(ErrorCode::empty_mesh, small.count == 0 ? "holds no faces" : "holds no face of three corners or more");
    }
    if (small.count > 0) {
        mesh.warnings.push_back(source.name() + ": left out " + std::to_string(small.count) +
                                " faces of fewer than three corners" + first_line_words(small, file.whole));
    }
}

}  // namespace lamella
