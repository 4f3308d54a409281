#include <algorithm>
#include <cstring>
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
    ReadTree tree;
    std::vector<ArchiveAttribute> attributes;

    std::uint64_t first_layer() const noexcept { return tree.result.info.first_layer; }
    std::uint64_t end() const noexcept { return first_layer() + tree.rows[layer_rows]; }
    std::string name() const { return "'" + printable(path.string()) + "'"; }
};

[[noreturn]] void refuse_other(const ArchivePart& part, const ArchivePart& first, const std::string& place) {
    refuse(part.name() + " and " + first.name() + " are not of one slicing: they differ in " + place);
}

void require_whole(const std::vector<ArchivePart>& parts) {
    const ArchivePart& first = parts.front();
    const ArchivePart& last = parts.back();
    if (first.first_layer() > 0) {
        refuse(layers_between(0, first.first_layer()) + " are missing before " + first.name());
    }
    for (std::size_t i = 1; i < parts.size(); ++i) {
        const ArchivePart& before = parts[i - 1];
        const ArchivePart& part = parts[i];
        if (part.first_layer() > before.end()) {
            refuse(layers_between(before.end(), part.first_layer()) + " lie in neither " + before.name() + " nor " +
                   part.name());
        }
        if (part.first_layer() < before.end()) {
            refuse(before.name() + " and " + part.name() + " both hold " +
                   layers_between(part.first_layer(), std::min(part.end(), before.end())));
        }
    }
    if (last.end() < last.tree.result.info.planned_layers) {
        refuse(layers_between(last.end(), last.tree.result.info.planned_layers) + " are missing after " + last.name());
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
        std::vector<ArchiveAttribute> attributes = attributes_of(tree.result.info, tree.info, tree.hash);
        parts.push_back({path, std::move(tree), std::move(attributes)});
        const ArchivePart& part = parts.back();
        const ArchivePart& first = parts.front();
        const auto own_end = part.attributes.end() - attributes_of_part;
        const auto first_end = first.attributes.end() - attributes_of_part;
        const auto [own, other] = std::mismatch(part.attributes.begin(), own_end, first.attributes.begin(), first_end);
        if (own != own_end || other != first_end) {
            refuse_other(part, first, (own != own_end ? *own : *other).place());
        }
    }
    std::stable_sort(parts.begin(), parts.end(), [](const ArchivePart& a, const ArchivePart& b) {
        return std::pair(a.first_layer(), a.end()) < std::pair(b.first_layer(), b.end());
    });
    require_whole(parts);
    return parts;
}

/// Heights and fill rules, which are the same in all parts.
bool is_of_options(const Column& column) noexcept {
    return column.kind == height_rows || column.kind == fill_change_rows;
}

/// The attributes and hash of the whole: reads and checks all rows of all parts.
ReadTree read_parts(const std::vector<ArchivePart>& parts, const Parallel& parallel, const Memory* memory) {
    LayerHash hash(parts.front().tree.result.info.planned_layers);
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
        const auto rows = [](const SliceResult& result, const Column& column) {
            std::vector<std::byte> bytes(rows_of(result)[column.kind] * column.row_bytes);
            column.get(result, 0, bytes);
            return bytes;
        };
        for (const Column& column : all_columns()) {
            if (is_of_options(column) && rows(whole.result, column) != rows(loaded.result, column)) {
                refuse_other(part, parts.front(), column.path);
            }
        }
    }
    whole.hash = hash.value();
    return whole;
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
        // Rows of options are those of the first part; the last row of an end stands in the last part.
        const bool is_none = is_of_options(column) && &part != &parts.front();
        const std::uint64_t end_rows = column.has_end && &part == &parts.back() ? 1 : 0;
        for (const RowRange& range : ranges_of(is_none ? 0 : part.tree.rows[column.kind] + end_rows, column)) {
            const InputFile file = require(InputFile::open(part.path));
            const auto placed = std::find_if(part.tree.columns.begin(), part.tree.columns.end(),
                                             [&](const PlacedColumn& one) { return one.column == &column; });
            rows.resize(range.count * column.row_bytes);
            require(file.read_at(placed->offset + range.first * column.row_bytes, rows));
            shift(rows, rows_before);
            take(rows);
        }
        rows_before += column.names ? part.tree.rows[*column.names] : 0;
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
        KindRows rows = all.front().tree.rows;
        for (const ColumnKind kind : {layer_rows, contour_rows, point_rows, origin_rows, stitch_rows}) {
            rows[kind] = 0;
            for (const ArchivePart& part : all) {
                rows[kind] += part.tree.rows[kind];
            }
        }
        const auto give = [&](const Column& column, const RowSink& take) { give_rows(all, column, take); };
        write_columns(rows, give, attributes_of(slice, whole.info, whole.hash), path, parallel, read_share);
        return MergedArchive{slice.planned_layers, whole.hash, slice.grid_mm, slice.options.region.fill_rule,
                             std::move(whole.info)};
    });
}

}  // namespace lamella
