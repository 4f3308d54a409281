#include "medical/hdf5/load.hpp"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <optional>
#include <utility>
#include <variant>

#include "base/guard.hpp"
#include "medical/hdf5/blocks.hpp"
#include "slicing/result/band_output.hpp"

namespace lamella {

namespace {

using Kinds = std::array<std::uint64_t, static_cast<std::size_t>(ColumnKind::fill_change) + 1>;

constexpr std::uint64_t unknown = ~std::uint64_t{0};

std::uint64_t& of(Kinds& rows, ColumnKind kind) {
    return rows[static_cast<std::size_t>(kind)];
}

/// How many rows each kind has: the same in all of its columns.
Kinds agreed_rows(const InputFile& file, const ReadTree& tree) {
    Kinds rows;
    rows.fill(unknown);
    for (const PlacedColumn& placed : tree.columns) {
        const Column& column = column_of(placed.id);
        std::uint64_t& known = of(rows, column.kind);
        if (known != unknown && known != placed.rows) {
            refuse_place(file, column.path, "not as long as the columns beside it");
        }
        known = placed.rows;
    }
    for (const auto& [kind, end] :
         {std::pair{ColumnKind::layer, ColumnKind::layer_end}, {ColumnKind::contour, ColumnKind::contour_end}}) {
        if (of(rows, end) != of(rows, kind) + 1) {
            refuse_place(file, kind == ColumnKind::layer ? "/layers/first_contour" : "/contours/first_point",
                         "not one row longer than the columns beside it");
        }
    }
    std::replace(rows.begin(), rows.end(), unknown, std::uint64_t{0});
    return rows;
}

bool has_column(const ReadTree& tree, ColumnId id) {
    return std::any_of(tree.columns.begin(), tree.columns.end(),
                       [id](const PlacedColumn& column) { return column.id == id; });
}

/// Columns that come together, or not at all.
void require_together(const InputFile& file, const ReadTree& tree, std::initializer_list<ColumnId> ids) {
    for (const ColumnId id : ids) {
        if (has_column(tree, id) != has_column(tree, *ids.begin())) {
            refuse_place(file, column_of(id).path, "missing, or without the columns that belong to it");
        }
    }
}

void require_optional(const InputFile& file, const ReadTree& tree) {
    require_together(file, tree,
                     {ColumnId::origin_triangle, ColumnId::origin_part, ColumnId::origin_edge, ColumnId::origin_end_edge});
    require_together(file, tree, {ColumnId::gap_layer, ColumnId::gap_from, ColumnId::gap_to});
    require_together(file, tree, {ColumnId::fill_from_layer, ColumnId::fill_from_rule});
    require_together(file, tree, {ColumnId::heights_mm, ColumnId::layer_of_height});
    if (has_column(tree, ColumnId::heights_mm) && !std::holds_alternative<ExplicitPlanes>(tree.result.plan.spacing)) {
        refuse_place(file, column_of(ColumnId::heights_mm).path, "does not belong to these planes");
    }
}

/// Arrays of the right sizes, their contents unspecified.
void make_room(const InputFile& file, ReadTree& tree) {
    const Kinds rows = agreed_rows(file, tree);
    const auto count = [&](ColumnKind kind) { return static_cast<std::size_t>(rows[static_cast<std::size_t>(kind)]); };
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
    }
    result.layer_of.resize_discarding(count(ColumnKind::height));
}

/// What came of a block.
struct Outcome {
    std::uint64_t good_rows = 0;
    std::optional<Error> unread;
};

Outcome load_block(const InputFile& file, SliceResult& result, const PlacedColumn& placed, ColumnBlock& block,
                   std::vector<std::byte>& room) {
    const Column& column = column_of(placed.id);
    room.resize(block.rows * column.row_bytes());
    if (const Status read = file.read_at(placed.offset + block.first * column.row_bytes(), room); !read) {
        return {0, read.error()};
    }
    block.crc = checksum_of(room);
    return {column.set(result, block.first, room), std::nullopt};
}

/// Throws as load_archive() does.
void load_rows(const InputFile& file, ReadTree& tree, const Parallel& parallel) {
    make_room(file, tree);
    require_optional(file, tree);
    std::vector<ColumnBlock> blocks = blocks_of(tree.columns);
    std::vector<Outcome> outcomes(blocks.size());
    std::vector<std::vector<std::byte>> rooms(static_cast<std::size_t>(parallel.threads()));
    parallel.run(blocks.size(), [&](std::size_t i, int worker) {
        outcomes[i] = load_block(file, tree.result, tree.columns[blocks[i].column], blocks[i],
                                 rooms[static_cast<std::size_t>(worker)]);
    });
    for (const Outcome& outcome : outcomes) {
        if (outcome.unread) {
            throw Refused{*outcome.unread};
        }
    }
    const std::vector<std::uint32_t> sums = joined_checksums(tree.columns, blocks);
    for (std::size_t i = 0; i < sums.size(); ++i) {
        if (sums[i] != tree.columns[i].crc) {
            refuse_place(file, column_of(tree.columns[i].id).path, "damaged: it does not have its checksum");
        }
    }
    for (std::size_t i = 0; i < blocks.size(); ++i) {
        if (outcomes[i].good_rows < blocks[i].rows) {
            refuse_place(file, column_of(tree.columns[blocks[i].column].id).path,
                         "row " + std::to_string(blocks[i].first + outcomes[i].good_rows) + " is out of its range");
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

LoadedArchive load_archive(const std::filesystem::path& path, const Parallel& parallel, const Memory* memory) {
    Result<InputFile> file = InputFile::open(path);
    if (!file) {
        throw Refused{file.error()};
    }
    ReadTree tree = read_tree(*file, memory);
    load_rows(*file, tree, parallel);
    check_loaded(*file, tree.result, parallel);
    if (hash_result(tree.result) != tree.hash) {
        refuse_place(*file, "/result_hash", "not the hash of the layers");
    }
    set_summary(tree.result);
    return {std::move(*file), std::move(tree)};
}

}  // namespace lamella
