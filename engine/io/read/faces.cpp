#include "io/read/faces.hpp"

#include <iterator>

#include "base/words.hpp"
#include "io/read/number_type.hpp"

namespace lamella {

void FaceList::add_polygon(std::span<const std::uint32_t> corners, const char* place, bool has_lines) {
    if (vertices_.first == nullptr) {
        return add_uncut(corners, place);
    }
    const std::span<std::uint32_t> here = room();
    if (corners.size() == 4 && here.size() >= 6 && splits_at_first(corners, vertices_)) {  // nearly all polygons
        fan(corners, here.data());
        return indices_.add(6);
    }
    const std::size_t count = 3 * (corners.size() - 2);
    if (count <= here.size()) {
        triangulate(corners, place, has_lines, here.data());
        return indices_.add(count);
    }
    take_scratch(2 * count * sizeof(std::uint32_t) + PolygonTriangulator::scratch_bytes(corners.size()));
    scratch_.resize(count);
    triangulate(corners, place, has_lines, scratch_.data());
    put(scratch_);
}

void FaceList::add_uncut(std::span<const std::uint32_t> corners, const char* place) {
    if (corners.size() >= polygon_mark) {
        budget_->take(std::numeric_limits<std::uint64_t>::max(), 1);  // no budget holds as many
    }
    first_uncut_ = first_uncut_ == nullptr ? place : first_uncut_;
    const auto own = static_cast<std::uint32_t>(place - first_uncut_);  // beyond 2^32 a message would name another face
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

void FaceList::cut(std::span<std::uint32_t> indices, const VertexCoordinates& vertices) {
    if (first_uncut_ == nullptr) {
        return;
    }
    vertices_ = vertices;
    for (std::size_t at = 0; at < indices.size();) {
        const bool polygon = indices[at] == polygon_mark;
        if (!polygon && indices[at] != quad_mark) {
            at += 3;
            continue;
        }
        const std::span<const std::uint32_t> stored =
            indices.subspan(at + (polygon ? 3 : 2), polygon ? indices[at + 2] : std::uint32_t{4});
        take_scratch(2 * stored.size_bytes() + PolygonTriangulator::scratch_bytes(stored.size()));
        scratch_.assign(stored.begin(), stored.end());
        triangulate(scratch_, first_uncut_ + indices[at + 1], true, &indices[at]);
        at += 3 * (scratch_.size() - 2);
    }
    close();
}

void FaceList::triangulate(std::span<const std::uint32_t> corners, const char* place, bool has_lines, std::uint32_t* out) {
    const auto odd = std::find_if(corners.begin(), corners.end(), [this](auto v) { return !vertices_.is_finite(v); });
    if (odd != corners.end()) {
        throw TextError{place, "vertex " + std::to_string(*odd) + " of this face has a coordinate that is not finite",
                        has_lines};
    }
    take_scratch(PolygonTriangulator::scratch_bytes(corners.size()));
    if (triangulator_.triangulate(corners, vertices_, out) == 0) {
        throw TextError{place, "this face is too entangled to be cut into triangles", has_lines};
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

void FaceList::take_scratch(std::uint64_t bytes) {
    if (bytes > scratch_bytes_) {
        budget_->take(bytes - scratch_bytes_, 1);
        scratch_bytes_ = bytes;
    }
}

void FaceList::close() {
    budget_->give_back(std::exchange(scratch_bytes_, 0));
    triangulator_ = PolygonTriangulator();
    scratch_ = std::vector<std::uint32_t>();
}

std::vector<FaceList> parse_faces(std::size_t pieces, const VertexCoordinates& vertices, MemoryBudget& budget,
                                  const Parallel& parallel, FunctionRef<void(std::size_t piece, FaceList& faces)> parse) {
    std::vector<FaceList> lists;
    lists.reserve(pieces);
    std::generate_n(std::back_inserter(lists), pieces, [&] { return FaceList(budget, vertices, parallel.memory()); });
    parse_pieces(pieces, parallel, [&](std::size_t i, int) {
        FaceList own = std::move(lists[i]);  // neighbours in the vector share lines of the threads' caches
        parse(i, own);
        own.close();
        lists[i] = std::move(own);
    });
    return lists;
}

void give_faces(std::span<FaceList> lists, MemoryBudget& budget, const FileSource& source, std::string_view text,
                MeshFile& mesh) {
    std::vector<std::size_t> first(lists.size() + 1);  // index of each
    LeftOut small;
    for (std::size_t i = 0; i < lists.size(); ++i) {
        first[i + 1] = first[i] + 3 * lists[i].triangles();
        small.add(lists[i].small());
        budget.give_back(lists[i].bytes());  // which are free by the time that as many are written
    }
    if (first.back() == 0) {
        source.refuse(ErrorCode::empty_mesh, "holds no triangles");
    }
    if (small.count > 0) {
        mesh.warnings.push_back(source.name() + ": left out " + counted(small.count, "face") +
                                " of fewer than three corners" +
                                (mesh.text && small.first != nullptr ? first_line_words(small, text) : ""));
    }
    budget.take(first.back(), sizeof(std::uint32_t));
    mesh.indices = Array<std::uint32_t>(source.memory());
    mesh.indices.resize_discarding(first.back());
    mesh.triangle_count = first.back() / 3;
    parse_pieces(lists.size(), source.parallel(), [&](std::size_t i, int) {
        lists[i].move_to(mesh.indices.data() + first[i]);
        lists[i].cut(mesh.indices.span().subspan(first[i], first[i + 1] - first[i]), coordinates_of(mesh));
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
    mesh.text = true;
    std::vector<FaceList> lists = parse_faces(pieces, {}, budget, source.parallel(),
                                              [&](std::size_t i, FaceList& faces) { parse(i, mesh.bytes.data(), faces); });
    give_faces(lists, budget, source, file.whole, mesh);
}

}  // namespace lamella
