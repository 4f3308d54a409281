#include "medical/hdf5/merged_columns.hpp"

#include <algorithm>
#include <cstring>

#include "base/guard.hpp"

namespace lamella {

namespace {

/// The same in all parts.
bool is_shared(ColumnKind kind) {
    return kind == ColumnKind::height || kind == ColumnKind::fill_change;
}

bool has_end(ColumnKind kind) {
    return kind == ColumnKind::layer_end || kind == ColumnKind::contour_end;
}

/// Indices count from the first part on; -1 names none.
void shift(std::span<std::byte> rows, std::uint64_t by) {
    for (std::size_t at = 0; by != 0 && at < rows.size(); at += sizeof by) {
        std::uint64_t index = 0;
        std::memcpy(&index, rows.data() + at, sizeof index);
        if (index != ~std::uint64_t{0}) {
            index += by;
            std::memcpy(rows.data() + at, &index, sizeof index);
        }
    }
}

}  // namespace

std::uint64_t ArchivePart::rows(ColumnId id) const noexcept {
    const auto found =
        std::find_if(columns.begin(), columns.end(), [id](const PlacedColumn& column) { return column.id == id; });
    return found == columns.end() ? 0 : found->rows;
}

MergedColumns::MergedColumns(const std::vector<ArchivePart>& parts) : parts_(parts) {
    Before before;
    for (const ArchivePart& part : parts) {
        before_.push_back(before);
        before.layers += part.layers;
        before.contours += part.rows(ColumnId::parent);
        before.points += part.rows(ColumnId::points);
    }
}

/// The last row of an end stands in the last part.
std::uint64_t MergedColumns::own_rows(ColumnId id, std::size_t part) const noexcept {
    const ColumnKind kind = column_of(id).kind;
    if (is_shared(kind) && part > 0) {
        return 0;
    }
    return parts_[part].rows(id) - (has_end(kind) && part + 1 < parts_.size() ? 1 : 0);
}

std::uint64_t MergedColumns::rows(ColumnId id) const {
    std::uint64_t sum = 0;
    for (std::size_t part = 0; part < parts_.size(); ++part) {
        sum += own_rows(id, part);
    }
    return sum;
}

void MergedColumns::fill(ColumnId id, std::uint64_t first, std::span<std::byte> to) const {
    const std::size_t row_bytes = column_of(id).row_bytes();
    for (std::size_t part = 0; part < parts_.size() && !to.empty(); ++part) {
        const std::uint64_t rows = own_rows(id, part);
        if (first >= rows) {
            first -= rows;
            continue;
        }
        const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(rows - first, to.size() / row_bytes));
        fill_from(part, id, first, to.first(count * row_bytes));
        to = to.subspan(count * row_bytes);
        first = 0;
    }
}

void MergedColumns::fill_from(std::size_t part, ColumnId id, std::uint64_t first, std::span<std::byte> to) const {
    const Result<InputFile> file = InputFile::open(parts_[part].path);
    if (!file) {
        throw Refused{file.error()};
    }
    const auto& columns = parts_[part].columns;
    const auto column =
        std::find_if(columns.begin(), columns.end(), [id](const PlacedColumn& placed) { return placed.id == id; });
    if (const Status read = file->read_at(column->offset + first * column_of(id).row_bytes(), to); !read) {
        throw Refused{read.error()};
    }
    const Before& before = before_[part];
    if (id == ColumnId::first_contour || id == ColumnId::parent) {
        shift(to, before.contours);
    } else if (id == ColumnId::first_point) {
        shift(to, before.points);
    } else if (id == ColumnId::gap_layer) {
        shift(to, before.layers);
    }
}

}  // namespace lamella
