// An archive as a file: the tree of HDF5, rows of columns, and a last line with the checksum of all before it.
//
//     | superblock, groups, attributes | rows of a column | ... | "lamella archive 3, CRC-32 of all before: 5f0c1a77" |
//
// HDF5 makes the tree in a temporary file, where columns have their places but no rows. The archive is that file with the
// rows written in. So an archive goes into a pipe as into a file, and a full disk is met by OutputFile: HDF5 cannot close a
// file after a failure. Reading is the reverse: HDF5 tells where columns lie, and all threads read their rows.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include <hdf5.h>

#include "base/function_ref.hpp"
#include "base/guard.hpp"
#include "base/little_endian.hpp"
#include "base/parallel.hpp"
#include "io/read/input_file.hpp"
#include "lamella/medical/archive.hpp"

namespace lamella {

// --- HDF5's identifiers as values, its failures as exceptions, and its names of number types

/// While it lives, HDF5 prints nothing of its errors.
class QuietErrors {
public:
    QuietErrors() noexcept {
        H5Eget_auto2(H5E_DEFAULT, &print_, &context_);
        H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    }
    ~QuietErrors() { H5Eset_auto2(H5E_DEFAULT, print_, context_); }
    QuietErrors(const QuietErrors&) = delete;
    QuietErrors& operator=(const QuietErrors&) = delete;

private:
    H5E_auto2_t print_ = nullptr;
    void* context_ = nullptr;
};

/// For calls that fail only where memory or the disk of a temporary file ends.
inline void checked(herr_t status) {
    if (status < 0) {
        throw Refused{{ErrorCode::out_of_memory, "HDF5 fails: no memory, or no space for a temporary file"}};
    }
}

/// Owns an identifier.
class Handle {
public:
    /// Throws Refused where there is none.
    Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) { checked(id < 0 ? -1 : 0); }
    Handle(const Handle&) = delete;
    Handle& operator=(const Handle&) = delete;
    ~Handle() { close_(id_); }

    hid_t id() const noexcept { return id_; }

private:
    hid_t id_;
    herr_t (*close_)(hid_t);
};

/// How files are opened: as plain files whatever the environment says, and never locked, which file systems of clusters may
/// refuse.
inline hid_t plain_file_access() {
    const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    checked(H5Pset_fapl_sec2(access));
#if H5_VERSION_GE(1, 12, 1) || (H5_VERSION_GE(1, 10, 7) && !H5_VERSION_GE(1, 12, 0))
    checked(H5Pset_file_locking(access, false, true));
#endif
    return access;
}

/// Little-endian, as hosts are.
template <class Number>
hid_t hdf5_type() {
    if constexpr (std::is_same_v<Number, double>) {
        return H5T_IEEE_F64LE;
    } else {
        const std::array<hid_t, 4> types = std::is_signed_v<Number>
                                               ? std::array{H5T_STD_I8LE, H5T_STD_I16LE, H5T_STD_I32LE, H5T_STD_I64LE}
                                               : std::array{H5T_STD_U8LE, H5T_STD_U16LE, H5T_STD_U32LE, H5T_STD_U64LE};
        return types[static_cast<std::size_t>(std::countr_zero(sizeof(Number)))];
    }
}

// --- which datasets there are, and which member of a result each holds

/// The things that a column has a row for: columns of one kind are equally long.
enum ColumnKind : std::uint8_t {
    layer_rows,
    contour_rows,
    point_rows,
    origin_rows,
    stitch_rows,
    height_rows,
    fill_change_rows
};

/// How many rows the columns of each kind have.
using KindRows = std::array<std::uint64_t, fill_change_rows + 1>;

struct Column {
    const char* path;
    ColumnKind kind;
    hid_t (*type)();    ///< of its numbers
    std::size_t width;  ///< numbers a row
    std::size_t row_bytes;
    const char* unit;
    const char* meaning;  ///< or ""
    /// Rows from `first` on, as they lie in the file.
    void (*get)(const SliceResult& result, std::uint64_t first, std::span<std::byte> to);
    /// Takes rows into `result`, whose arrays are large enough: how many are in their range before one that is not. Null
    /// where all follows from other columns, and stands in the file for other programs.
    std::uint64_t (*set)(SliceResult& result, std::uint64_t first, std::span<const std::byte> from);
    std::optional<ColumnKind> names;  ///< its numbers are indices of such rows
    bool has_end = false;             ///< a last row tells where the last layer or contour ends

    /// Left out where there are no rows.
    bool is_optional() const noexcept { return kind > point_rows; }
    std::uint64_t rows_among(const KindRows& rows) const noexcept { return rows[kind] + (has_end ? 1 : 0); }
};

/// Those of one kind stand side by side.
std::span<const Column> all_columns() noexcept;

/// A column and where its rows lie in the file, one after the other.
struct PlacedColumn {
    const Column* column = nullptr;
    std::uint64_t rows = 0;
    std::uint64_t offset = 0;

    std::uint64_t bytes() const noexcept { return rows * column->row_bytes; }
};

/// Rows of a column that are worked on at once: about a MiB.
struct RowRange {
    std::uint64_t first = 0;
    std::size_t count = 0;
};
std::vector<RowRange> ranges_of(std::uint64_t rows, const Column& column);

KindRows rows_of(const SliceResult& result) noexcept;

/// Arrays of so many rows, their contents unspecified; heights only where the options have some.
void resize(SliceResult& result, const KindRows& rows);

// --- the file

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
    std::vector<PlacedColumn> columns{};  ///< all, each within the file, and not more bytes than it has
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
void write_columns(const KindRows& rows, FunctionRef<void(const Column&, RowSink)> give_rows,
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
