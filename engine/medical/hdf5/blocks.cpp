#include "medical/hdf5/blocks.hpp"

#include <algorithm>

#include <zlib.h>

namespace lamella {

std::vector<ColumnBlock> blocks_of(const std::vector<PlacedColumn>& columns) {
    std::vector<ColumnBlock> blocks;
    for (std::size_t i = 0; i < columns.size(); ++i) {
        const std::uint64_t at_once = block_bytes_of_column / column_of(columns[i].id).row_bytes();
        for (std::uint64_t first = 0; first < columns[i].rows; first += at_once) {
            blocks.push_back({i, first, std::min(at_once, columns[i].rows - first), 0});
        }
    }
    return blocks;
}

std::vector<std::uint32_t> joined_checksums(const std::vector<PlacedColumn>& columns,
                                            const std::vector<ColumnBlock>& blocks) {
    std::vector<std::uint32_t> sums(columns.size());
    for (const ColumnBlock& block : blocks) {
        const std::uint64_t bytes = block.rows * column_of(columns[block.column].id).row_bytes();
        std::uint32_t& sum = sums[block.column];
        sum = block.first == 0 ? block.crc
                               : static_cast<std::uint32_t>(::crc32_combine(sum, block.crc, static_cast<z_off_t>(bytes)));
    }
    return sums;
}

std::uint32_t checksum_of(std::span<const std::byte> bytes) noexcept {
    return static_cast<std::uint32_t>(::crc32_z(0, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()));
}

}  // namespace lamella
