#include <algorithm>
#include <bit>
#include <limits>
#include <utility>
#include <variant>

#include "base/guard.hpp"
#include "base/numbers.hpp"
#include "lamella/medical/archive.hpp"
#include "medical/hdf5/archive_file.hpp"
#include "slicing/grid/exact.hpp"
#include "slicing/result/band_output.hpp"

namespace lamella {

namespace {

/// Arrays of the right sizes, their contents unspecified.
void make_room(const InputFile& file, ReadTree& tree) {
    const auto count = [&](ColumnKind kind) { return static_cast<std::size_t>(tree.rows[kind]); };
    if (count(ColumnKind::layer_end) != count(ColumnKind::layer) + 1) {
        refuse_place(file, "/layers/first_contour", "not one row longer than the columns beside it");
    }
    if (count(ColumnKind::contour_end) != count(ColumnKind::contour) + 1) {
        refuse_place(file, "/contours/first_point", "not one row longer than the columns beside it");
    }
    SliceResult& result = tree.result;
    if (count(ColumnKind::origin) != 0 && count(ColumnKind::origin) != count(ColumnKind::point)) {
        refuse_place(file, "/origins", "not as many as there are points");
    }
    if (result.first_layer > result.all_layers || count(ColumnKind::layer) > result.all_layers - result.first_layer) {
        refuse_place(file, "/all_layers", "fewer layers than the file has");
    }
    result.layers.resize_discarding(count(ColumnKind::layer));
    result.contours.resize_discarding(count(ColumnKind::contour));
    result.points.resize_discarding(count(ColumnKind::point));
    result.origins.resize_discarding(count(ColumnKind::origin));
    result.closed_gaps.resize_discarding(count(ColumnKind::gap));
    result.region.fill_from.resize(count(ColumnKind::fill_change));
    if (auto* const planes = std::get_if<ExplicitPlanes>(&result.plan.spacing)) {
        planes->heights_mm.resize(count(ColumnKind::height));
    } else if (count(ColumnKind::height) != 0) {
        refuse_place(file, "/plan/heights_mm", "does not belong to these planes");
    }
    result.layer_of.resize_discarding(count(ColumnKind::height));
}

/// Rows of one column that a thread reads at once.
struct Block {
    const PlacedColumn* placed = nullptr;
    std::uint64_t first = 0;
    std::uint64_t rows = 0;
    std::uint64_t good_rows = 0;  ///< before one that is out of its range
};

/// Column by column, from the first row on.
std::vector<Block> blocks_of(const std::vector<PlacedColumn>& columns) {
    std::vector<Block> blocks;
    for (const PlacedColumn& placed : columns) {
        const std::uint64_t at_once = rows_at_once_bytes / placed.column->row_bytes;
        for (std::uint64_t first = 0; first < placed.rows; first += at_once) {
            blocks.push_back({&placed, first, std::min(at_once, placed.rows - first), 0});
        }
    }
    return blocks;
}

void load_block(const InputFile& file, SliceResult& result, Block& block) {
    const Column& column = *block.placed->column;
    std::vector<std::byte> rows(block.rows * column.row_bytes);
    if (const Status read = file.read_at(block.placed->offset + block.first * column.row_bytes, rows); !read) {
        throw Refused{read.error()};
    }
    block.good_rows = column.set(result, block.first, rows);
}

/// Throws as load_archive() does.
void load_rows(const InputFile& file, ReadTree& tree, const Parallel& parallel) {
    make_room(file, tree);
    std::vector<Block> blocks = blocks_of(tree.columns);
    parallel.run(blocks.size(), [&](std::size_t i, int) { load_block(file, tree.result, blocks[i]); });
    for (const Block& block : blocks) {
        if (block.good_rows < block.rows) {
            refuse_place(file, block.placed->column->path,
                         "row " + std::to_string(block.first + block.good_rows) + " is out of its range");
        }
    }
    if (const Status unchanged = file.unchanged(); !unchanged) {
        throw Refused{unchanged.error()};
    }
}

/// A place in the file, and what is wrong with it; empty where nothing is.
struct Complaint {
    const char* path = nullptr;
    std::uint64_t row = 0;
    const char* why = nullptr;
};

void refuse_if(const InputFile& file, const Complaint& complaint) {
    if (complaint.path != nullptr) {
        refuse_place(file, complaint.path, "row " + std::to_string(complaint.row) + " " + complaint.why);
    }
}

/// Calls set(row, count) with how many of `end` follow from each row's first one to the next row's.
template <class T, class Set>
Complaint set_row_counts(const char* path, Array<T>& rows, std::uint64_t end, std::uint64_t T::*first, Set set) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const std::uint64_t begin = rows[i].*first;
        const std::uint64_t next = i + 1 < rows.size() ? rows[i + 1].*first : end;
        if ((i == 0 && begin != 0) || next < begin || next > end || !set(rows[i], next - begin)) {
            return {path, i, "does not lead on to the next row"};
        }
    }
    return {};
}

Integer128 twice_area_of(const SliceResult& result, const Contour& contour) {
    if (contour.role == Role::flat || contour.role == Role::open) {
        return {};
    }
    const std::span<const Point> points = result.points_of(contour);
    Int128 sum = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        sum += cross(points[i], points[i + 1 == points.size() ? 0 : i + 1]);
    }
    return to_integer128(sum);
}

Int128 size_of(const Contour& contour) {
    const Int128 area = to_int128(contour.twice_area);
    return area < 0 ? -area : area;
}

/// Parents start before their children, or there and are larger, so that no chain of parents runs in a ring.
bool is_parent(const SliceResult& result, const Layer& layer, const Contour& contour) {
    if (contour.parent < 0) {
        return contour.parent == -1;
    }
    const auto index = static_cast<std::uint64_t>(contour.parent);
    if (index < layer.first_contour || index >= layer.first_contour + layer.contour_count) {
        return false;
    }
    const Contour& parent = result.contours[index];
    const Point start = result.points[contour.first_point];
    const Point around = result.points[parent.first_point];
    return parent.role <= Role::hole && (around < start || (around == start && size_of(parent) > size_of(contour)));
}

/// Sets the areas of the layer's contours. `open`: as the file says.
Complaint check_layer(SliceResult& result, std::size_t index, bool open) {
    const Layer& layer = result.layers[index];
    if (index > 0 && layer.plane <= result.layers[index - 1].plane) {
        return {"/layers/plane", index, "not above the row before"};
    }
    if (!(layer.bottom_mm <= layer.plane_mm && layer.plane_mm <= layer.top_mm)) {
        return {"/layers/plane_mm", index, "not between bottom and top"};
    }
    const std::uint64_t end = layer.first_contour + layer.contour_count;
    for (std::uint64_t c = layer.first_contour; c < end; ++c) {
        Contour& contour = result.contours[c];
        const auto given = std::bit_cast<double>(contour.twice_area.low);
        contour.twice_area = twice_area_of(result, contour);
        if (stored_area(result, contour) != given) {
            return {"/contours/area_mm2", c, "is not the area of the contour's points"};
        }
    }
    if (open != is_open(result, layer)) {
        return {"/layers/open", index, "is not what the contours of the layer are"};
    }
    for (std::uint64_t c = layer.first_contour; c < end; ++c) {
        if (!is_parent(result, layer, result.contours[c])) {
            return {"/contours/parent", c, "cannot lie around the contour"};
        }
    }
    return {};
}

/// Checks offsets, areas, parents and open layers, which no single row shows, and sets what follows from the columns.
void check_loaded(const InputFile& file, SliceResult& result, const Parallel& parallel) {
    std::vector<bool> open;  // of each layer, as the file says
    for (const Layer& layer : result.layers) {
        open.push_back(layer.contour_count != 0);
    }
    refuse_if(file, set_row_counts("/layers/first_contour", result.layers, result.contours.size(), &Layer::first_contour,
                                   [](Layer& layer, std::uint64_t count) {
                                       layer.contour_count = count;
                                       return true;
                                   }));
    refuse_if(file, set_row_counts("/contours/first_point", result.contours, result.points.size(), &Contour::first_point,
                                   [](Contour& contour, std::uint64_t count) {
                                       contour.point_count = static_cast<std::uint32_t>(count);
                                       return count > 0 && count <= std::numeric_limits<std::uint32_t>::max();
                                   }));
    std::vector<Complaint> complaints(result.layers.size());
    parallel.run_ranges(result.layers.size(), 16, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            complaints[i] = check_layer(result, i, open[i]);
        }
    });
    for (const Complaint& complaint : complaints) {
        refuse_if(file, complaint);
    }
}

void set_summary(SliceResult& result) {
    ContourCounts counts;
    for (const Contour& contour : result.contours) {
        counts.add(contour);
    }
    set_counts(counts, result);
    for (const Layer& layer : result.layers) {
        result.summary.segments += layer.segments;
    }
}

}  // namespace

ReadTree load_archive(const std::filesystem::path& path, const Parallel& parallel, const Memory* memory) {
    const Result<InputFile> file = InputFile::open(path);
    if (!file) {
        throw Refused{file.error()};
    }
    ReadTree tree = read_tree(*file, path, parallel, memory);
    load_rows(*file, tree, parallel);
    check_loaded(*file, tree.result, parallel);
    if (hash_result(tree.result) != tree.hash) {
        refuse_place(*file, "/result_hash", "not the hash of the layers");
    }
    set_summary(tree.result);
    return tree;
}

Result<Archive> read_archive(const std::filesystem::path& path, const Control& control) noexcept {
    return guarded(control, [&]() -> Result<Archive> {
        Parallel parallel(control);
        parallel.begin_stage(0.9, load_runs);
        ReadTree loaded = load_archive(path, parallel, control.memory);
        parallel.finish();
        return Archive{std::move(loaded.result), std::move(loaded.info)};
    });
}

}  // namespace lamella
