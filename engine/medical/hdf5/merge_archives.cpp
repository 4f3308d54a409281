#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

#include "base/guard.hpp"
#include "lamella/medical/archive.hpp"
#include "medical/hdf5/archive_file.hpp"

namespace lamella {

namespace {

constexpr double read_share = 0.5;  ///< of the progress

[[noreturn]] void refuse(const std::string& what) {
    throw Refused{{ErrorCode::invalid_argument, what}};
}

/// "layer 7" or "layers 7 to 9".
std::string layers_between(std::uint64_t first, std::uint64_t end) {
    return end - first == 1 ? "layer " + std::to_string(first)
                            : "layers " + std::to_string(first) + " to " + std::to_string(end - 1);
}

/// An archive of some layers of a plan. Its file is opened for each piece of rows: a thousand parts may be more than a
/// process may have open.
struct ArchivePart {
    std::filesystem::path path;
    std::vector<PlacedColumn> columns;
    KindRows rows{};
    std::vector<ArchiveAttribute> attributes;
    std::uint64_t first_layer = 0;
    std::uint64_t planned_layers = 0;

    std::uint64_t end() const noexcept { return first_layer + rows[ColumnKind::layer]; }
    std::string name() const { return "'" + printable(path.string()) + "'"; }
};

[[noreturn]] void refuse_other(const ArchivePart& part, const ArchivePart& first, const std::string& place) {
    refuse(part.name() + " and " + first.name() + " are not of one slicing: they differ in " + place);
}

void require_same_attributes(const ArchivePart& part, const ArchivePart& first) {
    const auto own_end = part.attributes.end() - attributes_of_part;
    const auto first_end = first.attributes.end() - attributes_of_part;
    const auto [own, other] = std::mismatch(part.attributes.begin(), own_end, first.attributes.begin(), first_end);
    if (own != own_end || other != first_end) {
        refuse_other(part, first, (own != own_end ? *own : *other).place());
    }
}

void require_whole(const std::vector<ArchivePart>& parts) {
    const ArchivePart& first = parts.front();
    const ArchivePart& last = parts.back();
    if (first.first_layer > 0) {
        refuse(layers_between(0, first.first_layer) + " are missing before " + first.name());
    }
    for (std::size_t i = 1; i < parts.size(); ++i) {
        const ArchivePart& before = parts[i - 1];
        const ArchivePart& part = parts[i];
        if (part.first_layer > before.end()) {
            refuse(layers_between(before.end(), part.first_layer) + " lie in neither " + before.name() + " nor " +
                   part.name());
        }
        if (part.first_layer < before.end()) {
            refuse(before.name() + " and " + part.name() + " both hold " +
                   layers_between(part.first_layer, std::min(part.end(), before.end())));
        }
    }
    if (last.end() < last.planned_layers) {
        refuse(layers_between(last.end(), last.planned_layers) + " are missing after " + last.name());
    }
}

/// All of one slicing, by their layers.
std::vector<ArchivePart> open_parts(std::span<const std::filesystem::path> paths, const Parallel& parallel) {
    if (paths.empty()) {
        refuse("no archives to join");
    }
    std::vector<ArchivePart> parts;
    parts.reserve(paths.size());
    for (const std::filesystem::path& path : paths) {
        ReadTree tree = read_tree(require(InputFile::open(path)), path, parallel);
        const SliceInfo& info = tree.result.info;
        parts.push_back({path, std::move(tree.columns), tree.rows, attributes_of(info, tree.info, tree.hash),
                         info.first_layer, info.planned_layers});
        require_same_attributes(parts.back(), parts.front());
    }
    std::stable_sort(parts.begin(), parts.end(), [](const ArchivePart& a, const ArchivePart& b) {
        return std::pair(a.first_layer, a.end()) < std::pair(b.first_layer, b.end());
    });
    require_whole(parts);
    return parts;
}

/// Heights and fill rules, which are the same in all parts.
bool is_of_options(const Column& column) noexcept {
    return column.kind == ColumnKind::height || column.kind == ColumnKind::fill_change;
}

std::vector<std::byte> rows_in(const SliceResult& result, const Column& column) {
    std::vector<std::byte> rows(rows_of(result)[column.kind] * column.row_bytes);
    column.get(result, 0, rows);
    return rows;
}

/// The attributes and hash of the whole: reads and checks all rows of all parts.
ReadTree read_parts(const std::vector<ArchivePart>& parts, const Parallel& parallel, const Memory* memory) {
    LayerHash hash(parts.front().planned_layers);
    ReadTree whole;
    for (const ArchivePart& part : parts) {
        ReadTree loaded = load_archive(part.path, parallel, memory);
        for (const LayerView layer : loaded.result) {
            hash.add(layer);
        }
        if (&part == &parts.front()) {
            whole.result.info = std::move(loaded.result.info);
            whole.info = std::move(loaded.info);
            continue;
        }
        for (const Column& column : all_columns()) {
            if (is_of_options(column) && rows_in(whole.result, column) != rows_in(loaded.result, column)) {
                refuse_other(part, parts.front(), column.path);
            }
        }
    }
    whole.hash = hash.value();
    return whole;
}

/// How many rows of a column come from a part: those of options are those of the first; the last row of an end stands in
/// the last part.
std::uint64_t rows_from(const std::vector<ArchivePart>& parts, const ArchivePart& part, const Column& column) {
    if (is_of_options(column) && &part != &parts.front()) {
        return 0;
    }
    return part.rows[column.kind] + (column.has_end && &part == &parts.back() ? 1 : 0);
}

/// Indices count from the first part on; -1 names none.
void shift(std::span<std::byte> rows, std::uint64_t by) {
    for (std::size_t at = 0; by != 0 && at < rows.size(); at += sizeof by) {
        std::uint64_t index = 0;
        std::memcpy(&index, rows.data() + at, sizeof index);
        index += index == ~std::uint64_t{0} ? 0 : by;
        std::memcpy(rows.data() + at, &index, sizeof index);
    }
}

void give_rows(const std::vector<ArchivePart>& parts, const Column& column, const RowSink& take) {
    std::uint64_t rows_before = 0;  // that its indices count
    std::vector<std::byte> rows;
    for (const ArchivePart& part : parts) {
        for (const RowRange& range : ranges_of(rows_from(parts, part, column), column)) {
            const InputFile file = require(InputFile::open(part.path));
            const auto placed = std::find_if(part.columns.begin(), part.columns.end(),
                                             [&](const PlacedColumn& one) { return one.column == &column; });
            rows.resize(range.count * column.row_bytes);
            require(file.read_at(placed->offset + range.first * column.row_bytes, rows));
            shift(rows, rows_before);
            take(rows);
        }
        rows_before += column.names ? part.rows[*column.names] : 0;
    }
}

}  // namespace

Result<MergedArchive> merge_archives(std::span<const std::filesystem::path> parts, const std::filesystem::path& path,
                                     const Context& context) noexcept {
    return guarded(context, [&]() -> Result<MergedArchive> {
        const Parallel parallel(context);
        parallel.begin_stage(read_share, (tree_runs + load_runs) * parts.size());
        const std::vector<ArchivePart> all = open_parts(parts, parallel);
        ReadTree whole = read_parts(all, parallel, context.memory);
        const SliceInfo& slice = whole.result.info;
        KindRows rows = all.front().rows;
        for (const ColumnKind kind :
             {ColumnKind::layer, ColumnKind::contour, ColumnKind::point, ColumnKind::origin, ColumnKind::stitch}) {
            rows[kind] = 0;
            for (const ArchivePart& part : all) {
                rows[kind] += part.rows[kind];
            }
        }
        const auto give = [&](const Column& column, const RowSink& take) { give_rows(all, column, take); };
        require(write_columns(rows, give, attributes_of(slice, whole.info, whole.hash), path, parallel, read_share));
        return MergedArchive{all.front().planned_layers, whole.hash, slice.grid_mm, slice.options.region.fill_rule,
                             std::move(whole.info)};
    });
}

}  // namespace lamella
