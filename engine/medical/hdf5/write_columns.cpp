#include "medical/hdf5/write_columns.hpp"

#include <algorithm>

#include "io/write/output_file.hpp"
#include "medical/hdf5/blocks.hpp"

namespace lamella {

namespace {

/// Without places and checksums.
std::vector<PlacedColumn> columns_of(const ColumnSource& source) {
    std::vector<PlacedColumn> columns;
    for_each_column([&](ColumnId id) {
        const std::uint64_t rows = source.rows(id);
        if (rows > 0 || !column_of(id).optional) {
            columns.push_back({id, rows, 0, 0});
        }
    });
    return columns;
}

void sum_up(const ColumnSource& source, std::vector<PlacedColumn>& columns, const Parallel& parallel) {
    std::vector<ColumnBlock> blocks = blocks_of(columns);
    std::vector<std::vector<std::byte>> rooms(static_cast<std::size_t>(parallel.threads()));
    parallel.run(blocks.size(), [&](std::size_t i, int worker) {
        const PlacedColumn& column = columns[blocks[i].column];
        std::vector<std::byte>& room = rooms[static_cast<std::size_t>(worker)];
        room.resize(blocks[i].rows * column_of(column.id).row_bytes());
        source.fill(column.id, blocks[i].first, room);
        blocks[i].crc = checksum_of(room);
    });
    const std::vector<std::uint32_t> sums = joined_checksums(columns, blocks);
    for (std::size_t i = 0; i < columns.size(); ++i) {
        columns[i].crc = sums[i];
    }
}

/// Appends the rows of a column, block by block.
class RowWriter {
public:
    /// Of so many bytes, the progress being `begun`.
    RowWriter(const ColumnSource& source, OutputFile& file, std::uint64_t bytes, const Parallel& parallel, double begun)
        : source_(source), file_(file), bytes_(static_cast<double>(bytes)), parallel_(parallel), begun_(begun) {}

    void write(const PlacedColumn& column) {
        const std::size_t row_bytes = column_of(column.id).row_bytes();
        for (std::uint64_t first = 0; first < column.rows && !file_.failed();) {
            parallel_.stop_if_asked();
            const std::uint64_t count = std::min<std::uint64_t>(OutputFile::buffer_bytes / row_bytes, column.rows - first);
            char* const room = file_.room(count * row_bytes);
            source_.fill(column.id, first, {reinterpret_cast<std::byte*>(room), count * row_bytes});
            file_.advance(room + count * row_bytes);
            written_ += static_cast<double>(count * row_bytes);
            first += count;
            parallel_.reach(begun_ + (1 - begun_) * written_ / bytes_);
        }
    }

private:
    const ColumnSource& source_;
    OutputFile& file_;
    double bytes_;
    const Parallel& parallel_;
    double begun_;
    double written_ = 0;
};

}  // namespace

Status write_columns(const ColumnSource& source, const ArchiveHead& head, const std::filesystem::path& path,
                     const Parallel& parallel, double begun) {
    Result<OutputFile> file = OutputFile::create(path);  // first: what cannot be written is refused at once
    if (!file) {
        return file.error();
    }
    std::vector<PlacedColumn> columns = columns_of(source);
    const double summed_up = begun + (1 - begun) * 0.4;
    parallel.begin_stage(summed_up);
    sum_up(source, columns, parallel);
    const std::vector<std::byte> tree = make_tree(head, columns);
    file->append({reinterpret_cast<const char*>(tree.data()), tree.size()});
    std::uint64_t bytes = 0;
    for (const PlacedColumn& column : columns) {
        bytes += column.bytes();
    }
    RowWriter rows(source, *file, bytes, parallel, summed_up);
    for (const PlacedColumn& column : columns) {
        rows.write(column);
    }
    Status written = file->commit();
    if (written) {
        parallel.finish();
    }
    return written;
}

}  // namespace lamella
