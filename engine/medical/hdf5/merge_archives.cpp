#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

#include "base/guard.hpp"
#include "base/words.hpp"
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

/// An archive of some layers of a plan.
struct ArchivePart {
    std::filesystem::path path;
    std::vector<PlacedColumn> columns;
    KindRows rows{};
    std::uint64_t first_layer = 0;

    std::uint64_t end() const noexcept { return first_layer + rows[ColumnKind::layer]; }
};

std::string quoted(const ArchivePart& part) {
    return "'" + printable(part.path.string()) + "'";
}

/// Parts of one slicing, by their layers, whose columns follow one another as those of one archive. Files are opened for
/// each piece of rows: a thousand parts may be more than a process may have open.
class Parts {
public:
    Parts(std::span<const std::filesystem::path> paths, const Parallel& parallel) {
        if (paths.empty()) {
            refuse("no archives to join");
        }
        for (const std::filesystem::path& path : paths) {
            add(path, parallel);
        }
        std::stable_sort(parts_.begin(), parts_.end(), [](const ArchivePart& a, const ArchivePart& b) {
            return std::pair(a.first_layer, a.end()) < std::pair(b.first_layer, b.end());
        });
        require_whole();
    }

    std::uint64_t layers() const noexcept { return all_layers_; }

    /// Reads and checks all rows; the hash of the whole. What is known of the first part goes to `slice` and `info`.
    std::uint64_t read(const Parallel& parallel, const Memory* memory, SliceInfo& slice, ArchiveInfo& info) const {
        LayerHash hash(all_layers_);
        SliceResult first;  // without its layers
        for (const ArchivePart& part : parts_) {
            ReadTree loaded = load_archive(part.path, parallel, memory);
            for (const LayerView layer : loaded.result) {
                hash.add(layer);
            }
            if (&part == &parts_.front()) {
                first.info = std::move(loaded.result.info);
                info = std::move(loaded.info);
            } else {
                require_same_rows(first, loaded.result, part);
            }
        }
        slice = std::move(first.info);
        return hash.value();
    }

    KindRows rows() const {
        KindRows sums;
        for (const Column& column : all_columns()) {
            sums[column.kind] = 0;
            for (std::size_t part = 0; part < parts_.size(); ++part) {
                sums[column.kind] += own_rows(column.kind, part);
            }
        }
        return sums;
    }

    void fill(const Column& column, std::uint64_t first, std::span<std::byte> to) const {
        for (std::size_t part = 0; part < parts_.size() && !to.empty(); ++part) {
            const std::uint64_t rows = own_rows(column.kind, part);
            if (first >= rows) {
                first -= rows;
                continue;
            }
            const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(rows - first, to.size() / column.row_bytes));
            copy_rows(part, column, first, to.first(count * column.row_bytes));
            to = to.subspan(count * column.row_bytes);
            first = 0;
        }
    }

private:
    /// Heights and fill rules, which are the same in all parts.
    static bool is_of_options(ColumnKind kind) noexcept {
        return kind == ColumnKind::height || kind == ColumnKind::fill_change;
    }

    static std::vector<std::byte> rows_in(const SliceResult& result, const Column& column) {
        std::vector<std::byte> rows(rows_of(result)[column.kind] * column.row_bytes);
        column.get(result, 0, rows);
        return rows;
    }

    /// Those of options are those of the first; the last row of an end stands in the last part.
    std::uint64_t own_rows(ColumnKind kind, std::size_t part) const noexcept {
        if (part > 0 && is_of_options(kind)) {
            return 0;
        }
        const bool has_end = kind == ColumnKind::layer_end || kind == ColumnKind::contour_end;
        return parts_[part].rows[kind] - (has_end && part + 1 < parts_.size() ? 1 : 0);
    }

    void copy_rows(std::size_t part, const Column& column, std::uint64_t first, std::span<std::byte> to) const {
        const InputFile file = require(InputFile::open(parts_[part].path));
        const auto placed = std::find_if(parts_[part].columns.begin(), parts_[part].columns.end(),
                                         [&](const PlacedColumn& one) { return one.column == &column; });
        require(file.read_at(placed->offset + first * column.row_bytes, to));
        std::uint64_t rows_before = 0;
        for (std::size_t before = 0; column.names && before < part; ++before) {
            rows_before += parts_[before].rows[*column.names];
        }
        if (rows_before != 0) {
            shift(to, rows_before);
        }
    }

    /// Indices count from the first part on; -1 names none.
    static void shift(std::span<std::byte> rows, std::uint64_t by) {
        for (std::size_t at = 0; at < rows.size(); at += sizeof by) {
            std::uint64_t index = 0;
            std::memcpy(&index, rows.data() + at, sizeof index);
            if (index != ~std::uint64_t{0}) {
                index += by;
                std::memcpy(rows.data() + at, &index, sizeof index);
            }
        }
    }

    void add(const std::filesystem::path& path, const Parallel& parallel) {
        ReadTree tree = read_tree(require(InputFile::open(path)), path, parallel);
        ArchivePart part{path, std::move(tree.columns), tree.rows, tree.result.info.first_layer};
        std::vector<ArchiveAttribute> attributes = attributes_of(tree.result.info, tree.info);
        if (parts_.empty()) {
            attributes_ = std::move(attributes);
            all_layers_ = tree.result.info.planned_layers;
        } else {
            require_same_attributes(attributes, part);
        }
        parts_.push_back(std::move(part));
    }

    [[noreturn]] void refuse_other(const ArchivePart& part, const std::string& what) const {
        refuse(quoted(part) + " and " + quoted(parts_.front()) + " are not of one slicing: they differ in " + what);
    }

    void require_same_attributes(const std::vector<ArchiveAttribute>& attributes, const ArchivePart& part) const {
        const auto [own, other] =
            std::mismatch(attributes.begin(), attributes.end(), attributes_.begin(), attributes_.end());
        if (own != attributes.end() || other != attributes_.end()) {
            refuse_other(part, (own != attributes.end() ? *own : *other).place());
        }
    }

    /// Options that stand in columns.
    void require_same_rows(const SliceResult& first, const SliceResult& own, const ArchivePart& part) const {
        for (const Column& column : all_columns()) {
            if (is_of_options(column.kind) && rows_in(first, column) != rows_in(own, column)) {
                refuse_other(part, column.path);
            }
        }
    }

    void require_whole() const {
        if (parts_.front().first_layer > 0) {
            refuse(layers_between(0, parts_.front().first_layer) + " are missing before " + quoted(parts_.front()));
        }
        for (std::size_t i = 1; i < parts_.size(); ++i) {
            const ArchivePart& before = parts_[i - 1];
            const ArchivePart& part = parts_[i];
            if (part.first_layer > before.end()) {
                refuse(layers_between(before.end(), part.first_layer) + " lie in neither " + quoted(before) + " nor " +
                       quoted(part));
            }
            if (part.first_layer < before.end()) {
                refuse(quoted(before) + " and " + quoted(part) + " both hold " +
                       layers_between(part.first_layer, std::min(part.end(), before.end())));
            }
        }
        if (parts_.back().end() < all_layers_) {
            refuse(layers_between(parts_.back().end(), all_layers_) + " are missing after " + quoted(parts_.back()));
        }
    }

    std::vector<ArchivePart> parts_;
    std::vector<ArchiveAttribute> attributes_;
    std::uint64_t all_layers_ = 0;
};

}  // namespace

Result<MergedArchive> merge_archives(std::span<const std::filesystem::path> parts, const std::filesystem::path& path,
                                     const Context& context) noexcept {
    return guarded(context, [&]() -> Result<MergedArchive> {
        const Parallel parallel(context);
        parallel.begin_stage(read_share, (tree_runs + load_runs) * parts.size());
        const Parts all(parts, parallel);
        SliceInfo slice;
        MergedArchive merged;
        merged.layers = all.layers();
        merged.hash = all.read(parallel, context.memory, slice, merged.info);
        merged.grid_mm = slice.grid_mm;
        merged.fill_rule = slice.options.region.fill_rule;
        const auto fill = [&](const Column& column, std::uint64_t first, std::span<std::byte> to) {
            all.fill(column, first, to);
        };
        require(write_columns(all.rows(), fill, {attributes_of(slice, merged.info), merged.hash, 0}, path, parallel,
                              read_share));
        return merged;
    });
}

}  // namespace lamella
