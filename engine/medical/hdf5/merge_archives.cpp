#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

#include "base/guard.hpp"
#include "base/words.hpp"
#include "lamella/medical/archive.hpp"
#include "medical/hdf5/archive_file.hpp"
#include "slicing/result/hash.hpp"

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

/// Heights and fill rules are the same in all parts.
bool is_shared(ColumnKind kind) {
    return kind == ColumnKind::height || kind == ColumnKind::fill_change;
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

/// The columns of several archives, one after the other, as those of one. Files are opened for each piece of rows: a
/// thousand parts may be more than a process may have open.
class MergedColumns final : public ColumnSource {
public:
    /// By their layers. They must outlive it.
    explicit MergedColumns(const std::vector<ArchivePart>& parts) : parts_(parts) {}

    KindRows rows() const override {
        KindRows sums;
        for (const Column& column : all_columns()) {
            sums[column.kind] = 0;
            for (std::size_t part = 0; part < parts_.size(); ++part) {
                sums[column.kind] += own_rows(column.kind, part);
            }
        }
        return sums;
    }

    void fill(const Column& column, std::uint64_t first, std::span<std::byte> to) const override {
        for (std::size_t part = 0; part < parts_.size() && !to.empty(); ++part) {
            const std::uint64_t rows = own_rows(column.kind, part);
            if (first >= rows) {
                first -= rows;
                continue;
            }
            const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(rows - first, to.size() / column.row_bytes));
            fill_from(part, column, first, to.first(count * column.row_bytes));
            to = to.subspan(count * column.row_bytes);
            first = 0;
        }
    }

private:
    /// Shared rows are those of the first part; the last row of an end stands in the last part.
    std::uint64_t own_rows(ColumnKind kind, std::size_t part) const noexcept {
        if (part > 0 && is_shared(kind)) {
            return 0;
        }
        const bool has_end = kind == ColumnKind::layer_end || kind == ColumnKind::contour_end;
        return parts_[part].rows[kind] - (has_end && part + 1 < parts_.size() ? 1 : 0);
    }

    void fill_from(std::size_t part, const Column& column, std::uint64_t first, std::span<std::byte> to) const {
        const Result<InputFile> file = InputFile::open(parts_[part].path);
        if (!file) {
            throw Refused{file.error()};
        }
        const auto placed = std::find_if(parts_[part].columns.begin(), parts_[part].columns.end(),
                                         [&](const PlacedColumn& one) { return one.column == &column; });
        if (const Status read = file->read_at(placed->offset + first * column.row_bytes, to); !read) {
            throw Refused{read.error()};
        }
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

    const std::vector<ArchivePart>& parts_;
};

/// Parts of one slicing, by their layers.
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

    const std::vector<ArchivePart>& all() const noexcept { return parts_; }
    std::uint64_t layers() const noexcept { return all_layers_; }

    /// Reads and checks all rows; the hash of the whole. The head of the first part goes to `head`.
    std::uint64_t read(const Parallel& parallel, const Memory* memory, ReadTree& head) const {
        ResultHash hash(all_layers_);
        for (const ArchivePart& part : parts_) {
            ReadTree loaded = load_archive(part.path, parallel, memory);
            hash.add_layers(loaded.result);
            if (&part == &parts_.front()) {
                drop_rows(loaded.result);
                head = std::move(loaded);
            } else {
                require_same(head, loaded, part);
            }
        }
        return hash.value();
    }

private:
    void add(const std::filesystem::path& path, const Parallel& parallel) {
        const Result<InputFile> file = InputFile::open(path);
        if (!file) {
            throw Refused{file.error()};
        }
        ReadTree tree = read_tree(*file, path, parallel, nullptr);
        ArchivePart part{path, std::move(tree.columns), tree.rows, tree.result.first_layer};
        std::vector<Fact> facts = facts_of(tree.result, tree.info);
        if (parts_.empty()) {
            facts_ = std::move(facts);
            all_layers_ = tree.result.all_layers;
        } else {
            require_same_facts(facts, part);
        }
        if (part.first_layer > all_layers_ || part.rows[ColumnKind::layer] > all_layers_ - part.first_layer) {
            throw Refused{file->error(ErrorCode::malformed_mesh, "/all_layers: fewer layers than the file has")};
        }
        parts_.push_back(std::move(part));
    }

    [[noreturn]] void refuse_other(const ArchivePart& part, const std::string& what) const {
        refuse(quoted(part) + " and " + quoted(parts_.front()) + " are not of one slicing: they differ in " + what);
    }

    void require_same_facts(const std::vector<Fact>& facts, const ArchivePart& part) const {
        const auto [own, other] = std::mismatch(facts.begin(), facts.end(), facts_.begin(), facts_.end());
        if (own != facts.end() || other != facts_.end()) {
            const Fact& fact = own != facts.end() ? *own : *other;
            refuse_other(part, (fact.group == "/" ? "" : fact.group) + "/" + fact.name);
        }
    }

    /// Heights and rules that stand in columns.
    void require_same(const ReadTree& head, const ReadTree& tree, const ArchivePart& part) const {
        for (const Column& column : all_columns()) {
            if (is_shared(column.kind) && rows_as_bytes(head.result, column) != rows_as_bytes(tree.result, column)) {
                refuse_other(part, column.path);
            }
        }
    }

    static std::vector<std::byte> rows_as_bytes(const SliceResult& result, const Column& column) {
        std::vector<std::byte> bytes(rows_of(result)[column.kind] * column.row_bytes);
        column.get(result, 0, bytes);
        return bytes;
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
        require_origins();
    }

    void require_origins() const {
        const auto with = std::find_if(parts_.begin(), parts_.end(),
                                       [](const ArchivePart& part) { return part.rows[ColumnKind::origin] > 0; });
        const auto without = std::find_if(parts_.begin(), parts_.end(), [](const ArchivePart& part) {
            return part.rows[ColumnKind::origin] < part.rows[ColumnKind::point];
        });
        if (with != parts_.end() && without != parts_.end()) {
            refuse(quoted(*without) + " has no origins of its points, which " + quoted(*with) + " has");
        }
    }

    static void drop_rows(SliceResult& result) {
        result.layers = Array<Layer>();
        result.contours = Array<Contour>();
        result.points = Array<Point>();
        result.origins = Array<PointOrigin>();
        result.closed_gaps = Array<ClosedGap>();
    }

    std::vector<ArchivePart> parts_;
    std::vector<Fact> facts_;
    std::uint64_t all_layers_ = 0;
};

}  // namespace

Result<MergedArchive> merge_archives(std::span<const std::filesystem::path> parts, const std::filesystem::path& path,
                                     const Control& control) noexcept {
    return guarded(control, [&]() -> Result<MergedArchive> {
        Parallel parallel(control);
        parallel.begin_stage(read_share, (tree_runs + load_runs) * parts.size());
        const Parts all(parts, parallel);
        ReadTree head{.result = SliceResult(), .info = {}};
        const std::uint64_t hash = all.read(parallel, control.memory, head);
        const Status written =
            write_columns(MergedColumns(all.all()), {facts_of(head.result, head.info), hash, 0}, path, parallel, read_share);
        if (!written) {
            return written.error();
        }
        return MergedArchive{all.layers(), hash, head.result.unit_mm, head.result.region.fill_rule, std::move(head.info)};
    });
}

}  // namespace lamella
