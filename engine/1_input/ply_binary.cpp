#include "1_input/ply_binary.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cassert>
#include <cstring>
#include <type_traits>

#include "1_input/ply_numbers.hpp"

namespace lamella {

namespace {

constexpr std::size_t grain = std::size_t{1} << 14;  // rows
static_assert(std::endian::native == std::endian::little, "the numbers of little-endian files are used where they lie");

bool is_swapped(const PlyHeader& header) {
    return header.encoding == PlyEncoding::big_endian;
}

/// Of a property in rows whose lists before it are empty.
std::size_t offset_in_row(const PlyElement& element, PlyUse use) {
    std::size_t offset = 0;
    for (const PlyProperty& property : element.properties) {
        if (property.use == use) {
            break;
        }
        offset += size_of(property.is_list ? property.count_type : property.type);
    }
    return offset;
}

std::size_t fixed_row_bytes(const PlyElement& element) {
    return element.least_row_bytes(PlyEncoding::little_endian);
}

/// One coordinate of `count` vertices.
template <class Value>
void copy_axis(const PlyProperty& axis, bool swapped, const char* from, std::size_t stride, std::size_t count,
               std::byte* to) {
    with_type(axis.type, [&](auto sample) {
        for (std::size_t i = 0; i < count; ++i) {
            const auto value = static_cast<Value>(load_number<decltype(sample)>(from + i * stride, swapped));
            std::memcpy(to + 3 * sizeof(Value) * i, &value, sizeof(Value));
        }
    });
}

/// Three indices a row. False: some are not below `vertex_count`; a negative one is not, either.
template <class Index>
bool copy_indices(const char* from, std::size_t stride, std::size_t count, bool swapped, std::uint64_t vertex_count,
                  std::uint32_t* to) {
    std::uint64_t largest = 0;
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const auto index = load_number<Index>(from + i * stride + corner * sizeof(Index), swapped);
            largest = std::max(largest, static_cast<std::uint64_t>(static_cast<std::int64_t>(index)));
            to[3 * i + corner] = static_cast<std::uint32_t>(index);  // NOLINT(bugprone-signed-char-misuse): a number
        }
    }
    return largest < vertex_count;
}

}  // namespace

std::optional<std::size_t> vertices_in_place(const PlyHeader& header, const PlyElement& vertices, std::size_t offset) {
    const Number number = number_for(vertices);
    const PlyType type = number == Number::f64 ? PlyType::float64 : PlyType::float32;
    const std::size_t x = offset_in_row(vertices, PlyUse::x);
    const bool packed = offset_in_row(vertices, PlyUse::y) == x + size_of(type) &&
                        offset_in_row(vertices, PlyUse::z) == x + 2 * size_of(type);
    const bool of_type = std::all_of(vertices.properties.begin(), vertices.properties.end(),
                                     [type](const PlyProperty& p) { return p.use == PlyUse::nothing || p.type == type; });
    if (is_swapped(header) || vertices.has_lists() || !packed || !of_type) {
        return std::nullopt;
    }
    return offset + x;
}

void copy_vertices(const PlyInput& input, const PlyElement& vertices, const char* rows, const PlyMesh& mesh) {
    assert(!vertices.has_lists());
    const std::size_t row_bytes = fixed_row_bytes(vertices);
    input.parallel.run_ranges(vertices.count, grain, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto use = static_cast<PlyUse>(axis);
            const char* const from = rows + begin * row_bytes + offset_in_row(vertices, use);
            std::byte* const to = const_cast<std::byte*>(mesh.coordinates.data()) + begin * mesh.stride;
            if (mesh.number == Number::f64) {
                copy_axis<double>(vertices.used(use), is_swapped(input.header), from, row_bytes, end - begin,
                                  to + axis * sizeof(double));
            } else {
                copy_axis<float>(vertices.used(use), is_swapped(input.header), from, row_bytes, end - begin,
                                 to + axis * sizeof(float));
            }
        }
    });
}

std::optional<TriangleRows> as_triangle_rows(const PlyInput& input, const PlyElement& faces, const char* begin) {
    const auto lists = std::count_if(faces.properties.begin(), faces.properties.end(),
                                     [](const PlyProperty& property) { return property.is_list; });
    const PlyProperty& list = faces.used(PlyUse::indices);
    const auto left = static_cast<std::uint64_t>(input.file.data() + input.file.size() - begin);
    const TriangleRows rows = {begin, fixed_row_bytes(faces) + 3 * size_of(list.type),
                               offset_in_row(faces, PlyUse::indices)};
    if (lists != 1 || list.type >= PlyType::float32 || faces.count > left / rows.stride) {
        return std::nullopt;
    }
    std::atomic<bool> uniform{true};
    with_type(list.count_type, [&](auto sample) {
        using Count = decltype(sample);
        input.parallel.run_ranges(faces.count, grain, [&](std::size_t first, std::size_t last, int) {
            bool all = true;
            for (std::size_t i = first; i < last; ++i) {
                all &= load_number<Count>(begin + i * rows.stride + rows.list, is_swapped(input.header)) == Count{3};
            }
            if (!all) {
                uniform.store(false, std::memory_order_relaxed);
            }
        });
    });
    return uniform ? std::optional(rows) : std::nullopt;
}

bool copy_triangles(const PlyInput& input, const PlyElement& faces, const TriangleRows& rows, std::uint64_t vertex_count,
                    std::uint32_t* indices) {
    const PlyProperty& list = faces.used(PlyUse::indices);
    const char* const first_index = rows.begin + rows.list + size_of(list.count_type);
    std::atomic<bool> in_range{true};
    with_type(list.type, [&](auto sample) {
        if constexpr (std::is_integral_v<decltype(sample)>) {
            input.parallel.run_ranges(faces.count, grain, [&](std::size_t begin, std::size_t end, int) {
                if (!copy_indices<decltype(sample)>(first_index + begin * rows.stride, rows.stride, end - begin,
                                                    is_swapped(input.header), vertex_count, indices + 3 * begin)) {
                    in_range.store(false, std::memory_order_relaxed);
                }
            });
        }
    });
    return in_range;
}

}  // namespace lamella
