#include <cassert>

#include "io/read/ply/ply.hpp"

namespace lamella {

namespace {

template <class Value>
void copy_values(const char* from, bool swapped, std::size_t stride, std::size_t count, std::byte* to,
                 std::size_t to_stride) {
    for (std::size_t i = 0; i < count; ++i, from += stride, to += to_stride) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const Value value = load_number<Value>(from + axis * sizeof(Value), swapped);
            std::memcpy(to + axis * sizeof value, &value, sizeof value);
        }
    }
}

/// The three indices of each row, after their number. False: some row has not three, or some index is not below
/// `vertex_count`; a negative one is not, either.
template <class Count, class Index>
bool copy_indices(const char* from, bool swapped, std::size_t stride, std::size_t count, std::uint64_t vertex_count,
                  std::uint32_t* to) {
    std::array<std::uint32_t, 3> largest{};  // by corner, as each would otherwise wait for the one before
    bool three = true;
    for (std::size_t i = 0; i < count; ++i, from += stride, to += 3) {
        three &= load_number<Count>(from, swapped) == Count{3};
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const auto index = load_number<Index>(from + sizeof(Count) + corner * sizeof(Index), swapped);
            to[corner] = static_cast<std::uint32_t>(index);  // NOLINT(bugprone-signed-char-misuse): a number
            largest[corner] = std::max(largest[corner], to[corner]);
        }
    }
    return three && *std::max_element(largest.begin(), largest.end()) < vertex_count;
}

}  // namespace

void copy_coordinates(Number number, bool swapped, const void* from, std::size_t stride, std::size_t count, std::byte* to,
                      std::size_t to_stride) {
    // As integers: a float that is no number may change on the way through a register.
    const auto copy = number == Number::f64 ? copy_values<std::uint64_t> : copy_values<std::uint32_t>;
    copy(static_cast<const char*>(from), swapped, stride, count, to, to_stride);
}

bool has_packed_coordinates(const PlyElement& vertices) {
    const NumberType type = number_for(vertices) == Number::f64 ? NumberType::float64 : NumberType::float32;
    const std::size_t x = vertices.row_bytes(PlyUse::x);
    return vertices.row_bytes(PlyUse::y) == x + size_of(type) && vertices.row_bytes(PlyUse::z) == x + 2 * size_of(type) &&
           !vertices.has_lists() &&
           std::all_of(vertices.properties.begin(), vertices.properties.end(), [type](const PlyProperty& p) {
               return p.use == PlyUse::nothing || (p.use != PlyUse::scalar && p.type == type);
           });
}

std::size_t triangle_row_bytes(const PlyElement& faces) {
    const auto lists = std::count_if(faces.properties.begin(), faces.properties.end(),
                                     [](const PlyProperty& property) { return property.is_list; });
    const PlyProperty& list = faces.used(PlyUse::indices);
    return lists == 1 && is_integer(list.type) ? faces.row_bytes() + 3 * size_of(list.type) : 0;
}

bool copy_triangle_rows(const PlyElement& faces, bool swapped, const char* rows, std::size_t count,
                        std::uint64_t vertex_count, std::uint32_t* to) {
    assert(vertex_count <= most_ply_vertices);
    const PlyProperty& list = faces.used(PlyUse::indices);
    const std::size_t stride = triangle_row_bytes(faces);
    const char* const lists = rows + faces.row_bytes(PlyUse::indices);
    return with_type(list.count_type, [&](auto length) {
        return with_type(list.type, [&](auto index) {
            if constexpr (std::is_integral_v<decltype(index)>) {
                return copy_indices<decltype(length), decltype(index)>(lists, swapped, stride, count, vertex_count, to);
            }
            return false;
        });
    });
}

}  // namespace lamella
