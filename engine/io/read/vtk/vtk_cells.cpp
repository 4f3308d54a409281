#include "io/read/faces.hpp"
#include "io/read/vtk/vtk_file.hpp"

namespace lamella {

namespace {

constexpr std::uint64_t triangle_bytes = 3 * sizeof(std::uint32_t);

/// A number of a counted array.
std::uint32_t word_of(const NumberArray& words, std::uint64_t index) {
    return load_number<std::uint32_t>(words.data + index * sizeof(std::uint32_t), words.big_endian);
}

// --- The usual case: triangles only, which are copied and checked in one pass.

constexpr std::size_t cell_grain = std::size_t{1} << 14;
constexpr std::uint64_t counted_numbers = 4;  // of a triangle in a counted array

/// Writes three indices a cell. False: some cell has another number of corners, or a corner that is no point.
template <bool big_endian>
bool copy_counted(const CellArray& array, std::uint64_t first, std::uint64_t count, std::uint32_t* out) {
    constexpr std::size_t word_bytes = sizeof(std::uint32_t);
    const std::byte* cell = array.corners.data + first * counted_numbers * word_bytes;
    std::array<std::uint32_t, 3> largest{};  // by corner, as each would otherwise wait for the one before
    std::uint32_t differences = 0;
    for (std::uint64_t i = 0; i < count; ++i, cell += counted_numbers * word_bytes, out += 3) {
        differences |= load_number<std::uint32_t>(cell, big_endian) ^ 3U;
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const auto point = load_number<std::uint32_t>(cell + (1 + corner) * word_bytes, big_endian);
            largest[corner] = std::max(largest[corner], point);
            out[corner] = point + array.first_point;
        }
    }
    return differences == 0 && *std::max_element(largest.begin(), largest.end()) < array.point_count;
}

bool copy_ended(const CellArray& array, std::uint64_t first, std::uint64_t count, std::uint32_t* out) {
    std::array<std::uint64_t, 512> ends;
    std::uint64_t differences = 0;
    for (std::uint64_t done = 0; done < count; done += ends.size()) {
        const std::uint64_t part = std::min<std::uint64_t>(ends.size(), count - done);
        decode_integers(array.ends, first + done, part, ends.data());
        for (std::uint64_t i = 0; i < part; ++i) {
            differences |= ends[i] ^ 3 * (first + done + i + 1);
        }
    }
    return differences == 0 && decode_points(array, 3 * first, 3 * count, out);
}

bool copy_triangles(const CellArray& array, const Parallel& parallel, std::uint32_t* out) {
    const auto copy = !array.counted ? copy_ended : array.corners.big_endian ? copy_counted<true> : copy_counted<false>;
    std::atomic<bool> good{true};
    parallel.run_ranges(array.cells, cell_grain, [&](std::size_t begin, std::size_t end, int) {
        if (good.load(std::memory_order_relaxed) && !copy(array, begin, end - begin, out + 3 * begin)) {
            good.store(false, std::memory_order_relaxed);
        }
    });
    return good;
}

/// Gives `mesh` the triangles of all `arrays`, if their cells are triangles of existing points. False: they are not, or do
/// not fit into memory; the budget is then as before.
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
    if (triangles == 0 || !file.budget.try_take(triangles, triangle_bytes)) {
        return false;
    }
    mesh.indices = Array<std::uint32_t>(file.source.memory());
    mesh.indices.resize_discarding(3 * triangles);
    std::uint32_t* out = mesh.indices.data();
    for (const CellArray& array : arrays) {
        if (!copy_triangles(array, file.source.parallel(), out)) {
            mesh.indices = Array<std::uint32_t>();
            file.budget.give_back(triangles * triangle_bytes);
            return false;
        }
        out += 3 * array.cells;
    }
    mesh.triangle_count = triangles;
    return true;
}

// --- All other cells.

/// Cells that one task reads.
struct Block {
    const CellArray* array = nullptr;
    std::uint64_t first_cell = 0;
    std::uint64_t at = 0;  ///< where it begins in the array's corners
};

/// Reads cells of an array one after the other, as each begins where the one before ends.
class CellReader {
public:
    CellReader(VtkFile& file, const CellArray& array)
        : file_(file), array_(array), name_(array.name), lookout_(file.source.parallel()) {}

    /// Looks where all cells begin, and appends the blocks in which their faces can be read. Throws errors.
    void cut(std::vector<Block>& blocks, MeshFile& mesh) {
        std::uint64_t small = 0;
        std::uint64_t first_small = 0;
        for (std::uint64_t cell = 0; cell < array_.cells; ++cell) {
            if (cell % cells_a_block == 0) {
                blocks.push_back({&array_, cell, at_});
            }
            lookout_.pass();
            const std::uint64_t count = corners_of(cell);
            at_ += count;
            if (count < 3 && small++ == 0) {
                first_small = cell;
            }
        }
        if (at_ != array_.corners.count) {
            const std::string count = std::to_string(at_);
            const std::string all = std::to_string(array_.corners.count);
            throw file_.error_at(
                array_.corners, at_,
                "the " + std::to_string(array_.cells) + " cells of " + name_ +
                    (array_.counted ? " take " + count + " numbers, not the " + all + " counted"
                                    : " have " + count + " corners, not the " + all + " of their connectivity"));
        }
        if (small > 0) {
            mesh.warnings.push_back(file_.source.name() + ": ignored " + std::to_string(small) + " cells of " + name_ +
                                    " with fewer than three corners, the first being cell " + std::to_string(first_small));
        }
    }

    /// Adds the faces of a block that cut() has made. Throws errors.
    void read(const Block& block, FaceList& faces) {
        at_ = block.at;
        const std::uint64_t end = std::min(array_.cells, block.first_cell + cells_a_block);
        for (std::uint64_t cell = block.first_cell; cell < end; ++cell) {
            const std::uint64_t count = corners_of(cell);
            read_face(count, faces);
            at_ += count;
        }
    }

private:
    static constexpr std::uint64_t cells_a_block = 1 << 14;

    /// How many corners the cell has; at_ is where they begin.
    std::uint64_t corners_of(std::uint64_t cell) { return array_.counted ? counted_corners(cell) : ended_corners(cell); }

    /// The number of the cell's corners, which are counted right before them: moves past it.
    std::uint64_t counted_corners(std::uint64_t cell) {
        const NumberArray& words = array_.corners;
        const std::uint64_t count = at_ < words.count ? word_of(words, at_) : 0;
        if (at_ + count >= words.count) {
            throw file_.error_at(words, at_,
                                 "cell " + std::to_string(cell) + " of " + name_ + " does not lie within the " +
                                     std::to_string(words.count) + " numbers that " + name_ + " counts");
        }
        ++at_;
        return count;
    }

    std::uint64_t ended_corners(std::uint64_t cell) {
        if (cell % ends_.size() == 0) {
            decode_integers(array_.ends, cell, std::min<std::uint64_t>(ends_.size(), array_.cells - cell), ends_.data());
        }
        const std::uint64_t end = ends_[cell % ends_.size()];
        if (end < at_ || end > array_.corners.count) {
            throw file_.error_at(array_.ends, cell,
                                 "cell " + std::to_string(cell) + " of " + name_ + " ends at " +
                                     std::to_string(static_cast<std::int64_t>(end)) + ", which is not from " +
                                     std::to_string(at_) + " to " + std::to_string(array_.corners.count));
        }
        return end - at_;
    }

    /// Of so many corners from at_ on.
    void read_face(std::uint64_t count, FaceList& faces) {
        lookout_.pass(1 + count);
        corners_.resize(count);
        if (!decode_points(array_, at_, count, corners_.data())) {
            refuse_point();
        }
        if (array_.kind == CellKind::polygons) {
            return faces.add(corners_, at_);
        }
        for (std::size_t i = 2; i < corners_.size(); ++i) {
            const std::size_t odd = i % 2;  // every other triangle is listed in reverse
            faces.add(std::array{corners_[i - 2 + odd], corners_[i - 1 - odd], corners_[i]}, at_);
        }
    }

    /// The first from at_ on that does not exist.
    [[noreturn]] void refuse_point() const {
        std::uint64_t point = 0;
        std::uint64_t index = at_;
        for (;; ++index) {
            decode_integers(array_.corners, index, 1, &point);
            if (point >= array_.point_count) {
                break;
            }
        }
        throw file_.error_at(array_.corners, index,
                             "point " + std::to_string(static_cast<std::int64_t>(point)) + " of " + name_ +
                                 " does not exist: there are " + std::to_string(array_.point_count));
    }

    VtkFile& file_;
    const CellArray& array_;
    std::string name_;
    Lookout lookout_;
    std::uint64_t at_ = 0;  // in the array's corners
    std::array<std::uint64_t, 512> ends_{};
    std::vector<std::uint32_t> corners_;
};

}  // namespace

void cut_cells(VtkFile& file, std::span<const CellArray> arrays, MeshFile& mesh) {
    if (copy_triangles(file, arrays, mesh)) {
        return;
    }
    if (mesh.vertex_count >= most_vertices) {
        file.source.refuse(ErrorCode::malformed_mesh, "has too many vertices to be numbered beside polygons");
    }
    std::vector<Block> blocks;
    for (const CellArray& array : arrays) {
        CellReader(file, array).cut(blocks, mesh);
    }
    const Parallel& parallel = file.source.parallel();
    std::vector<FaceList> lists = parse_faces(blocks.size(), file.budget, parallel, [&](std::size_t i, FaceList& faces) {
        CellReader(file, *blocks[i].array).read(blocks[i], faces);
    });
    give_faces(
        lists, coordinates_of(mesh), file.budget, parallel,
        [&](std::size_t list, std::uint64_t place, const std::string& what) {
            return file.error_at(blocks[list].array->corners, place, what);
        },
        mesh);
    if (mesh.triangle_count == 0) {
        file.source.refuse(ErrorCode::empty_mesh, "holds no triangles");
    }
}

}  // namespace lamella
