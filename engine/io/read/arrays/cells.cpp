#include <atomic>

#include "io/read/arrays/array_file.hpp"
#include "io/read/faces.hpp"

namespace lamella {

namespace {

// --- The usual case: triangles only, which are copied and checked in one pass.

constexpr std::size_t cell_grain = std::size_t{1} << 14;
constexpr std::uint64_t triangle_bytes = 3 * sizeof(std::uint32_t);

/// How many numbers of `corners` a triangle takes.
std::uint64_t triangle_numbers(const CellArray& array) {
    return array.counted ? 4 : 3;
}

/// Writes three indices a cell; a cell has `step` numbers, before them perhaps that of its corners. False: some cell has
/// another number of corners, or a corner that is no point.
template <std::uint64_t step, class Numbers>
bool copy_corners(const Numbers& number, std::uint64_t count, const CellArray& array, std::uint32_t* out) {
    std::array<std::uint64_t, 3> largest{};  // by corner, as each would otherwise wait for the one before
    std::uint64_t differences = 0;
    for (std::uint64_t i = 0; i < count; ++i, out += 3) {
        differences |= step == 3 ? 0 : to_integer(number(step * i)) ^ 3;
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const std::uint64_t point = to_integer(number(step * i + step - 3 + corner));
            largest[corner] = std::max(largest[corner], point);
            out[corner] = static_cast<std::uint32_t>(point) + array.first_point;
        }
    }
    return differences == 0 && *std::max_element(largest.begin(), largest.end()) < array.point_count;
}

bool copy_cells(const CellArray& array, std::uint64_t first, std::uint64_t count, std::uint32_t* out) {
    const bool good = array.counted || array.ends.count == 0 || use_numbers(array.ends, first, [&](auto end) {
                          std::uint64_t differences = 0;
                          for (std::uint64_t i = 0; i < count; ++i) {
                              differences |= to_integer(end(i)) ^ 3 * (first + i + 1);
                          }
                          return differences == 0;
                      });
    return good && use_numbers(array.corners, triangle_numbers(array) * first, [&](auto number) {
               return array.counted ? copy_corners<4>(number, count, array, out)
                                    : copy_corners<3>(number, count, array, out);
           });
}

/// Gives `mesh` the triangles of all `arrays`, if their cells are triangles of existing points. False: they are not, or do
/// not fit into memory; the budget is then as before.
bool copy_triangles(ArrayFile& file, std::span<const CellArray> arrays, MeshFile& mesh) {
    std::uint64_t triangles = 0;
    for (const CellArray& array : arrays) {
        const std::uint64_t step = triangle_numbers(array);
        if ((array.kind != CellKind::polygons && array.cells > 0) || array.corners.count % step != 0 ||
            array.corners.count / step != array.cells) {
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
    std::atomic<bool> good{true};
    for (const CellArray& array : arrays) {
        file.source.parallel().run_ranges(array.cells, cell_grain, [&](std::size_t begin, std::size_t end, int) {
            if (good.load(std::memory_order_relaxed) && !copy_cells(array, begin, end - begin, out + 3 * begin)) {
                good.store(false, std::memory_order_relaxed);
            }
        });
        out += 3 * array.cells;
    }
    if (good) {
        mesh.triangle_count = triangles;
    } else {
        mesh.indices = Array<std::uint32_t>();
        file.budget.give_back(triangles * triangle_bytes);
    }
    return good;
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
    CellReader(ArrayFile& file, const CellArray& array)
        : file_(file), array_(array), name_(array.name), pace_(pace_of(file.source.parallel())) {}

    /// Looks where all cells begin, and appends the blocks in which their faces can be read. Throws errors.
    void cut(std::vector<Block>& blocks) {
        for (std::uint64_t cell = 0; cell < array_.cells; ++cell) {
            if (cell % cell_grain == 0) {
                blocks.push_back({&array_, cell, at_});
            }
            pace_.spend(step_work);
            at_ += corners_of(cell);
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
    }

    /// Adds the faces of a block that cut() has made. Throws errors.
    void read(const Block& block, FaceList& faces) {
        at_ = block.at;
        const std::uint64_t end = std::min(array_.cells, block.first_cell + cell_grain);
        for (std::uint64_t cell = block.first_cell; cell < end; ++cell) {
            const std::uint64_t count = corners_of(cell);
            read_face(count, faces);
            at_ += count;
        }
    }

private:
    /// How many corners the cell has; at_ is then where they begin.
    std::uint64_t corners_of(std::uint64_t cell) {
        const std::uint64_t all = array_.corners.count;
        if (array_.counted) {
            const std::uint64_t count = at_ < all ? integer_at(array_.corners, at_) : 0;
            if (at_ >= all || count >= all - at_) {
                refuse_cell(cell, array_.corners, at_,
                            "does not lie within the " + std::to_string(all) + " numbers that " + name_ + " counts");
            }
            ++at_;
            return count;
        }
        const std::uint64_t end = array_.ends.count == 0 ? at_ + 3 : integer_at(array_.ends, cell);
        if (end < at_ || end > all) {
            refuse_cell(cell, array_.ends, cell,
                        "ends at " + std::to_string(static_cast<std::int64_t>(end)) + ", which is not from " +
                            std::to_string(at_) + " to " + std::to_string(all));
        }
        return end - at_;
    }

    [[noreturn]] void refuse_cell(std::uint64_t cell, const NumberArray& numbers, std::uint64_t index,
                                  const std::string& what) const {
        throw file_.error_at(numbers, index, "cell " + std::to_string(cell) + " of " + name_ + " " + what);
    }

    /// Of so many corners from at_ on.
    void read_face(std::uint64_t count, FaceList& faces) {
        pace_.spend(step_work * (1 + count));
        corners_.resize(count);
        const bool exist = use_numbers(array_.corners, at_, [&](auto number) {
            bool good = true;
            for (std::uint64_t i = 0; i < count; ++i) {
                const std::uint64_t point = to_integer(number(i));
                good &= point < array_.point_count;
                corners_[i] = static_cast<std::uint32_t>(point) + array_.first_point;
            }
            return good;
        });
        if (!exist) {
            refuse_point();
        }
        if (array_.kind == CellKind::polygons || count < 3) {
            return add_polygon(faces);
        }
        for (std::size_t i = 2; i < corners_.size(); ++i) {
            const std::size_t odd = i % 2;  // every other triangle is listed in reverse
            faces.add(std::array{corners_[i - 2 + odd], corners_[i - 1 - odd], corners_[i]}, nullptr);
        }
    }

    void add_polygon(FaceList& faces) {
        try {
            faces.add(corners_, nullptr);
        } catch (const TextError& error) {
            throw file_.error_at(array_.corners, at_, error.what);
        }
    }

    /// The first from at_ on that does not exist.
    [[noreturn]] void refuse_point() const {
        std::uint64_t index = at_;
        while (integer_at(array_.corners, index) < array_.point_count) {
            ++index;
        }
        const auto point = static_cast<std::int64_t>(integer_at(array_.corners, index));
        throw file_.error_at(array_.corners, index,
                             "point " + std::to_string(point) + " of " + name_ + " does not exist: there are " +
                                 std::to_string(array_.point_count));
    }

    ArrayFile& file_;
    const CellArray& array_;
    std::string name_;
    StopPace pace_;
    std::uint64_t at_ = 0;  // in the array's corners
    std::vector<std::uint32_t> corners_;
};

}  // namespace

void cut_cells(ArrayFile& file, std::span<const CellArray> arrays, MeshFile& mesh) {
    if (copy_triangles(file, arrays, mesh)) {
        return;
    }
    std::vector<Block> blocks;
    for (const CellArray& array : arrays) {
        CellReader(file, array).cut(blocks);
    }
    std::vector<FaceList> lists =
        parse_faces(blocks.size(), coordinates_of(mesh), file.budget, file.source.parallel(),
                    [&](std::size_t i, FaceList& faces) { CellReader(file, *blocks[i].array).read(blocks[i], faces); });
    give_faces(lists, file.budget, file.source, file.text, mesh);
}

}  // namespace lamella
