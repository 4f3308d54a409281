// The tree of groups, datasets and attributes of an archive, without the rows of its columns.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "io/read/input_file.hpp"
#include "medical/hdf5/columns.hpp"
#include "medical/hdf5/facts.hpp"

namespace lamella {

/// A column and where its rows lie in the file, one after the other.
struct PlacedColumn {
    ColumnId id{};
    std::uint64_t rows = 0;
    std::uint64_t offset = 0;
    std::uint32_t crc = 0;  ///< CRC-32 of the rows, as zlib has it

    std::uint64_t bytes() const noexcept { return rows * column_of(id).row_bytes(); }
};

/// What stands in attributes.
struct ArchiveHead {
    std::vector<Fact> facts;
    std::uint64_t hash = 0;  ///< hash_result()
    std::uint64_t first_layer = 0;
};

/// The first bytes of an archive, all that does not belong to columns. Columns follow, one directly after the other; their
/// offsets are set. Throws Refused, std::bad_alloc.
std::vector<std::byte> make_tree(const ArchiveHead& head, std::vector<PlacedColumn>& columns);

/// What the tree of a file says.
struct ReadTree {
    SliceResult result;  ///< without its rows
    ArchiveInfo info;
    std::uint64_t hash = 0;
    std::vector<PlacedColumn> columns;  ///< those that are there, each within the file, and not more bytes than it has
};

/// The tree is checked before HDF5 sees it: damaged ones can make HDF5 leak, or worse. Throws Refused.
ReadTree read_tree(const InputFile& file, const Memory* memory);

/// Throws Refused: the file is not what it should be at `place`, a path within it.
[[noreturn]] void refuse_place(const InputFile& file, const std::string& place, const std::string& why);

}  // namespace lamella
