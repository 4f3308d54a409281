#include "io/read/vtk/vtk_cells.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "io/read/lookout.hpp"
#include "io/read/polygon.hpp"
#include "io/read/vtk/vtk_triangles.hpp"

namespace lamella {

namespace {

/// Numbers of an array that one task cuts, unless a single cell has more.
constexpr std::uint64_t block_numbers = std::uint64_t{1} << 15;

/// Cells that one task cuts.
struct Block {
    std::uint64_t first_cell = 0;
    std::uint64_t cells = 0;
    std::uint64_t first_number = 0;  ///< in the corners
    std::uint64_t numbers = 0;
    std::uint64_t first_triangle = 0;
};

std::uint64_t triangles_of(std::uint64_t corners) {
    return corners < 3 ? 0 : corners - 2;
}

/// The cells of an array, checked and shared out.
struct Plan {
    const CellArray* array = nullptr;
    std::vector<Block> blocks;
    std::uint64_t triangles = 0;
    std::uint64_t most_corners = 0;
    std::uint64_t without_area = 0;
    std::uint64_t first_without_area = 0;

    void add(std::uint64_t cell, std::uint64_t corners, std::uint64_t first_number) {
        if (blocks.empty() || blocks.back().numbers >= block_numbers || blocks.back().cells >= block_numbers) {
            blocks.push_back({.first_cell = cell, .first_number = first_number, .first_triangle = triangles});
        }
        Block& block = blocks.back();
        ++block.cells;
        block.numbers += corners + (array->counted ? 1 : 0);
        triangles += triangles_of(corners);
        most_corners = std::max(most_corners, corners);
        if (corners < 3 && without_area++ == 0) {
            first_without_area = cell;
        }
    }
};

/// A number of a counted array.
std::uint32_t word_of(const NumberArray& words, std::uint64_t index) {
    assert(bytes_of(words.type) == sizeof(std::uint32_t));
    std::uint32_t word = 0;
    std::memcpy(&word, words.data + index * sizeof word, sizeof word);
    return words.big_endian ? __builtin_bswap32(word) : word;
}

std::string cell_name(const CellArray& array, std::uint64_t cell) {
    return "cell " + std::to_string(cell) + " of " + std::string(array.name);
}

Status plan_counted(const VtkFile& file, Plan& plan) {
    const CellArray& array = *plan.array;
    const NumberArray& words = array.corners;
    std::uint64_t at = 0;
    Lookout lookout(file.source.parallel());
    for (std::uint64_t cell = 0; cell < array.cells; ++cell) {
        lookout.pass();
        const std::uint64_t corners = at < words.count ? word_of(words, at) : 0;
        if (at + corners >= words.count) {
            return file.error_at(words, at,
                                 cell_name(array, cell) + " does not lie within the " + std::to_string(words.count) +
                                     " numbers that " + std::string(array.name) + " counts");
        }
        plan.add(cell, corners, at);
        at += 1 + corners;
    }
    if (at != words.count) {
        return file.error_at(words, at,
                             "the " + std::to_string(array.cells) + " cells of " + std::string(array.name) + " take " +
                                 std::to_string(at) + " numbers, not the " + std::to_string(words.count) + " counted");
    }
    return {};
}

Status plan_ended(const VtkFile& file, Plan& plan) {
    const CellArray& array = *plan.array;
    std::array<std::uint64_t, 4096> ends;
    std::uint64_t begin = 0;
    for (std::uint64_t first = 0; first < array.cells; first += ends.size()) {
        file.source.parallel().stop_if_asked();
        const std::uint64_t count = std::min<std::uint64_t>(ends.size(), array.cells - first);
        decode_integers(array.ends, first, count, ends.data());
        for (std::uint64_t i = 0; i < count; ++i) {
            if (ends[i] < begin || ends[i] > array.corners.count) {
                return file.error_at(array.ends, first + i,
                                     cell_name(array, first + i) + " ends at " +
                                         std::to_string(static_cast<std::int64_t>(ends[i])) + ", which is not from " +
                                         std::to_string(begin) + " to " + std::to_string(array.corners.count));
            }
            plan.add(first + i, ends[i] - begin, begin);
            begin = ends[i];
        }
    }
    if (begin != array.corners.count) {
        return file.error_at(array.corners, begin,
                             "the " + std::to_string(array.cells) + " cells of " + std::string(array.name) + " have " +
                                 std::to_string(begin) + " corners, not the " + std::to_string(array.corners.count) +
                                 " of their connectivity");
    }
    return {};
}

/// Why a block could not be cut.
struct Failure {
    enum class Kind : std::uint8_t { none, no_point, not_finite, tangled };
    Kind kind = Kind::none;
    std::uint64_t number = 0;  ///< in the corners
};

/// Cuts blocks; holds the state of one thread.
class Cutter {
public:
    explicit Cutter(const VertexCoordinates& vertices) : vertices_(vertices) {}

    Failure cut(const CellArray& array, const Block& block, std::uint32_t* out) {
        array_ = &array;
        failure_ = {};
        cut_cells(block, out);
        return failure_;
    }

private:
    void cut_cells(const Block& block, std::uint32_t* out);
    std::size_t cut_cell(std::span<const std::uint32_t> corners, std::uint64_t first_number, std::uint32_t* out);

    /// The first of `count` numbers that is no point. Precondition: there is one.
    void fail_without_point(std::uint64_t first, std::uint64_t count);

    const VertexCoordinates& vertices_;
    const CellArray* array_ = nullptr;
    Failure failure_;
    std::vector<std::uint32_t> corners_;  ///< of one cell
    PolygonTriangulator triangulator_;
};

void Cutter::fail_without_point(std::uint64_t first, std::uint64_t count) {
    for (std::uint64_t i = 0; i < count; ++i) {
        std::uint64_t point = 0;
        decode_integers(array_->corners, first + i, 1, &point);
        if (point >= array_->point_count) {
            failure_ = {Failure::Kind::no_point, first + i};
            return;
        }
    }
    assert(false && "all are points");
}

void Cutter::cut_cells(const Block& block, std::uint32_t* out) {
    std::uint64_t at = block.first_number;
    for (std::uint64_t cell = block.first_cell; cell < block.first_cell + block.cells; ++cell) {
        std::uint64_t count = 0;
        if (array_->counted) {
            count = word_of(array_->corners, at++);
        } else {
            decode_integers(array_->ends, cell, 1, &count);
            count -= at;
        }
        corners_.resize(count);
        if (decode_indices(array_->corners, at, count, corners_.data()) >= array_->point_count && count > 0) {
            return fail_without_point(at, count);
        }
        std::for_each(corners_.begin(), corners_.end(), [this](std::uint32_t& point) { point += array_->first_point; });
        out += 3 * (count >= 3 ? cut_cell(corners_, at, out) : 0);
        if (failure_.kind != Failure::Kind::none) {
            return;
        }
        at += count;
    }
}

std::size_t Cutter::cut_cell(std::span<const std::uint32_t> corners, std::uint64_t first_number, std::uint32_t* out) {
    if (array_->kind == CellKind::strips) {
        for (std::size_t i = 2; i < corners.size(); ++i, out += 3) {
            const std::size_t odd = i % 2;  // every other triangle is listed in reverse
            out[0] = corners[i - 2 + odd];
            out[1] = corners[i - 1 - odd];
            out[2] = corners[i];
        }
        return corners.size() - 2;
    }
    for (std::size_t i = 0; corners.size() > 3 && i < corners.size(); ++i) {
        const std::array<double, 3> at = vertices_[corners[i]];
        if (!std::all_of(at.begin(), at.end(), [](double c) { return std::isfinite(c); })) {
            failure_ = {Failure::Kind::not_finite, first_number + i};
            return 0;
        }
    }
    const std::size_t triangles = triangulator_.triangulate(corners, vertices_, out);
    if (triangles == 0) {
        failure_ = {Failure::Kind::tangled, first_number};
    }
    return triangles;
}

Error error_of(const VtkFile& file, const CellArray& array, const Failure& failure) {
    std::uint64_t point = 0;
    decode_integers(array.corners, failure.number, 1, &point);
    const std::string named = "point " + std::to_string(static_cast<std::int64_t>(point)) + " of " + std::string(array.name);
    switch (failure.kind) {
        case Failure::Kind::no_point:
            return file.error_at(array.corners, failure.number,
                                 named + " does not exist: there are " + std::to_string(array.point_count));
        case Failure::Kind::not_finite:
            return file.error_at(array.corners, failure.number, named + " has a coordinate that is not finite");
        default:
            return file.error_at(array.corners, failure.number,
                                 "the polygon that begins here crosses itself too often to be cut into triangles");
    }
}

Status make_plans(VtkFile& file, std::span<const CellArray> arrays, std::vector<Plan>& plans, MeshFile& mesh) {
    std::uint64_t scratch = 0;
    for (const CellArray& array : arrays) {
        Plan& plan = plans.emplace_back();
        plan.array = &array;
        if (Status done = array.counted ? plan_counted(file, plan) : plan_ended(file, plan); !done) {
            return done;
        }
        mesh.triangle_count += plan.triangles;
        const bool strips = array.kind == CellKind::strips;
        const std::uint64_t to_cut = strips ? 0 : PolygonTriangulator::scratch_bytes(plan.most_corners);
        scratch = std::max(scratch, plan.most_corners * sizeof(std::uint32_t) + to_cut);
        if (plan.without_area > 0) {
            mesh.warnings.push_back(file.source.name() + ": ignored " + std::to_string(plan.without_area) + " cells of " +
                                    std::string(array.name) + " with fewer than three corners, the first being cell " +
                                    std::to_string(plan.first_without_area));
        }
    }
    constexpr std::uint64_t always_there = std::uint64_t{1} << 20;
    if (scratch > always_there) {
        const auto threads = static_cast<std::uint64_t>(file.source.parallel().threads());
        if (Status room = file.budget.take(std::min(threads, mesh.triangle_count), scratch); !room) {
            return room;
        }
    }
    return file.budget.take(mesh.triangle_count, 3 * sizeof(std::uint32_t));
}

Status cut_plan(const VtkFile& file, const Plan& plan, std::vector<Cutter>& cutters, std::uint32_t* out) {
    std::vector<Failure> failures(plan.blocks.size());
    file.source.parallel().run(plan.blocks.size(), [&](std::size_t i, int worker) {
        const Block& block = plan.blocks[i];
        failures[i] = cutters[static_cast<std::size_t>(worker)].cut(*plan.array, block, out + 3 * block.first_triangle);
    });
    const auto failed = std::find_if(failures.begin(), failures.end(),
                                     [](const Failure& failure) { return failure.kind != Failure::Kind::none; });
    return failed == failures.end() ? Status() : error_of(file, *plan.array, *failed);
}

}  // namespace

Status cut_cells(VtkFile& file, std::span<const CellArray> arrays, MeshFile& mesh) {
    if (copy_triangles(file, arrays, mesh)) {
        return {};
    }
    std::vector<Plan> plans;
    if (Status planned = make_plans(file, arrays, plans, mesh); !planned) {
        return planned;
    }
    if (mesh.triangle_count == 0) {
        return file.source.error(ErrorCode::empty_mesh, "holds no triangles");
    }
    mesh.indices = Array<std::uint32_t>(file.source.memory());
    mesh.indices.resize_discarding(3 * mesh.triangle_count);
    const VertexCoordinates vertices{mesh.bytes.data() + mesh.first_offset, mesh.stride, mesh.coordinate_type};
    std::vector<Cutter> cutters(static_cast<std::size_t>(file.source.parallel().threads()), Cutter(vertices));
    std::uint32_t* out = mesh.indices.data();
    for (const Plan& plan : plans) {
        if (Status cut = cut_plan(file, plan, cutters, out); !cut) {
            return cut;
        }
        out += 3 * plan.triangles;
    }
    return {};
}

}  // namespace lamella
