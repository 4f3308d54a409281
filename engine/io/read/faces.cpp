#include "io/read/faces.hpp"

#include <functional>
#include <iterator>
#include <numeric>

#include "io/read/number_type.hpp"

namespace lamella {

namespace {

/// Makes triangles of the faces of a list; one for each thread.
struct FaceCutter {
    void cut(std::span<std::uint32_t> indices, const VertexCoordinates& vertices,
             FunctionRef<TextError(std::uint32_t place, std::string what)> error) {
        for (std::size_t at = 0; at < indices.size();) {
            const bool polygon = indices[at] == polygon_mark;
            if (!polygon && indices[at] != quad_mark) {
                at += 3;
                continue;
            }
            const std::span<const std::uint32_t> stored =
                indices.subspan(at + (polygon ? 3 : 2), polygon ? indices[at + 2] : std::uint32_t{4});
            const std::uint32_t place = indices[at + 1];
            corners.assign(stored.begin(), stored.end());  // triangles are about to take their place
            const auto odd = std::find_if(corners.begin(), corners.end(),
                                          [&](std::uint32_t vertex) { return !vertices.is_finite(vertex); });
            if (odd != corners.end()) {
                throw error(place, "vertex " + std::to_string(*odd) + " of this face has a coordinate that is not finite");
            }
            if (triangulator.triangulate(corners, vertices, &indices[at]) == 0) {
                throw error(place, "this face is too entangled to be cut into triangles");
            }
            at += 3 * (corners.size() - 2);
        }
    }

    PolygonTriangulator triangulator;
    std::vector<std::uint32_t> corners;
};

/// The scratch memory of a thread grows to that of the largest face that it meets.
std::size_t cutting_bytes(std::span<const FaceList> lists, int threads) {
    std::vector<std::size_t> scratch(lists.size());
    std::transform(lists.begin(), lists.end(), scratch.begin(), [](const FaceList& list) {
        return PolygonTriangulator::scratch_bytes(list.most_corners()) + 2 * list.most_corners() * sizeof(std::uint32_t);
    });
    const auto largest = scratch.begin() + std::min<std::ptrdiff_t>(threads, std::ssize(scratch));
    std::partial_sort(scratch.begin(), largest, scratch.end(), std::greater());
    return std::accumulate(scratch.begin(), largest, std::size_t{0});
}

}  // namespace

void FaceList::add_polygon(std::span<const std::uint32_t> corners, std::uint64_t place) {
    if (corners.size() >= polygon_mark) {
        budget_->take(std::numeric_limits<std::uint64_t>::max(), 1);  // no budget holds as many
    }
    begin_ = most_corners_ == 0 ? place : begin_;
    most_corners_ = std::max(most_corners_, corners.size());
    const auto own = static_cast<std::uint32_t>(place - begin_);  // beyond 2^32 a message would name another face
    if (corners.size() == 4) {
        return put(std::array{quad_mark, own, corners[0], corners[1], corners[2], corners[3]});
    }
    put(std::array{polygon_mark, own, static_cast<std::uint32_t>(corners.size())});
    put(corners);
    for (std::size_t left = 2 * corners.size() - 9; left > 0;) {  // of 3 (n - 2), n + 3 are written
        const std::size_t count = std::min(left, room().size());
        indices_.add(count);
        left -= count;
    }
}

void FaceList::put(std::span<const std::uint32_t> values) {
    while (!values.empty()) {
        const std::span<std::uint32_t> to = room();
        const std::size_t count = std::min(values.size(), to.size());
        std::copy_n(values.begin(), count, to.begin());
        indices_.add(count);
        values = values.subspan(count);
    }
}

std::vector<FaceList> parse_faces(std::size_t pieces, MemoryBudget& budget, const Parallel& parallel,
                                  FunctionRef<void(std::size_t piece, FaceList& faces)> parse) {
    std::vector<FaceList> lists;
    lists.reserve(pieces);
    std::generate_n(std::back_inserter(lists), pieces, [&] { return FaceList(budget, parallel.memory()); });
    parse_pieces(pieces, parallel, [&](std::size_t i, int) {
        FaceList own = std::move(lists[i]);  // neighbours in the vector share lines of the threads' caches
        parse(i, own);
        lists[i] = std::move(own);
    });
    return lists;
}

void give_faces(std::span<FaceList> lists, const VertexCoordinates& vertices, MemoryBudget& budget, const Parallel& parallel,
                FaceError error, MeshFile& mesh) {
    std::vector<std::size_t> first(lists.size() + 1);  // index of each
    for (std::size_t i = 0; i < lists.size(); ++i) {
        first[i + 1] = first[i] + 3 * lists[i].triangles();
        budget.give_back(lists[i].bytes());  // which are free by the time that as many are written
    }
    budget.take(first.back(), sizeof(std::uint32_t));
    budget.take(cutting_bytes(lists, parallel.threads()), 1);
    mesh.indices = Array<std::uint32_t>(parallel.memory());
    mesh.indices.resize_discarding(first.back());
    mesh.triangle_count = first.back() / 3;
    std::vector<FaceCutter> cutters(static_cast<std::size_t>(parallel.threads()));
    parse_pieces(lists.size(), parallel, [&](std::size_t i, int worker) {
        FaceList& list = lists[i];
        list.move_to(mesh.indices.data() + first[i]);
        const std::span<std::uint32_t> own = mesh.indices.span().subspan(first[i], first[i + 1] - first[i]);
        if (list.most_corners() == 0) {
            return;
        }
        cutters[static_cast<std::size_t>(worker)].cut(own, vertices, [&](std::uint32_t place, std::string what) {
            return error(i, list.begin() + place, std::move(what));
        });
    });
}

void allocate_vertices(std::size_t count, Number type, MemoryBudget& budget, const Memory* memory, MeshFile& mesh) {
    mesh.vertex_type = type;
    mesh.stride = 3 * size_of(type);
    mesh.first_offset = 0;
    mesh.vertex_count = count;
    budget.take(count, mesh.stride);
    mesh.bytes = Array<std::byte>(memory);
    mesh.bytes.resize_discarding(count * mesh.stride);
}

void read_faces(const FileContents& file, std::size_t vertices, std::size_t pieces,
                FunctionRef<void(std::size_t piece, std::byte* coordinates, FaceList& faces)> parse, MeshFile& mesh) {
    const FileSource& source = file.source;
    if (vertices >= most_vertices) {
        source.refuse(ErrorCode::malformed_mesh, "has " + std::to_string(vertices) + " vertices, too many to be numbered");
    }
    MemoryBudget budget(source);
    allocate_vertices(vertices, Number::f64, budget, source.memory(), mesh);
    std::vector<FaceList> lists = parse_faces(pieces, budget, source.parallel(),
                                              [&](std::size_t i, FaceList& faces) { parse(i, mesh.bytes.data(), faces); });
    mesh.text = true;
    give_faces(
        lists, coordinates_of(mesh), budget, source.parallel(),
        [&](std::size_t, std::uint64_t place, std::string what) {
            return TextError{file.whole.data() + place, std::move(what)};
        },
        mesh);
    LeftOut small;
    for (const FaceList& list : lists) {
        small.add({list.small(), list.small() > 0 ? file.whole.data() + list.first_small() : nullptr});
    }
    if (mesh.triangle_count == 0) {
        source.refuse(ErrorCode::empty_mesh, small.count == 0 ? "holds no faces" : "holds no face of three corners or more");
    }
    if (small.count > 0) {
        mesh.warnings.push_back(source.name() + ": left out " + std::to_string(small.count) +
                                " faces of fewer than three corners" + first_line_words(small, file.whole));
    }
}

}  // namespace lamella
