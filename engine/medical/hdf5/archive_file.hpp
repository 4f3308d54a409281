// An archive as a file: the tree of HDF5, rows of columns, and a last line with the checksum of all before it.
//
//     | superblock, groups, attributes | rows of a column | ... | "lamella archive 3, CRC-32 of all before: 5f0c1a77" |
//
// HDF5 makes the tree in a temporary file, where columns have their places but no rows. The archive is that file with the
// rows written in. So an archive goes into a pipe as into a file, and a full disk is met by OutputFile: HDF5 cannot close a
// file after a failure. Reading is the reverse: HDF5 tells where columns lie, and all threads read their rows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "base/function_ref.hpp"
#include "base/parallel.hpp"
#include "io/read/input_file.hpp"
#include "lamella/medical/archive.hpp"
#include "medical/hdf5/columns.hpp"

namespace lamella {

inline constexpr std::string_view archive_format = "lamella archive";
inline constexpr std::uint64_t archive_version = 3;

/// An attribute of a group. Attributes are all of an archive but its columns.
struct ArchiveAttribute {
    std::string group;  ///< path, "/" first
    std::string name;
    std::variant<std::string, std::vector<double>, std::vector<std::uint64_t>> value;
    friend bool operator==(const ArchiveAttribute&, const ArchiveAttribute&) = default;

    std::string place() const { return (group == "/" ? "" : group) + "/" + name; }
};

/// An attribute of more numbers does not lie in the header of its group.
inline constexpr std::uint64_t most_uneven_slices = 8000;

/// The last ones, in which the parts of a slicing differ: hash and first layer.
inline constexpr std::size_t attributes_of_part = 2;

/// `hash`: SliceResult::hash() of the layers.
std::vector<ArchiveAttribute> attributes_of(SliceInfo slice, ArchiveInfo info, std::uint64_t hash);

/// The contents of a file.
struct ReadTree {
    SliceResult result;  ///< of read_tree() without its rows
    ArchiveInfo info{};
    std::uint64_t hash = 0;
    std::vector<PlacedColumn> columns{};  ///< those that are there, each within the file, and not more bytes than it has
    KindRows rows{};
};

/// Sets what attributes_of() takes from the attributes of an open archive, and checks each; heights and changes of the fill
/// rule stand in columns. Throws Refused, with file and place, where one is missing or not as it should be.
void read_attributes(const InputFile& file, hid_t root, ReadTree& tree);

/// Throws Refused: the file is not what it should be at `place`, a path within it.
[[noreturn]] void refuse_place(const InputFile& file, const std::string& place, const std::string& why);

/// Takes rows of a column, one piece after the other.
using RowSink = FunctionRef<void(std::span<const std::byte>)>;

/// `give_rows` puts all rows of a column into the sink. `begun`: the progress so far. Throws Refused, Stopped,
/// std::bad_alloc.
Status write_columns(const KindRows& rows, FunctionRef<void(const Column&, RowSink)> give_rows,
                     const std::vector<ArchiveAttribute>& attributes, const std::filesystem::path& path,
                     const Parallel& parallel, double begun = 0);

/// The last line of an archive with such a CRC-32.
std::string closing_line(std::uint32_t crc);

/// Runs of Parallel that reading takes, for the progress.
inline constexpr std::size_t tree_runs = 1;
inline constexpr std::size_t load_runs = tree_runs + 2;

/// The checksum is compared before HDF5 sees the file: damaged ones can make HDF5 leak, or worse. Throws Refused.
ReadTree read_tree(const InputFile& file, const std::filesystem::path& path, const Parallel& parallel,
                   const Memory* memory = nullptr);

/// Reads and checks all of an archive. Throws Refused, Stopped, std::bad_alloc.
ReadTree load_archive(const std::filesystem::path& path, const Parallel& parallel, const Memory* memory);

}  // namespace lamella
