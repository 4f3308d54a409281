#include "io/read/faces.hpp"

#include <iterator>

#include "base/words.hpp"
#include "io/read/number_type.hpp"

namespace lamella {

void FaceList::add_polygon(std::span<const std::uint32_t> corners, const char* place, bool has_lines) {
    const auto odd = std::find_if(corners.begin(), corners.end(), [this](auto v) { return !vertices_.is_finite(v); });
    if (odd != corners.end()) {
        throw TextError{place, "vertex " + std::to_string(*odd) + " of this face has a coordinate that is not finite",
                        has_lines};
    }
    scratch_ = scratch_ != nullptr ? std::move(scratch_) : std::make_unique<Scratch>();
    const std::size_t count = 3 * (corners.size() - 2);
    // Twice, as vectors grow by copying.
    const std::uint64_t bytes = PolygonTriangulator::scratch_bytes(corners.size()) + 2 * count * sizeof(std::uint32_t);
    if (bytes > scratch_->bytes) {
        budget_->take(bytes - scratch_->bytes, 1);
        scratch_->bytes = bytes;
    }
    scratch_->triangles.resize(count);
    if (scratch_->triangulator.triangulate(corners, vertices_, scratch_->triangles.data()) == 0) {
        throw TextError{place, "this face is too entangled to be cut into triangles", has_lines};
    }
    for (std::span<const std::uint32_t> left = scratch_->triangles; !left.empty();) {
        const std::span<std::uint32_t> to = room();
        const std::size_t fits = std::min(left.size(), to.size());
        std::copy_n(left.begin(), fits, to.begin());
        indices_.add(fits);
        left = left.subspan(fits);
    }
}

void FaceList::close() {
    budget_->give_back(scratch_ != nullptr ? scratch_->bytes : 0);
    scratch_.reset();
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
    source.parallel().run(lists.size(), [&](std::size_t i, int) { lists[i].move_to(mesh.indices.data() + first[i]); });
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
                FunctionRef<void(std::size_t piece, std::byte* coordinates)> put_vertices,
                FunctionRef<void(std::size_t piece, FaceList& faces)> add_faces, MeshFile& mesh) {
    const FileSource& source = file.source;
    if (vertices >= most_vertices) {
        source.refuse(ErrorCode::malformed_mesh, "has " + std::to_string(vertices) + " vertices, too many to be numbered");
    }
    MemoryBudget budget(source);
    allocate_vertices(vertices, Number::f64, budget, source.memory(), mesh);
    mesh.text = true;
    parse_pieces(pieces, source.parallel(), [&](std::size_t i, int) { put_vertices(i, mesh.bytes.data()); });
    std::vector<FaceList> lists = parse_faces(pieces, coordinates_of(mesh), budget, source.parallel(), add_faces);
    give_faces(lists, budget, source, file.whole, mesh);
}

}  // namespace lamella
