#include "io/read/ply/ply.hpp"

#include <cassert>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace lamella {

namespace {

constexpr std::size_t grain = std::size_t{1} << 14;  // rows
constexpr std::size_t rows_in_cache = 512;

std::size_t fixed_row_bytes(const PlyElement& element) {
    return element.least_row_bytes(PlyEncoding::little_endian);
}

/// Three numbers a row, of the size of Bits.
template <class Bits>
void swap_rows(std::byte* row, std::size_t stride, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i, row += stride) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            std::byte* const at = row + axis * sizeof(Bits);
            const Bits swapped = load_number<Bits>(reinterpret_cast<const char*>(at), true);
            std::memcpy(at, &swapped, sizeof swapped);
        }
    }
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
    std::array<std::uint32_t, 3> largest{};  // by corner, as each would otherwise wait for the one before
    for (std::size_t i = 0; i < count; ++i, from += stride, to += 3) {
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const auto index = load_number<Index>(from + corner * sizeof(Index), swapped);
            to[corner] = static_cast<std::uint32_t>(index);  // NOLINT(bugprone-signed-char-misuse): a number
            largest[corner] = std::max(largest[corner], to[corner]);
        }
    }
    return *std::max_element(largest.begin(), largest.end()) < vertex_count;
}

#ifdef __SSE2__
/// Bytes of each number in the opposite order.
__m128i swapped_bytes(__m128i numbers) noexcept {
    const __m128i pairs = _mm_or_si128(_mm_slli_epi16(numbers, 8), _mm_srli_epi16(numbers, 8));
    return _mm_shufflehi_epi16(_mm_shufflelo_epi16(pairs, _MM_SHUFFLE(2, 3, 0, 1)), _MM_SHUFFLE(2, 3, 0, 1));
}

/// The rows of nearly all files, in one pass: the count in a byte, the indices in 32 bits. Up to 2^31 vertices an index that
/// is out of range is larger than the last as a signed number, or negative: the signs tell both.
template <bool swapped>
bool copy_usual_rows(const char* lists, std::size_t stride, std::size_t count, std::uint64_t vertex_count,
                     std::uint32_t* to) {
    const __m128i last_vertex = _mm_set1_epi32(static_cast<std::int32_t>(static_cast<std::int64_t>(vertex_count) - 1));
    __m128i signs = _mm_setzero_si128();
    unsigned not_three = 0;
    for (std::size_t i = 0; i < count; ++i, lists += stride, to += 3) {
        not_three |= static_cast<unsigned char>(*lists) ^ 3U;
        std::int32_t third;
        std::memcpy(&third, lists + 9, sizeof third);
        const __m128i two = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(lists + 1));
        __m128i indices = _mm_unpacklo_epi64(two, _mm_cvtsi32_si128(third));
        indices = swapped ? swapped_bytes(indices) : indices;
        signs = _mm_or_si128(signs, _mm_or_si128(indices, _mm_cmpgt_epi32(indices, last_vertex)));
        _mm_storel_epi64(reinterpret_cast<__m128i*>(to), indices);
        to[2] = static_cast<std::uint32_t>(_mm_cvtsi128_si32(_mm_unpackhi_epi64(indices, indices)));
    }
    constexpr int three_numbers = 7;
    return not_three == 0 && (_mm_movemask_ps(_mm_castsi128_ps(signs)) & three_numbers) == 0;
}
#endif

/// The indices of `count` rows whose lists begin at `lists`. False: one has not three, or one that is out of range.
bool copy_rows(const PlyProperty& list, bool swapped, const char* lists, std::size_t stride, std::size_t count,
               std::uint64_t vertex_count, std::uint32_t* to) {
#ifdef __SSE2__
    if (size_of(list.count_type) == 1 && size_of(list.type) == sizeof(std::uint32_t)) {
        return swapped ? copy_usual_rows<true>(lists, stride, count, vertex_count, to)
                       : copy_usual_rows<false>(lists, stride, count, vertex_count, to);
    }
#endif
    bool three = true;
    with_type(list.count_type, [&](auto sample) {
        using Count = decltype(sample);
        for (std::size_t i = 0; i < count; ++i) {
            three &= load_number<Count>(lists + i * stride, swapped) == Count{3};
        }
    });
    return three && with_type(list.type, [&](auto sample) {
               if constexpr (std::is_integral_v<decltype(sample)>) {
                   return copy_indices<decltype(sample)>(lists + size_of(list.count_type), stride, count, swapped,
                                                         vertex_count, to);
               }
               return false;
           });
}

}  // namespace

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

std::optional<std::size_t> vertices_in_place(const PlyElement& vertices, std::size_t offset) {
    const Number number = number_for(vertices);
    const NumberType type = number == Number::f64 ? NumberType::float64 : NumberType::float32;
    const std::size_t x = offset_in_row(vertices, PlyUse::x);
    const bool packed = offset_in_row(vertices, PlyUse::y) == x + size_of(type) &&
                        offset_in_row(vertices, PlyUse::z) == x + 2 * size_of(type);
    const bool of_type = std::all_of(vertices.properties.begin(), vertices.properties.end(),
                                     [type](const PlyProperty& p) { return p.use == PlyUse::nothing || p.type == type; });
    if (vertices.has_lists() || !packed || !of_type) {
        return std::nullopt;
    }
    return offset + x;
}

void swap_vertices(MeshFile& mesh, const Parallel& parallel) {
    parallel.run_ranges(mesh.vertex_count, grain, [&](std::size_t begin, std::size_t end, int) {
        std::byte* const first = mesh.bytes.data() + mesh.first_offset + begin * mesh.stride;
        if (mesh.vertex_type == Number::f64) {
            swap_rows<std::uint64_t>(first, mesh.stride, end - begin);
        } else {
            swap_rows<std::uint32_t>(first, mesh.stride, end - begin);
        }
    });
}

void copy_vertices(const PlyInput& input, const PlyElement& vertices, const char* rows, MeshFile& mesh) {
    assert(!vertices.has_lists());
    const std::size_t row_bytes = fixed_row_bytes(vertices);
    input.parallel().run_ranges(vertices.count, grain, [&](std::size_t begin, std::size_t end, int) {
        copy_vertex_rows(vertices, input.swapped(), rows + begin * row_bytes, end - begin, mesh.vertex_type,
                         mesh.bytes.data() + begin * mesh.stride);
    });
}

void copy_vertex_rows(const PlyElement& vertices, bool swapped, const char* rows, std::size_t count, Number number,
                      std::byte* to) {
    const std::size_t row_bytes = fixed_row_bytes(vertices);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto use = static_cast<PlyUse>(axis);
        const char* const from = rows + offset_in_row(vertices, use);
        if (number == Number::f64) {
            copy_axis<double>(vertices.used(use), swapped, from, row_bytes, count, to + axis * sizeof(double));
        } else {
            copy_axis<float>(vertices.used(use), swapped, from, row_bytes, count, to + axis * sizeof(float));
        }
    }
}

std::optional<std::size_t> triangle_row_bytes(const PlyElement& faces) {
    const auto lists = std::count_if(faces.properties.begin(), faces.properties.end(),
                                     [](const PlyProperty& property) { return property.is_list; });
    const PlyProperty& list = faces.used(PlyUse::indices);
    if (lists != 1 || !is_integer(list.type)) {
        return std::nullopt;
    }
    return fixed_row_bytes(faces) + 3 * size_of(list.type);
}

bool copy_triangle_rows(const PlyElement& faces, bool swapped, const char* rows, std::size_t count,
                        std::uint64_t vertex_count, std::uint32_t* to) {
    assert(vertex_count <= most_ply_vertices);
    return copy_rows(faces.used(PlyUse::indices), swapped, rows + offset_in_row(faces, PlyUse::indices),
                     *triangle_row_bytes(faces), count, vertex_count, to);
}

bool copy_triangle_rows(const PlyInput& input, const PlyElement& faces, const char* rows, MemoryBudget& budget,
                        Array<std::uint32_t>& indices) {
    const std::size_t stride = triangle_row_bytes(faces).value_or(0);
    const std::uint64_t vertex_count = input.header.element_of(PlyRole::vertices)->count;
    const auto left = static_cast<std::uint64_t>(input.file.data() + input.file.size() - rows);
    constexpr std::size_t triangle_bytes = 3 * sizeof(std::uint32_t);
    if (stride == 0 || faces.count > left / stride || vertex_count > most_ply_vertices ||
        !budget.try_take(faces.count, triangle_bytes)) {
        return false;
    }
    indices = Array<std::uint32_t>(input.source.memory());
    indices.resize_discarding(3 * faces.count);
    std::atomic<bool> good{true};
    input.parallel().run_ranges(faces.count, grain, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t row = begin; row < end && good.load(std::memory_order_relaxed); row += rows_in_cache) {
            const std::size_t count = std::min(rows_in_cache, end - row);
            if (!copy_triangle_rows(faces, input.swapped(), rows + row * stride, count, vertex_count,
                                    indices.data() + 3 * row)) {
                good.store(false, std::memory_order_relaxed);
            }
        }
    });
    if (!good) {
        indices = Array<std::uint32_t>();
        budget.give_back(faces.count * triangle_bytes);
    }
    return good;
}

}  // namespace lamella
