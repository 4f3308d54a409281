#include "io/read/vtk/vtk_file.hpp"

#include "io/read/faces.hpp"

namespace lamella {

namespace {

constexpr std::uint64_t triangle_bytes = 3 * sizeof(std::uint32_t);

// --- The usual case: triangles only, which are copied and checked in one pass.

constexpr std::size_t grain = std::size_t{1} << 14;  // cells
constexpr std::uint64_t counted_numbers = 4;         // of a triangle in a counted array

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

/// True if these cells end after three corners each.
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

bool copy_triangles(const CellArray& array, const Parallel& parallel, std::uint32_t* out) {
    const auto copy = !array.counted ? copy_ended : array.corners.big_endian ? copy_counted<true> : copy_counted<false>;
    std::atomic<bool> good{true};
    parallel.run_ranges(array.cells, grain, [&](std::size_t begin, std::size_t end, int) {
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
    std::uint64_t cells = 0;
    std::uint64_t first_number = 0;  ///< in the corners
};

/// Shares out the cells of an array, checked one after the other.
class Plan {
public:
    Plan(const CellArray& array, std::vector<Block>& blocks) : array_(array), blocks_(blocks) {}

    void add(std::uint64_t cell, std::uint64_t corners, std::uint64_t first_number) {
        constexpr std::uint64_t most = std::uint64_t{1} << 15;  // numbers or cells, unless a single cell has more
        if (cell == 0 || first_number - blocks_.back().first_number >= most || blocks_.back().cells >= most) {
            blocks_.push_back({&array_, cell, 0, first_number});
        }
        ++blocks_.back().cells;
        if (corners < 3 && without_area_++ == 0) {
            first_without_area_ = cell;
        }
    }

    void warn(const FileSource& source, MeshFile& mesh) const {
        if (without_area_ > 0) {
            mesh.warnings.push_back(source.name() + ": ignored " + std::to_string(without_area_) + " cells of " +
                                    std::string(array_.name) + " with fewer than three corners, the first being cell " +
                                    std::to_string(first_without_area_));
        }
    }

private:
    const CellArray& array_;
    std::vector<Block>& blocks_;
    std::uint64_t without_area_ = 0;
    std::uint64_t first_without_area_ = 0;
};

/// A number of a counted array.
std::uint32_t word_of(const NumberArray& words, std::uint64_t index) {
    return load_number<std::uint32_t>(words.data + index * sizeof(std::uint32_t), words.big_endian);
}

std::string cell_name(const CellArray& array, std::uint64_t cell) {
    return "cell " + std::to_string(cell) + " of " + std::string(array.name);
}

void plan_counted(const VtkFile& file, const CellArray& array, Plan& plan) {
    const NumberArray& words = array.corners;
    std::uint64_t at = 0;
    Lookout lookout(file.source.parallel());
    for (std::uint64_t cell = 0; cell < array.cells; ++cell) {
        lookout.pass();
        const std::uint64_t corners = at < words.count ? word_of(words, at) : 0;
        if (at + corners >= words.count) {
            file.fail_at(words, at,
                         cell_name(array, cell) + " does not lie within the " + std::to_string(words.count) +
                             " numbers that " + std::string(array.name) + " counts");
        }
        plan.add(cell, corners, at);
        at += 1 + corners;
    }
    if (at != words.count) {
        file.fail_at(words, at,
                     "the " + std::to_string(array.cells) + " cells of " + std::string(array.name) + " take " +
                         std::to_string(at) + " numbers, not the " + std::to_string(words.count) + " counted");
    }
}

void plan_ended(const VtkFile& file, const CellArray& array, Plan& plan) {
    std::array<std::uint64_t, 4096> ends;
    std::uint64_t begin = 0;
    for (std::uint64_t first = 0; first < array.cells; first += ends.size()) {
        file.source.parallel().stop_if_asked();
        const std::uint64_t count = std::min<std::uint64_t>(ends.size(), array.cells - first);
        decode_integers(array.ends, first, count, ends.data());
        for (std::uint64_t i = 0; i < count; ++i) {
            if (ends[i] < begin || ends[i] > array.corners.count) {
                file.fail_at(array.ends, first + i,
                             cell_name(array, first + i) + " ends at " + std::to_string(static_cast<std::int64_t>(ends[i])) +
                                 ", which is not from " + std::to_string(begin) + " to " +
                                 std::to_string(array.corners.count));
            }
            plan.add(first + i, ends[i] - begin, begin);
            begin = ends[i];
        }
    }
    if (begin != array.corners.count) {
        file.fail_at(array.corners, begin,
                     "the " + std::to_string(array.cells) + " cells of " + std::string(array.name) + " have " +
                         std::to_string(begin) + " corners, not the " + std::to_string(array.corners.count) +
                         " of their connectivity");
    }
}

/// Calls use(first, count) for each cell of a block, whose corners are `count` numbers from `first` on.
template <class Use>
void for_cells(const CellArray& array, const Block& block, Use use) {
    std::uint64_t at = block.first_number;
    for (std::uint64_t cell = block.first_cell; cell < block.first_cell + block.cells; ++cell) {
        std::uint64_t count = 0;
        if (array.counted) {
            count = word_of(array.corners, at++);
        } else {
            decode_integers(array.ends, cell, 1, &count);
            count -= at;
        }
        use(at, count);
        at += count;
    }
}

/// Throws an error at a corner that `is_wrong`, one of `count` from `first` on.
template <class IsWrong>
[[noreturn]] void fail_at_corner(const VtkFile& file, const CellArray& array, std::uint64_t first, std::uint64_t count,
                                 IsWrong is_wrong, const std::string& what) {
    std::vector<std::uint64_t> points(count);
    decode_integers(array.corners, first, count, points.data());
    const auto found = std::find_if(points.begin(), points.end(), is_wrong);
    file.fail_at(array.corners, first + static_cast<std::uint64_t>(found - points.begin()),
                 "point " + std::to_string(static_cast<std::int64_t>(*found)) + " of " + std::string(array.name) + what);
}

void read_faces_of(const VtkFile& file, const Block& block, FaceList& faces) {
    const CellArray& array = *block.array;
    std::vector<std::uint32_t> corners;
    for_cells(array, block, [&](std::uint64_t first, std::uint64_t count) {
        corners.resize(count);
        if (decode_indices(array.corners, first, count, corners.data()) >= array.point_count && count > 0) {
            fail_at_corner(
                file, array, first, count, [&array](std::uint64_t point) { return point >= array.point_count; },
                " does not exist: there are " + std::to_string(array.point_count));
        }
        std::for_each(corners.begin(), corners.end(), [&array](std::uint32_t& point) { point += array.first_point; });
        if (array.kind == CellKind::polygons) {
            return faces.add(corners, first);
        }
        for (std::size_t i = 2; i < corners.size(); ++i) {
            const std::size_t odd = i % 2;  // every other triangle is listed in reverse
            faces.add(std::array{corners[i - 2 + odd], corners[i - 1 - odd], corners[i]}, first);
        }
    });
}

/// Throws the error of a face that cannot be cut.
void refuse(const VtkFile& file, const CellArray& array, const RefusedFace& face) {
    if (face.vertex) {
        fail_at_corner(
            file, array, face.place, face.corners,
            [&](std::uint64_t point) { return point + array.first_point == *face.vertex; },
            " has a coordinate that is not finite");
    }
    file.fail_at(array.corners, face.place,
                 "the polygon that begins here crosses itself too often to be cut into triangles");
}

std::vector<Block> make_blocks(const VtkFile& file, std::span<const CellArray> arrays, MeshFile& mesh) {
    std::vector<Block> blocks;
    for (const CellArray& array : arrays) {
        Plan plan(array, blocks);
        if (array.counted) {
            plan_counted(file, array, plan);
        } else {
            plan_ended(file, array, plan);
        }
        plan.warn(file.source, mesh);
    }
    return blocks;
}

}  // namespace

void cut_cells(VtkFile& file, std::span<const CellArray> arrays, MeshFile& mesh) {
    if (copy_triangles(file, arrays, mesh)) {
        return;
    }
    if (mesh.vertex_count >= most_vertices) {
        file.source.refuse(ErrorCode::malformed_mesh, "has too many vertices to be numbered beside polygons");
    }
    const std::vector<Block> blocks = make_blocks(file, arrays, mesh);
    const Parallel& parallel = file.source.parallel();
    std::vector<FaceList> lists = parse_faces(blocks.size(), file.budget, parallel, [&](std::size_t i, FaceList& faces) {
        read_faces_of(file, blocks[i], faces);
    });
    give_faces(
        lists, coordinates_of(mesh), file.budget, parallel,
        [&](std::size_t i, const RefusedFace& face) { refuse(file, *blocks[i].array, face); }, mesh);
    if (mesh.triangle_count == 0) {
        file.source.refuse(ErrorCode::empty_mesh, "holds no triangles");
    }
}

}  // namespace lamella
