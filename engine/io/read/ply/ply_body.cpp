#include "io/read/ply/ply_body.hpp"

#include <algorithm>
#include <cstring>
#include <optional>
#include <type_traits>
#include <vector>

#include "io/read/lookout.hpp"
#include "io/read/ply/ply_binary.hpp"
#include "io/read/ply/ply_lines.hpp"
#include "io/read/ply/ply_numbers.hpp"
#include "io/read/ply/ply_rows.hpp"
#include "io/read/ply/ply_triangles.hpp"

namespace lamella {

namespace {

/// Goes through all elements twice: first to find where each begins and how much memory it takes, then to read them,
/// vertices first. Elements may come in any order.
template <class Numbers>
class BodyReader {
public:
    BodyReader(const PlyInput& input, PlyMesh& mesh, PlyProblem& problem) : input_(input), mesh_(mesh), problem_(problem) {}

    bool read(const Numbers& numbers) {
        const bool good = read_all(numbers);
        if (!good && problem_.code == ErrorCode::malformed_mesh) {
            find_first_problem(numbers);
        }
        return good;
    }

private:
    static constexpr bool binary = std::is_same_v<Numbers, BinaryNumbers>;

    struct Place {
        const PlyElement& element;
        Numbers begin;
        PlyLists lists;
        bool copied = false;  ///< its indices have been, to the beginning of the mesh's
    };

    bool read_all(const Numbers& numbers);
    void find_first_problem(const Numbers& numbers);
    bool locate(Numbers numbers);
    bool fits(const PlyElement& element, const Numbers& numbers);
    bool read_over(Place& place, Numbers& numbers);
    std::optional<std::uint64_t> copy_triangles(const PlyElement& element, const Numbers& numbers);
    bool read_over_rows(Place& place, Numbers& numbers);
    bool check_row(PlyRows<Numbers>& rows, const PlyElement& element);
    bool affordable();
    bool needs_coordinates() const;
    bool read_vertices(const Place& place);
    template <class Value>
    bool read_vertex_rows(const Place& place);
    bool read_lists(const Place& place, PlyTriangles& triangles);
    const Place* place_of(PlyRole role) const;
    std::size_t offset_of(const char* at) const { return static_cast<std::size_t>(at - input_.file.data()); }
    bool fail(const char* at, const std::string& what, ErrorCode code = ErrorCode::malformed_mesh);

    const PlyInput& input_;
    PlyMesh& mesh_;
    PlyProblem& problem_;
    std::vector<Place> places_;
    std::uint64_t triangles_ = 0;  // at most
    bool strict_ = false;          // check each number in the first pass
    std::vector<std::uint32_t> list_;
};

template <class Numbers>
bool BodyReader<Numbers>::read_all(const Numbers& numbers) {
    if (!locate(numbers) || !affordable() || !read_vertices(*place_of(PlyRole::vertices))) {
        return false;
    }
    if (needs_coordinates()) {
        mesh_.indices.resize_discarding(3 * triangles_);
    }
    const std::byte* const first =
        mesh_.coordinates.empty() ? reinterpret_cast<const std::byte*>(input_.file.data()) : mesh_.coordinates.data();
    PlyTriangles triangles({first + mesh_.first_offset, mesh_.stride, mesh_.coordinate_type}, mesh_.indices.span());
    for (const PlyRole role : {PlyRole::faces, PlyRole::strips}) {
        const Place* const place = place_of(role);
        if (place != nullptr && !read_lists(*place, triangles)) {
            return false;
        }
    }
    mesh_.indices.set_size(triangles.index_count());
    mesh_.small_faces = triangles.small_faces();
    return true;
}

/// The first pass skips numbers: an earlier element may hold a malformed one. The first error in the file is reported.
template <class Numbers>
void BodyReader<Numbers>::find_first_problem(const Numbers& numbers) {
    const PlyProblem found = problem_;
    places_.clear();
    strict_ = true;
    if (locate(numbers) || problem_.offset > found.offset) {
        problem_ = found;
    }
}

template <class Numbers>
bool BodyReader<Numbers>::locate(Numbers numbers) {
    places_.reserve(input_.header.elements.size());
    for (const PlyElement& element : input_.header.elements) {
        Place& place = places_.emplace_back(Place{element, numbers, {}});
        if (!fits(element, numbers) || !read_over(place, numbers)) {
            return false;
        }
        triangles_ += place.lists.triangles;
    }
    mesh_.end = offset_of(numbers.at());
    return true;
}

/// Whether the bytes left could hold the element's rows at their smallest.
template <class Numbers>
bool BodyReader<Numbers>::fits(const PlyElement& element, const Numbers& numbers) {
    const std::uint64_t row = element.least_row_bytes(input_.header.encoding);
    const std::uint64_t left = input_.file.size() - offset_of(numbers.at());
    const std::uint64_t last_space = binary ? 0 : 1;  // after the last number in a file there may be none
    if (row == 0 || element.count <= (left + last_space) / row) {
        return true;
    }
    return fail(numbers.at(), "the header counts " + std::to_string(element.count) + " of element " +
                                  short_name(element.name) + ", but " + std::to_string(left) + " bytes are left");
}

template <class Numbers>
bool BodyReader<Numbers>::read_over(Place& place, Numbers& numbers) {
    const PlyElement& element = place.element;
    if (element.properties.empty()) {
        return true;
    }
    if constexpr (binary) {
        if (!element.has_lists()) {
            return numbers.skip(PlyType::uint8, element.count * element.least_row_bytes(input_.header.encoding));
        }
        if (const std::optional<std::uint64_t> bytes = copy_triangles(element, numbers)) {
            place.copied = true;
            place.lists = {element.count, 3};
            return numbers.skip(PlyType::uint8, *bytes);
        }
    }
    return read_over_rows(place, numbers);
}

/// Nearly all files hold triangles only, which are copied already in the first pass. Returns the bytes that they take.
template <class Numbers>
std::optional<std::uint64_t> BodyReader<Numbers>::copy_triangles(const PlyElement& element, const Numbers& numbers) {
    const PlyHeader& header = input_.header;
    if (strict_ || element.role != PlyRole::faces || header.element_of(PlyRole::strips) != nullptr) {
        return std::nullopt;
    }
    return copy_triangle_rows(input_, element, numbers.at(), header.element_of(PlyRole::vertices)->count, mesh_.indices);
}

template <class Numbers>
bool BodyReader<Numbers>::read_over_rows(Place& place, Numbers& numbers) {
    PlyRows<Numbers> rows(numbers, place.element);
    Lookout lookout(input_.parallel);
    for (std::uint64_t row = 0; row < place.element.count; ++row) {
        lookout.pass();
        if (!(strict_ ? check_row(rows, place.element) : rows.skip(place.lists))) {
            return fail(rows.at(), rows.what());
        }
    }
    numbers = rows.numbers();
    return true;
}

template <class Numbers>
bool BodyReader<Numbers>::check_row(PlyRows<Numbers>& rows, const PlyElement& element) {
    const PlyElement& vertices = *input_.header.element_of(PlyRole::vertices);
    PlyLists lists;
    float singles[3];
    double doubles[3];
    switch (element.role) {
        case PlyRole::vertices:
            return number_for(element) == CoordinateType::f64 ? rows.vertex(doubles) : rows.vertex(singles);
        case PlyRole::faces:
        case PlyRole::strips:
            return rows.indices(vertices.count, list_);
        case PlyRole::nothing:
            break;
    }
    return rows.skip(lists);
}

/// Whether the mesh fits the memory limit; asked before anything is allocated by the file's counts.
template <class Numbers>
bool BodyReader<Numbers>::affordable() {
    const Place& vertices = *place_of(PlyRole::vertices);
    const std::uint64_t most_vertices = strip_end;  // indices have 32 bits
    if (vertices.element.count > most_vertices) {
        return fail(vertices.begin.at(), "more than " + std::to_string(most_vertices) + " vertices");
    }
    std::uint64_t longest = 0;
    for (const Place& place : places_) {
        longest = std::max(longest, place.lists.longest);
    }
    const std::uint64_t bytes = vertices.element.count * 3 * size_of(number_for(vertices.element)) +
                                triangles_ * 3 * sizeof(std::uint32_t) + longest * sizeof(std::uint32_t) +
                                PolygonTriangulator::scratch_bytes(longest);
    if (bytes <= input_.memory_limit) {
        list_.reserve(longest);  // growing would take more than what was counted
        return true;
    }
    return fail(input_.file.data(),
                "expands to " + std::to_string(bytes) + " bytes, more than the " + std::to_string(input_.memory_limit) +
                    " that reading it may take",
                ErrorCode::out_of_memory);
}

/// Whether there may be polygons to be cut.
template <class Numbers>
bool BodyReader<Numbers>::needs_coordinates() const {
    const Place* const faces = place_of(PlyRole::faces);
    return faces == nullptr || !faces->copied;
}

template <class Numbers>
bool BodyReader<Numbers>::read_vertices(const Place& place) {
    if constexpr (binary) {
        const bool swapped = input_.header.encoding == PlyEncoding::big_endian;
        const auto offset = vertices_in_place(place.element, offset_of(place.begin.at()));
        if (offset && (!swapped || !needs_coordinates())) {
            mesh_.swapped = swapped;
            mesh_.first_offset = *offset;
            mesh_.stride = place.element.least_row_bytes(input_.header.encoding);
            mesh_.coordinate_type = number_for(place.element);
            mesh_.vertex_count = place.element.count;
            return true;
        }
    }
    allocate_vertices(place.element, mesh_);
    if constexpr (binary) {
        if (!place.element.has_lists()) {
            copy_vertices(input_, place.element, place.begin.at(), mesh_);
            return true;
        }
    }
    return mesh_.coordinate_type == CoordinateType::f64 ? read_vertex_rows<double>(place) : read_vertex_rows<float>(place);
}

template <class Numbers>
template <class Value>
bool BodyReader<Numbers>::read_vertex_rows(const Place& place) {
    PlyRows<Numbers> rows(place.begin, place.element);
    Lookout lookout(input_.parallel);
    for (std::uint64_t row = 0; row < place.element.count; ++row) {
        lookout.pass();
        Value xyz[3];
        if (!rows.vertex(xyz)) {
            return fail(rows.at(), rows.what());
        }
        std::memcpy(mesh_.coordinates.data() + row * sizeof xyz, xyz, sizeof xyz);
    }
    return true;
}

template <class Numbers>
bool BodyReader<Numbers>::read_lists(const Place& place, PlyTriangles& triangles) {
    const PlyElement& element = place.element;
    if (place.copied) {
        triangles.use(3 * element.count);
        return true;
    }
    PlyRows<Numbers> rows(place.begin, element);
    Lookout lookout(input_.parallel);
    for (std::uint64_t row = 0; row < element.count; ++row) {
        lookout.pass(1 + list_.size());
        const char* const begin = rows.numbers().at();
        if (!rows.indices(mesh_.vertex_count, list_)) {
            return fail(rows.at(), rows.what());
        }
        if (!(element.role == PlyRole::strips ? triangles.add_strips(list_) : triangles.add_face(list_))) {
            return fail(begin, short_name(element.name) + " " + std::to_string(row) + ": " + triangles.why());
        }
    }
    return true;
}

template <class Numbers>
auto BodyReader<Numbers>::place_of(PlyRole role) const -> const Place* {
    const auto found =
        std::find_if(places_.begin(), places_.end(), [role](const Place& place) { return place.element.role == role; });
    return found == places_.end() ? nullptr : &*found;
}

template <class Numbers>
bool BodyReader<Numbers>::fail(const char* at, const std::string& what, ErrorCode code) {
    problem_ = {offset_of(at), what, code};
    return false;
}

}  // namespace

CoordinateType number_for(const PlyElement& vertices) noexcept {
    const bool wide = std::any_of(vertices.properties.begin(), vertices.properties.end(), [](const PlyProperty& p) {
        return p.use != PlyUse::nothing &&
               (p.type == PlyType::float64 || p.type == PlyType::int32 || p.type == PlyType::uint32);
    });
    return wide ? CoordinateType::f64 : CoordinateType::f32;
}

void allocate_vertices(const PlyElement& vertices, PlyMesh& mesh) {
    mesh.coordinate_type = number_for(vertices);
    mesh.stride = 3 * size_of(mesh.coordinate_type);
    mesh.first_offset = 0;
    mesh.vertex_count = vertices.count;
    mesh.coordinates.resize_discarding(vertices.count * mesh.stride);
}

bool read_ply_body(const PlyInput& input, PlyMesh& mesh, PlyProblem& problem) {
    const char* const begin = input.file.data() + input.header.body;
    const char* const end = input.file.data() + input.file.size();
    if (input.header.encoding != PlyEncoding::ascii) {
        const bool swapped = input.header.encoding == PlyEncoding::big_endian;
        return BodyReader<BinaryNumbers>(input, mesh, problem).read({begin, end, swapped});
    }
    // From number to number, words that no property takes would be read as the next row.
    return read_ply_lines(input, mesh) || read_ply_long_lines(input, mesh) ||
           BodyReader<AsciiNumbers>(input, mesh, problem).read({begin, end});
}

}  // namespace lamella
