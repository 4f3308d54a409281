// PLY, ASCII and binary, of either byte order: all that follows the header.
#include "io/read/ply/ply_body.hpp"

#include "base/words.hpp"
#include "io/read/ply/ply_rows.hpp"

namespace lamella {

namespace {

/// Goes through all elements twice: first to find where each begins and how much memory it takes, then to read them,
/// vertices first. Elements may come in any order.
template <class Numbers>
class BodyReader {
public:
    BodyReader(const PlyInput& input, MeshFile& mesh) : input_(input), mesh_(mesh) {
        mesh_.indices = Array<std::uint32_t>(input.source.memory());
    }

    PlyBody read(const Numbers& numbers) {
        try {
            read_all(numbers);
            return body_;
        } catch (const TextError& error) {
            find_error_before(error, numbers);
            throw;
        }
    }

private:
    struct Place {
        const PlyElement& element;
        Numbers begin;
        PlyLists lists{};
        bool copied = false;  ///< its indices have been, to the beginning of the mesh's
    };

    void read_all(const Numbers& numbers) {
        locate(numbers);
        must_be_affordable();
        read_vertices(*place_of(PlyRole::vertices));
        if (needs_coordinates()) {
            cut_polygons();
        }
        mesh_.triangle_count = mesh_.indices.size() / 3;
    }

    void cut_polygons() {
        mesh_.indices.resize_discarding(3 * triangles_);
        FaceRange range;
        range.triangles = triangles_;
        FaceWriter faces(mesh_.indices.span(), range);
        for (const PlyRole role : {PlyRole::faces, PlyRole::strips}) {
            if (const Place* const place = place_of(role); place != nullptr) {
                read_lists(*place, faces);
            }
        }
        range.triangles = faces.triangles();
        mesh_.indices.set_size(3 * range.triangles);
        const std::byte* const first =
            mesh_.bytes.empty() ? reinterpret_cast<const std::byte*>(input_.file.data()) : mesh_.bytes.data();
        cut_faces({&range, 1}, mesh_.indices.span(), {first + mesh_.first_offset, mesh_.stride, mesh_.vertex_type},
                  input_.parallel(), [this](std::size_t, const RefusedFace& face) { refuse(face); });
    }

    /// The first pass skips numbers: an earlier element may hold a malformed one. The first error in the file is thrown.
    void find_error_before(const TextError& found, const Numbers& numbers) {
        places_.clear();
        strict_ = true;
        try {
            locate(numbers);
        } catch (const TextError& error) {
            if (error.at <= found.at) {
                throw;
            }
        }
    }

    void locate(Numbers numbers) {
        places_.reserve(input_.header.elements.size());
        for (const PlyElement& element : input_.header.elements) {
            Place& place = places_.emplace_back(Place{element, numbers});
            must_fit(element, numbers);
            if (!element.properties.empty()) {
                read_over(place, numbers);
            }
            triangles_ += place.lists.triangles;
        }
        body_.end = offset_of(numbers.at());
    }

    /// The bytes left must be able to hold the element's rows at their smallest.
    void must_fit(const PlyElement& element, const Numbers& numbers) const {
        const std::uint64_t row = element.least_row_bytes(input_.header.encoding);
        const std::uint64_t left = input_.file.size() - offset_of(numbers.at());
        const std::uint64_t last_space = Numbers::binary ? 0 : 1;  // after the last number in a file there may be none
        if (row != 0 && element.count > (left + last_space) / row) {
            throw TextError{numbers.at(),
                            "the header counts " + std::to_string(element.count) + " of element " + in_quotes(element.name) +
                                ", but " + std::to_string(left) + " bytes are left",
                            !Numbers::binary};
        }
    }

    void read_over(Place& place, Numbers& numbers) {
        const PlyElement& element = place.element;
        if constexpr (Numbers::binary) {
            if (!element.has_lists()) {
                numbers.skip(NumberType::uint8, element.count * element.least_row_bytes(input_.header.encoding));
                return;
            }
            if (copy_triangles(element, numbers)) {
                place.copied = true;
                place.lists = {element.count, 3};
                numbers.skip(NumberType::uint8, element.count * *triangle_row_bytes(element));
                return;
            }
        }
        PlyRows<Numbers> rows(numbers, element);
        Lookout lookout(input_.parallel());
        for (std::uint64_t row = 0; row < element.count; ++row) {
            lookout.pass();
            if (strict_) {
                check_row(rows, element);
            } else {
                rows.skip(place.lists);
            }
        }
        numbers = rows.numbers();
    }

    /// Nearly all files hold triangles only, which are copied already in the first pass.
    bool copy_triangles(const PlyElement& element, const Numbers& numbers) {
        return !strict_ && element.role == PlyRole::faces && input_.header.element_of(PlyRole::strips) == nullptr &&
               copy_triangle_rows(input_, element, numbers.at(), mesh_.indices);
    }

    void check_row(PlyRows<Numbers>& rows, const PlyElement& element) {
        PlyLists lists;
        std::byte xyz[3 * sizeof(double)];
        if (element.role == PlyRole::vertices) {
            rows.vertex(number_for(element), xyz);
        } else if (element.role == PlyRole::nothing) {
            rows.skip(lists);
        } else {
            rows.indices(input_.header.element_of(PlyRole::vertices)->count, list_);
        }
    }

    /// The mesh must fit the memory limit; asked before anything is allocated by the file's counts.
    void must_be_affordable() {
        const Place& vertices = *place_of(PlyRole::vertices);
        const std::uint64_t most_vertices = strip_end;  // indices have 32 bits
        if (vertices.element.count > most_vertices) {
            throw TextError{vertices.begin.at(), "more than " + std::to_string(most_vertices) + " vertices",
                            !Numbers::binary};
        }
        std::uint64_t longest = 0;
        for (const Place& place : places_) {
            longest = std::max(longest, place.lists.longest);
        }
        input_.source.must_fit(vertices.element.count * 3 * size_of(number_for(vertices.element)) +
                               triangles_ * 3 * sizeof(std::uint32_t) + longest * sizeof(std::uint32_t) +
                               PolygonTriangulator::scratch_bytes(longest));
        list_.reserve(longest);  // growing would take more than what was counted
    }

    /// True if there may be polygons to be cut.
    bool needs_coordinates() const {
        const Place* const faces = place_of(PlyRole::faces);
        return faces == nullptr || !faces->copied;
    }

    void read_vertices(const Place& place) {
        if constexpr (Numbers::binary) {
            if (take_vertices(place)) {
                return;
            }
        }
        allocate_vertices(place.element.count, number_for(place.element), input_.source.memory(), mesh_);
        if constexpr (Numbers::binary) {
            if (!place.element.has_lists()) {
                return copy_vertices(input_, place.element, place.begin.at(), mesh_);
            }
        }
        PlyRows<Numbers> rows(place.begin, place.element);
        Lookout lookout(input_.parallel());
        for (std::uint64_t row = 0; row < place.element.count; ++row) {
            lookout.pass();
            rows.vertex(mesh_.vertex_type, mesh_.bytes.data() + row * mesh_.stride);
        }
    }

    /// True if the vertices of a binary file can be used where they lie.
    bool take_vertices(const Place& place) {
        const auto offset = vertices_in_place(place.element, offset_of(place.begin.at()));
        if (!offset || (input_.swapped() && needs_coordinates())) {
            return false;
        }
        body_.swapped = input_.swapped();
        mesh_.first_offset = *offset;
        mesh_.stride = place.element.least_row_bytes(input_.header.encoding);
        mesh_.vertex_type = number_for(place.element);
        mesh_.vertex_count = place.element.count;
        return true;
    }

    void read_lists(const Place& place, FaceWriter& faces) {
        PlyRows<Numbers> rows(place.begin, place.element);
        Lookout lookout(input_.parallel());
        for (std::uint64_t row = 0; row < place.element.count; ++row) {
            lookout.pass(1 + list_.size());
            rows.indices(mesh_.vertex_count, list_);
            if (place.element.role == PlyRole::strips) {
                add_strips(faces);
            } else if (faces.add(list_)) {
                body_.small_faces += list_.size() < 3 ? 1 : 0;
            } else {
                throw TextError{rows.numbers().at(), "too many corners to be cut into triangles", !Numbers::binary};
            }
        }
    }

    /// Takes strips that strip_end separates: a b c d e makes a b c, c b d and c d e. Triangles of two equal indices, which
    /// join strips, are left out.
    void add_strips(FaceWriter& faces) const {
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
                faces.add(triangle);
            }
        }
    }

    /// Throws an error at a face's row, which has been read before.
    [[noreturn]] void refuse(const RefusedFace& face) const {
        const Place& place = *place_of(PlyRole::faces);
        PlyRows<Numbers> rows(place.begin, place.element);
        std::size_t number = face.number;
        for (std::uint64_t row = 0;; ++row) {
            const char* const begin = rows.numbers().at();
            PlyLists lists;
            rows.skip(lists);
            if (lists.longest >= 3 && number-- == 0) {
                const std::string why =
                    face.vertex ? "vertex " + std::to_string(*face.vertex) + " has a coordinate that is not finite"
                                : "a polygon of " + std::to_string(lists.longest) + " corners that crosses itself too often";
                throw TextError{begin, in_quotes(place.element.name) + " " + std::to_string(row) + ": " + why,
                                !Numbers::binary};
            }
        }
    }

    const Place* place_of(PlyRole role) const {
        const auto found =
            std::find_if(places_.begin(), places_.end(), [role](const Place& place) { return place.element.role == role; });
        return found == places_.end() ? nullptr : &*found;
    }

    std::size_t offset_of(const char* at) const { return static_cast<std::size_t>(at - input_.file.data()); }

    const PlyInput& input_;
    MeshFile& mesh_;
    PlyBody body_;
    std::vector<Place> places_;
    std::uint64_t triangles_ = 0;  // at most
    bool strict_ = false;          // check each number in the first pass
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
