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
#include <vector>

#include <hdf5.h>

#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "io/read/input_file.hpp"
#include "lamella/medical/archive.hpp"
#include "medical/hdf5/columns.hpp"

namespace lamella {

// --- HDF5's identifiers as values, and its failures as exceptions

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

// --- the file

/// A column and where its rows lie in the file, one after the other.
struct PlacedColumn {
    const Column* column = nullptr;
    std::uint64_t rows = 0;
    std::uint64_t offset = 0;

    std::uint64_t bytes() const noexcept { return rows * column->row_bytes; }
};

inline constexpr std::string_view archive_format = "lamella archive";
inline constexpr std::uint64_t archive_version = 3;

/// An attribute of a group. Attributes are all of an archive but its columns.
struct ArchiveAttribute {
    std::string group;  ///< path, "/" first
    std::string name;
    NumberType type;    ///< of numbers of 8 bytes; null: a text
    std::string bytes;  ///< of the text or the numbers
    friend bool operator==(const ArchiveAttribute&, const ArchiveAttribute&) = default;

    std::string place() const { return (group == "/" ? "" : group) + "/" + name; }
};

/// An attribute of more numbers does not lie in the header of its group.
inline constexpr std::uint64_t most_uneven_slices = 8000;

/// The last ones, in which the parts of a slicing differ: hash and first layer.
inline constexpr std::size_t attributes_of_part = 2;

/// `hash`: SliceResult::hash() of the layers. Heights and changes of the fill rule stand in columns.
std::vector<ArchiveAttribute> attributes_of(SliceInfo slice, ArchiveInfo info, std::uint64_t hash);

/// The contents of a file.
struct ReadTree {
    SliceResult result;  ///< of read_tree() without its rows
    ArchiveInfo info{};
    std::uint64_t hash = 0;
    std::vector<PlacedColumn> columns{};  ///< all, each within the file, and not more bytes than it has
    KindRows rows{};
};

/// The last line of an archive with such a CRC-32.
std::string closing_line(std::uint32_t crc);

/// The checksum is compared before HDF5 sees the file: damaged ones can make HDF5 leak, or worse. Throws Refused.
ReadTree read_tree(const InputFile& file, const std::filesystem::path& path, const Parallel& parallel,
                   const Memory* memory = nullptr);

/// Reads and checks all of an archive. Throws Refused, Stopped, std::bad_alloc.
ReadTree load_archive(const std::filesystem::path& path, const Parallel& parallel, const Memory* memory);

}  // namespace lamella
