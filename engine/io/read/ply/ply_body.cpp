// PLY, ASCII and binary, of either byte order: all that follows the header.
#include "io/read/ply/ply.hpp"

#include "base/words.hpp"
#include "io/read/ply/ply_rows.hpp"

namespace lamella {

namespace {

/// Goes through all elements in the file's order. Vertices of one size are left where they lie until it is known whether
/// they can stay there.
template <class Numbers>
class BodyReader {
public:
    BodyReader(const PlyInput& input, MeshFile& mesh) : input_(input), mesh_(mesh), budget_(input.source) {}

    PlyBody read(Numbers numbers) {
        for (const PlyElement& element : input_.header.elements) {
            must_hold(element, numbers);
            const Numbers begin = numbers;
            if (!pass_over(element, numbers)) {
                read_rows(element, numbers);
            }
            vertices_ = element.role == PlyRole::vertices ? begin.at() : vertices_;
            faces_ = element.role == PlyRole::faces ? std::optional(begin) : faces_;
        }
        body_.end = offset_of(numbers.at());
        if (mesh_.stride == 0) {
            place_vertices(*input_.header.element_of(PlyRole::vertices));
        }
        for (const FaceList& list : lists_) {
            body_.small_faces += list.small();
        }
        if (lists_.empty()) {
            mesh_.triangle_count = mesh_.indices.size() / 3;
            return body_;
        }
        const std::byte* const first =
            mesh_.bytes.empty() ? reinterpret_cast<const std::byte*>(input_.file.data()) : mesh_.bytes.data();
        give_faces(
            lists_, {first + mesh_.first_offset, mesh_.stride, mesh_.vertex_type}, budget_, input_.parallel(),
            [this](std::size_t, const RefusedFace& face) { refuse(face); }, mesh_);
        return body_;
    }

private:
    /// The bytes left must be able to hold the element's rows at their smallest.
    void must_hold(const PlyElement& element, const Numbers& numbers) const {
        const std::uint64_t row = element.least_row_bytes(input_.header.encoding);
        const std::uint64_t left = input_.file.size() - offset_of(numbers.at());
        const std::uint64_t last_space = Numbers::binary ? 0 : 1;  // after the last number in a file there may be none
        if (row != 0 && element.count > (left + last_space) / row) {
            throw TextError{numbers.at(),
                            "the header counts " + std::to_string(element.count) + " of element " + in_quotes(element.name) +
                                ", but " + std::to_string(left) + " bytes are left",
                            !Numbers::binary};
        }
        if (element.role == PlyRole::vertices && element.count >= most_vertices) {
            throw TextError{element.at, "more vertices than can be numbered"};
        }
    }

    /// True if rows need not be read one by one: they are of one size, or nothing.
    bool pass_over(const PlyElement& element, Numbers& numbers) {
        if constexpr (Numbers::binary) {
            if (!element.has_lists()) {
                return numbers.skip(NumberType::uint8, element.count * element.least_row_bytes(input_.header.encoding));
            }
            // Nearly all files hold triangles only.
            if (element.role == PlyRole::faces && input_.header.element_of(PlyRole::strips) == nullptr &&
                copy_triangle_rows(input_, element, numbers.at(), budget_, mesh_.indices)) {
                return numbers.skip(NumberType::uint8, element.count * *triangle_row_bytes(element));
            }
        }
        return element.properties.empty();
    }

    void read_rows(const PlyElement& element, Numbers& numbers) {
        constexpr std::uint64_t rows_a_list = std::uint64_t{1} << 16;
        if (element.role == PlyRole::vertices) {
            allocate_vertices(element.count, number_for(element), budget_, input_.source.memory(), mesh_);
        }
        PlyRows<Numbers> rows(numbers, element);
        Lookout lookout(input_.parallel());
        for (std::uint64_t row = 0; row < element.count; ++row) {
            lookout.pass(1 + list_.size());
            if (element.role == PlyRole::vertices) {
                rows.vertex(mesh_.vertex_type, mesh_.bytes.data() + row * mesh_.stride);
            } else if (element.role == PlyRole::nothing) {
                rows.skip();
            } else {
                if (row % rows_a_list == 0) {
                    lists_.emplace_back(budget_, input_.source.memory());
                }
                const std::size_t place = offset_of(rows.numbers().at());
                rows.indices(vertex_count(), list_);
                element.role == PlyRole::strips ? add_strips(place) : lists_.back().add(list_, place);
            }
        }
        numbers = rows.numbers();
    }

    /// Uses the vertices of a binary file where they lie, if that can be.
    void place_vertices(const PlyElement& element) {
        const std::optional<std::size_t> offset = vertices_in_place(element, offset_of(vertices_));
        const bool are_needed = !lists_.empty();  // to cut polygons
        if (!offset || (input_.swapped() && are_needed)) {
            allocate_vertices(element.count, number_for(element), budget_, input_.source.memory(), mesh_);
            return copy_vertices(input_, element, vertices_, mesh_);
        }
        body_.swapped = input_.swapped();
        mesh_.first_offset = *offset;
        mesh_.stride = element.least_row_bytes(input_.header.encoding);
        mesh_.vertex_type = number_for(element);
        mesh_.vertex_count = element.count;
    }

    /// Takes strips that strip_end separates: a b c d e makes a b c, c b d and c d e. Triangles of two equal indices, which
    /// join strips, are left out.
    void add_strips(std::size_t place) {
        std::size_t begin = 0;  // of the strip
        for (std::size_t i = 0; i < list_.size(); ++i) {
            if (list_[i] == strip_end) {
                begin = i + 1;
            }
            if (i < begin + 2) {
                continue;
            }
            // Every other triangle of a strip is listed in reverse.
            const bool odd = (i - begin) % 2 != 0;
            const std::uint32_t triangle[] = {list_[odd ? i - 1 : i - 2], list_[odd ? i - 2 : i - 1], list_[i]};
            if (triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0]) {
                lists_.back().add(triangle, place);
            }
        }
    }

    /// Throws an error at a face's row, which has been read before.
    [[noreturn]] void refuse(const RefusedFace& face) const {
        const PlyElement& element = *input_.header.element_of(PlyRole::faces);
        PlyRows<Numbers> rows(*faces_, element);
        std::uint64_t row = 0;
        for (; offset_of(rows.numbers().at()) < face.place; ++row) {
            rows.skip();
        }
        const std::string why =
            face.vertex ? "vertex " + std::to_string(*face.vertex) + " has a coordinate that is not finite"
                        : "a polygon of " + std::to_string(face.corners) + " corners that crosses itself too often";
        throw TextError{rows.numbers().at(), in_quotes(element.name) + " " + std::to_string(row) + ": " + why,
                        !Numbers::binary};
    }

    std::uint64_t vertex_count() const { return input_.header.element_of(PlyRole::vertices)->count; }
    std::size_t offset_of(const char* at) const { return static_cast<std::size_t>(at - input_.file.data()); }

    const PlyInput& input_;
    MeshFile& mesh_;
    MemoryBudget budget_;
    PlyBody body_;
    const char* vertices_ = nullptr;  // where they begin
    std::optional<Numbers> faces_;
    std::vector<FaceList> lists_;  // of faces that are not copied
    std::vector<std::uint32_t> list_;
};

/// Fills in the vertices and indices of `mesh`. It has no bytes where coordinates are used where they lie in the file.
/// Throws the first error in the body, whatever the number of threads.
PlyBody read_ply_body(const PlyInput& input, MeshFile& mesh) {
    const char* const begin = input.file.data() + input.header.body;
    const char* const end = input.file.data() + input.file.size();
    PlyBody body;
    if (input.header.encoding != PlyEncoding::ascii) {
        return BodyReader<BinaryNumbers>(input, mesh).read({begin, end, input.swapped()});
    }
    // From number to number, words that no property takes would be read as the next row.
    if (read_ply_lines(input, mesh, body)) {
        return body;
    }
    return BodyReader<AsciiNumbers>(input, mesh).read({begin, end});
}

/// Everything that is not read is said.
std::vector<std::string> warnings_of(const FileSource& file, std::string_view contents, const PlyHeader& header,
                                     const PlyBody& body) {
    std::vector<std::string> warnings;
    warn_of_skipped_lines(file, contents, header, warnings);
    if (body.long_rows.count > 0) {
        warnings.push_back(file.name() + ": ignored what follows the declared properties in " +
                           counted(body.long_rows.count, "line") + first_line_words(body.long_rows, contents));
    }
    if (body.small_faces > 0) {
        warnings.push_back(file.name() + ": left out " + counted(body.small_faces, "face") +
                           " of fewer than three vertices");
    }
    const char* rest = contents.data() + body.end;
    const char* const end = contents.data() + contents.size();
    rest = header.encoding == PlyEncoding::ascii ? skip_space(rest, end) : rest;
    warn_of_rest(file, static_cast<std::uint64_t>(end - rest), warnings);
    return warnings;
}

void parse_ply(FileContents& file, MeshFile& mesh) {
    const FileSource& source = file.source;
    const PlyHeader header = parse_ply_header(file.whole);
    check_ply_header(source, header);
    const PlyBody body = read_ply_body({source, file.whole, header}, mesh);
    if (mesh.triangle_count == 0) {
        source.refuse(ErrorCode::empty_mesh, "holds no triangles");
    }
    mesh.text = header.encoding == PlyEncoding::ascii;
    mesh.warnings = warnings_of(source, file.whole, header, body);
    header.patient_frame.give(source, mesh);
    if (mesh.bytes.empty()) {
        mesh.bytes = std::move(file.bytes);
    }
    if (body.swapped) {
        swap_vertices(mesh, source.parallel());
    }
}

}  // namespace

Number number_for(const PlyElement& vertices) noexcept {
    const bool wide = std::any_of(vertices.properties.begin(), vertices.properties.end(), [](const PlyProperty& p) {
        return p.use != PlyUse::nothing &&
               (p.type == NumberType::float64 || p.type == NumberType::int32 || p.type == NumberType::uint32);
    });
    return wide ? Number::f64 : Number::f32;
}

MeshFile read_ply(FileSource& source) {
    return read_contents(source, parse_ply);
}

}  // namespace lamella
