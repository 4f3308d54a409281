// Columns in blocks of rows: what a thread works on, and what is checked and written at once.
#pragma once

#include <cstdint>
#include <vector>

#include "base/parallel.hpp"
#include "medical/hdf5/tree.hpp"

namespace lamella {

inline constexpr std::size_t block_bytes_of_column = std::size_t{1} << 20;

/// Rows of one column.
struct ColumnBlock {
    std::size_t column = 0;  ///< index among those listed
    std::uint64_t first = 0;
    std::uint64_t rows = 0;
    std::uint32_t crc = 0;
};

/// Column by column, from the first row on.
std::vector<ColumnBlock> blocks_of(const std::vector<PlacedColumn>& columns);

/// The checksum of each column, from those of its blocks.
std::vector<std::uint32_t> joined_checksums(const std::vector<PlacedColumn>& columns,
                                            const std::vector<ColumnBlock>& blocks);

std::uint32_t checksum_of(std::span<const std::byte> bytes) noexcept;

}  // namespace lamella
