#include <algorithm>
#include <array>
#include <cstdio>
#include <span>
#include <utility>

#include <zlib.h>

#include "base/guard.hpp"
#include "base/words.hpp"
#include "io/write/output_file.hpp"
#include "lamella/medical/archive.hpp"
#include "medical/hdf5/archive_file.hpp"

namespace lamella {

namespace {

constexpr std::size_t longest_name = 4096;

void require_possible(const SliceResult& result, const ArchiveInfo& info, const std::filesystem::path& path) {
    const auto refuse = [&](const std::string& why) {
        throw Refused{{ErrorCode::invalid_argument, "'" + path.string() + "': " + why}};
    };
    if (result.first_layer > result.all_layers || result.layers.size() > result.all_layers - result.first_layer) {
        refuse("a result of " + counted(result.layers.size(), "layer") + " from layer " +
               std::to_string(result.first_layer) + " on, of " + std::to_string(result.all_layers) + " in all");
    }
    if (info.name.size() > longest_name || info.mesh_sha256.size() > longest_name) {
        refuse("an archive's name of the mesh has at most " + std::to_string(longest_name) + " bytes");
    }
    if (result.layer_of.size() != rows_of(result, ColumnKind::height)) {
        refuse("the result does not tell the layers of its planes");
    }
    if (info.geometry && info.geometry->uneven_slices_mm.size() > most_uneven_slices) {
        refuse("an image of more than " + std::to_string(most_uneven_slices) + " uneven slices");
    }
}

class ResultColumns final : public ColumnSource {
public:
    explicit ResultColumns(const SliceResult& result) : result_(result) {}
    std::uint64_t rows(ColumnId id) const override { return rows_of(result_, column_of(id).kind); }
    void fill(ColumnId id, std::uint64_t first, std::span<std::byte> to) const override {
        column_of(id).get(result_, first, to);
    }

private:
    const SliceResult& result_;
};

/// Without places.
std::vector<PlacedColumn> columns_of(const ColumnSource& source) {
    std::vector<PlacedColumn> columns;
    for_each_column([&](ColumnId id) {
        const std::uint64_t rows = source.rows(id);
        if (rows > 0 || !column_of(id).optional) {
            columns.push_back({id, rows, 0});
        }
    });
    return columns;
}

/// Appends pieces of the tree and rows of columns in the order of the file, and sums them up.
class ArchiveWriter {
public:
    /// The progress being `begun`.
    ArchiveWriter(OutputFile& file, const InputFile& tree, const Parallel& parallel, double begun)
        : file_(file), tree_(tree), parallel_(parallel), begun_(begun) {}

    /// From where the file ends so far to `end`.
    void write_tree(std::uint64_t end) {
        write(end, 1, [&](std::uint64_t at, std::span<std::byte> to) {
            if (const Status read = tree_.read_at(at, to); !read) {
                throw Refused{read.error()};
            }
        });
    }

    void write_rows(const ColumnSource& source, const PlacedColumn& column) {
        const std::size_t row_bytes = column_of(column.id).row_bytes;
        write(column.offset + column.bytes(), row_bytes, [&](std::uint64_t at, std::span<std::byte> to) {
            source.fill(column.id, (at - column.offset) / row_bytes, to);
        });
    }

    Status finish() {
        file_.append(closing_line(static_cast<std::uint32_t>(crc_)));
        return file_.commit();
    }

private:
    /// By pieces of whole items, which `fill` gives: their place in the file, and where they go.
    template <class Fill>
    void write(std::uint64_t end, std::size_t item_bytes, Fill fill) {
        const std::uint64_t most = rows_at_once_bytes / item_bytes * item_bytes;
        while (at_ < end && !file_.failed()) {
            parallel_.stop_if_asked();
            const auto count = static_cast<std::size_t>(std::min(most, end - at_));
            char* const room = file_.room(count);
            fill(at_, {reinterpret_cast<std::byte*>(room), count});
            crc_ = ::crc32_z(crc_, reinterpret_cast<const unsigned char*>(room), count);
            file_.advance(room + count);
            at_ += count;
            parallel_.reach(begun_ + (1 - begun_) * static_cast<double>(at_) / static_cast<double>(tree_.size()));
        }
    }

    OutputFile& file_;
    const InputFile& tree_;
    const Parallel& parallel_;
    double begun_;
    std::uint64_t at_ = 0;
    uLong crc_ = 0;
};

}  // namespace

std::string closing_line(std::uint32_t crc) {
    std::array<char, 9> digits{};
    (void)std::snprintf(digits.data(), digits.size(), "%08x", crc);
    return "\n" + std::string(archive_format) + " " + std::to_string(archive_version) +
           ", CRC-32 of all before: " + digits.data() + "\n";
}

Status write_columns(const ColumnSource& source, const ArchiveHead& head, const std::filesystem::path& path,
                     const Parallel& parallel, double begun) {
    Result<OutputFile> file = OutputFile::create(path);  // first: what cannot be written is refused at once
    if (!file) {
        return file.error();
    }
    std::vector<PlacedColumn> columns = columns_of(source);
    const InputFile tree = make_tree(head, columns);
    std::erase_if(columns, [](const PlacedColumn& column) { return column.rows == 0; });
    std::sort(columns.begin(), columns.end(),
              [](const PlacedColumn& a, const PlacedColumn& b) { return a.offset < b.offset; });
    parallel.begin_stage(1);
    ArchiveWriter writer(*file, tree, parallel, begun);
    for (const PlacedColumn& column : columns) {
        writer.write_tree(column.offset);
        writer.write_rows(source, column);
    }
    writer.write_tree(tree.size());
    Status written = writer.finish();
    if (written) {
        parallel.finish();
    }
    return written;
}

bool has_archives() noexcept {
    return true;
}

Status write_archive(const SliceResult& result, const ArchiveInfo& info, const std::filesystem::path& path,
                     const Control& control) noexcept {
    return guarded(control, [&]() -> Status {
        Parallel parallel(control);
        require_possible(result, info, path);
        return write_columns(ResultColumns(result), {facts_of(result, info), hash_result(result), result.first_layer}, path,
                             parallel);
    });
}

}  // namespace lamella
