#include "io/read/vtk/vtk_triangles.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>

namespace lamella {

namespace {

constexpr std::size_t grain = std::size_t{1} << 14;  // cells
constexpr std::uint64_t counted_numbers = 4;         // of a triangle in a counted array

template <bool big_endian>
std::uint32_t load_word(const std::byte* at) {
    std::uint32_t word = 0;
    std::memcpy(&word, at, sizeof word);
    return big_endian ? __builtin_bswap32(word) : word;
}

/// Writes three indices a cell. False: some cell has another number of corners, or a corner that is no point.
template <bool big_endian>
bool copy_counted(const CellArray& array, std::uint64_t first, std::uint64_t count, std::uint32_t* out) {
    constexpr std::size_t word_bytes = sizeof(std::uint32_t);
    const std::byte* cell = array.corners.data + first * counted_numbers * word_bytes;
    std::array<std::uint32_t, 3> largest{};  // by corner, as each would otherwise wait for the one before
    std::uint32_t differences = 0;
    for (std::uint64_t i = 0; i < count; ++i, cell += counted_numbers * word_bytes, out += 3) {
        differences |= load_word<big_endian>(cell) ^ 3U;
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const std::uint32_t point = load_word<big_endian>(cell + (1 + corner) * word_bytes);
            largest[corner] = std::max(largest[corner], point);
            out[corner] = point + array.first_point;
        }
    }
    return differences == 0 && *std::max_element(largest.begin(), largest.end()) < array.point_count;
}

/// Whether these cells end after three corners each.
bool end_after_three(const CellArray& array, std::uint64_t first, std::uint64_t count) {
    std::array<std::uint64_t, 512> ends;
    std::uint64_t differences = 0;
    for (std::uint64_t done = 0; done < count; done += ends.size()) {
        const std::uint64_t part = std::min<std::uint64_t>(ends.size(), count - done);
        decode_integers(array.ends, first + done, part, ends.data());
        for (std::uint64_t i = 0; i < part; ++i) {
            differences |= ends[i] ^ 3 * (first + done + i + 1);
        }
    }
    return differences == 0;
}

bool copy_ended(const CellArray& array, std::uint64_t first, std::uint64_t count, std::uint32_t* out) {
    if (!end_after_three(array, first, count) ||
        decode_indices(array.corners, 3 * first, 3 * count, out) >= array.point_count) {
        return false;
    }
    if (array.first_point != 0) {
        std::for_each(out, out + 3 * count, [&array](std::uint32_t& point) { point += array.first_point; });
    }
    return true;
}

bool copy(const CellArray& array, const Parallel& parallel, std::uint32_t* out) {
    std::atomic<bool> good{true};
    parallel.run_ranges(array.cells, grain, [&](std::size_t begin, std::size_t end, int) {
        const auto copy_range =
            array.counted ? (array.corners.big_endian ? copy_counted<true> : copy_counted<false>) : copy_ended;
        if (good.load(std::memory_order_relaxed) && !copy_range(array, begin, end - begin, out + 3 * begin)) {
            good.store(false, std::memory_order_relaxed);
        }
    });
    return good;
}

}  // namespace

bool copy_triangles(VtkFile& file, std::span<const CellArray> arrays, MeshFile& mesh) {
    std::uint64_t triangles = 0;
    for (const CellArray& array : arrays) {
        const std::uint64_t numbers = array.counted ? counted_numbers : 3;
        if ((array.kind != CellKind::polygons && array.cells > 0) || array.corners.count % numbers != 0 ||
            array.corners.count / numbers != array.cells) {
            return false;
        }
        triangles += array.cells;
    }
    constexpr std::uint64_t triangle_bytes = 3 * sizeof(std::uint32_t);
    if (triangles == 0 || !file.budget.take(triangles, triangle_bytes)) {
        return false;
    }
    mesh.indices = Array<std::uint32_t>(file.source.memory());
    mesh.indices.resize_discarding(3 * triangles);
    std::uint32_t* out = mesh.indices.data();
    for (const CellArray& array : arrays) {
        if (!copy(array, file.source.parallel(), out)) {
            mesh.indices = Array<std::uint32_t>();
            file.budget.give_back(triangles * triangle_bytes);
            return false;
        }
        out += 3 * array.cells;
    }
    mesh.triangle_count = triangles;
    return true;
}

}  // namespace lamella
