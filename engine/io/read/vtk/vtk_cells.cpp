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

/// Numbers of an array that one task reads, unless a single cell has more.
constexpr std::uint64_t block_numbers = std::uint64_t{1} << 15;

/// Cells that one task reads.
struct Block {
    std::uint64_t first_cell = 0;
    std::uint64_t cells = 0;
    std::uint64_t first_number = 0;  ///< in the corners
    std::uint64_t numbers = 0;
};

/// The cells of an array, checked and shared out.
struct Plan {
    const CellArray& array;
    std::vector<Block> blocks{};
    std::vector<FaceRange> faces{};  // of each block
    std::uint64_t triangles = 0;
    std::uint64_t most_corners = 0;
    std::uint64_t without_area = 0;
    std::uint64_t first_without_area = 0;

    void add(std::uint64_t cell, std::uint64_t corners, std::uint64_t first_number) {
        if (blocks.empty() || blocks.back().numbers >= block_numbers || blocks.back().cells >= block_numbers) {
            blocks.push_back({.first_cell = cell, .first_number = first_number});
            faces.push_back({.first_triangle = triangles});
        }
        ++blocks.back().cells;
        blocks.back().numbers += corners + (array.counted ? 1 : 0);
        faces.back().triangles += triangles_in(corners);
        triangles += triangles_in(corners);
        most_corners = std::max(most_corners, corners);
        if (corners < 3 && without_area++ == 0) {
            first_without_area = cell;
        }
    }
};

/// A number of a counted array.
std::uint32_t word_of(const NumberArray& words, std::uint64_t index) {
    return load_number<std::uint32_t>(words.data + index * sizeof(std::uint32_t), words.big_endian);
}

std::string cell_name(const CellArray& array, std::uint64_t cell) {
    return "cell " + std::to_string(cell) + " of " + std::string(array.name);
}

void plan_counted(const VtkFile& file, Plan& plan) {
    const CellArray& array = plan.array;
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

void plan_ended(const VtkFile& file, Plan& plan) {
    const CellArray& array = plan.array;
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

void write_faces(const VtkFile& file, const CellArray& array, const Block& block, FaceWriter faces) {
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
            if (!faces.add(corners)) {
                file.fail_at(array.corners, first,
                             "the polygon that begins here has too many corners to be cut into triangles");
            }
            return;
        }
        for (std::size_t i = 2; i < corners.size(); ++i) {
            const std::size_t odd = i % 2;  // every other triangle is listed in reverse
            faces.add(std::array{corners[i - 2 + odd], corners[i - 1 - odd], corners[i]});
        }
    });
}

/// Throws the error of a face of a block that cannot be cut.
void refuse(const VtkFile& file, const CellArray& array, const Block& block, const RefusedFace& face) {
    std::size_t number = face.number;
    for_cells(array, block, [&](std::uint64_t first, std::uint64_t count) {
        if (count < 3 || number-- != 0) {
            return;
        }
        if (face.vertex) {
            fail_at_corner(
                file, array, first, count, [&](std::uint64_t point) { return point + array.first_point == *face.vertex; },
                " has a coordinate that is not finite");
        }
        file.fail_at(array.corners, first, "the polygon that begins here crosses itself too often to be cut into triangles");
    });
}

std::vector<Plan> make_plans(VtkFile& file, std::span<const CellArray> arrays, MeshFile& mesh) {
    std::vector<Plan> plans;
    std::uint64_t scratch = 0;
    for (const CellArray& array : arrays) {
        Plan& plan = plans.emplace_back(Plan{array});
        if (array.counted) {
            plan_counted(file, plan);
        } else {
            plan_ended(file, plan);
        }
        mesh.triangle_count += plan.triangles;
        const std::uint64_t most = plan.most_corners;
        scratch = std::max(scratch, array.kind == CellKind::strips ? most * sizeof(std::uint32_t) : cutting_bytes(most));
        if (plan.without_area > 0) {
            mesh.warnings.push_back(file.source.name() + ": ignored " + std::to_string(plan.without_area) + " cells of " +
                                    std::string(array.name) + " with fewer than three corners, the first being cell " +
                                    std::to_string(plan.first_without_area));
        }
    }
    constexpr std::uint64_t always_there = std::uint64_t{1} << 20;
    if (scratch > always_there) {
        const auto threads = static_cast<std::uint64_t>(file.source.parallel().threads());
        file.budget.take(std::min(threads, mesh.triangle_count), scratch);
    }
    file.budget.take(mesh.triangle_count, triangle_bytes);
    return plans;
}

}  // namespace

void cut_cells(VtkFile& file, std::span<const CellArray> arrays, MeshFile& mesh) {
    if (copy_triangles(file, arrays, mesh)) {
        return;
    }
    const std::vector<Plan> plans = make_plans(file, arrays, mesh);
    if (mesh.triangle_count == 0) {
        file.source.refuse(ErrorCode::empty_mesh, "holds no triangles");
    }
    mesh.indices = Array<std::uint32_t>(file.source.memory());
    mesh.indices.resize_discarding(3 * mesh.triangle_count);
    const VertexCoordinates vertices{mesh.bytes.data() + mesh.first_offset, mesh.stride, mesh.vertex_type};
    const Parallel& parallel = file.source.parallel();
    std::size_t done = 0;
    for (const Plan& plan : plans) {
        const std::span<std::uint32_t> own = mesh.indices.span().subspan(done, 3 * plan.triangles);
        parse_pieces(plan.blocks.size(), parallel, [&](std::size_t i, int) {
            write_faces(file, plan.array, plan.blocks[i], FaceWriter(own, plan.faces[i]));
        });
        cut_faces(plan.faces, own, vertices, parallel,
                  [&](std::size_t block, const RefusedFace& face) { refuse(file, plan.array, plan.blocks[block], face); });
        done += own.size();
    }
}

}  // namespace lamella
