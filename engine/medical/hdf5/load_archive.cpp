#include <algorithm>
#include <array>
#include <utility>
#include <variant>

#include "base/guard.hpp"
#include "lamella/medical/archive.hpp"
#include "medical/hdf5/archive_file.hpp"
#include "slicing/result/band_output.hpp"

namespace lamella {

namespace {

/// How many rows each kind of columns has.
using KindRows = std::array<std::uint64_t, static_cast<std::size_t>(ColumnKind::fill_change) + 1>;

std::uint64_t rows_of(const KindRows& rows, ColumnKind kind) {
    return rows[static_cast<std::size_t>(kind)];
}

/// All columns of a kind have as many rows, or are left out together.
KindRows agreed_rows(const InputFile& file, const ReadTree& tree) {
    constexpr std::uint64_t unknown = ~std::uint64_t{0};
    KindRows rows;
    rows.fill(unknown);
    for_each_column([&](ColumnId id) {
        const Column& column = column_of(id);
        const auto placed =
            std::find_if(tree.columns.begin(), tree.columns.end(), [id](const PlacedColumn& one) { return one.id == id; });
        const std::uint64_t own = placed == tree.columns.end() ? 0 : placed->rows;
        std::uint64_t& known = rows[static_cast<std::size_t>(column.kind)];
        if (known != unknown && known != own) {
            refuse_place(file, column.path, "missing, or not as long as the columns that belong to it");
        }
        known = own;
    });
    if (rows_of(rows, ColumnKind::layer_end) != rows_of(rows, ColumnKind::layer) + 1) {
        refuse_place(file, column_of(ColumnId::first_contour).path, "not one row longer than the columns beside it");
    }
    if (rows_of(rows, ColumnKind::contour_end) != rows_of(rows, ColumnKind::contour) + 1) {
        refuse_place(file, column_of(ColumnId::first_point).path, "not one row longer than the columns beside it");
    }
    return rows;
}

/// Arrays of the right sizes, their contents unspecified.
void make_room(const InputFile& file, ReadTree& tree) {
    const KindRows rows = agreed_rows(file, tree);
    const auto count = [&](ColumnKind kind) { return static_cast<std::size_t>(rows_of(rows, kind)); };
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
        refuse_place(file, column_of(ColumnId::heights_mm).path, "does not belong to these planes");
    }
    result.layer_of.resize_discarding(count(ColumnKind::height));
}

/// Rows of one column that a thread reads at once.
struct Block {
    const PlacedColumn* column = nullptr;
    std::uint64_t first = 0;
    std::uint64_t rows = 0;
    std::uint64_t good_rows = 0;  ///< before one that is out of its range
};

/// Column by column, from the first row on.
std::vector<Block> blocks_of(const std::vector<PlacedColumn>& columns) {
    std::vector<Block> blocks;
    for (const PlacedColumn& column : columns) {
        const std::uint64_t at_once = rows_at_once_bytes / column_of(column.id).row_bytes;
        for (std::uint64_t first = 0; first < column.rows; first += at_once) {
            blocks.push_back({&column, first, std::min(at_once, column.rows - first), 0});
        }
    }
    return blocks;
}

void load_block(const InputFile& file, SliceResult& result, Block& block) {
    const Column& column = column_of(block.column->id);
    std::vector<std::byte> rows(block.rows * column.row_bytes);
    if (const Status read = file.read_at(block.column->offset + block.first * column.row_bytes, rows); !read) {
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
            refuse_place(file, column_of(block.column->id).path,
                         "row " + std::to_string(block.first + block.good_rows) + " is out of its range");
        }
    }
    if (const Status unchanged = file.unchanged(); !unchanged) {
        throw Refused{unchanged.error()};
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
