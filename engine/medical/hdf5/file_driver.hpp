// HDF5 without files of its own: what it writes and reads goes through a Backing. So HDF5 locks no file, no failure of a
// disk happens within it (after one it could not close the file any more), what is written goes through OutputFile, and the
// rows of columns come to lie behind all of HDF5's own structures.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>

#include "medical/hdf5/handles.hpp"

namespace lamella {

/// Bytes that HDF5 takes for a file.
class Backing {
public:
    virtual std::uint64_t size() const noexcept = 0;
    /// What lies beyond the end reads as zeros. False where it cannot be read.
    virtual bool read(std::uint64_t offset, std::span<std::byte> into) noexcept = 0;
    virtual bool write(std::uint64_t offset, std::span<const std::byte> bytes) noexcept = 0;
    virtual void set_size(std::uint64_t bytes) noexcept = 0;

protected:
    ~Backing() = default;
};

/// A file of which only some pages are ever written: HDF5's own structures.
class SparseFile final : public Backing {
public:
    std::uint64_t size() const noexcept override { return size_; }
    bool read(std::uint64_t offset, std::span<std::byte> into) noexcept override;
    /// Never fails, so that HDF5 can close the file; failed() tells whether memory was missing.
    bool write(std::uint64_t offset, std::span<const std::byte> bytes) noexcept override;
    void set_size(std::uint64_t bytes) noexcept override { size_ = bytes; }
    bool failed() const noexcept { return failed_; }
    /// Where the last page that begins before `end` ends.
    std::uint64_t written_before(std::uint64_t end) const noexcept;

private:
    static constexpr std::size_t page_bytes = 4096;
    using Page = std::array<std::byte, page_bytes>;

    std::map<std::uint64_t, std::unique_ptr<Page>> pages_;
    std::uint64_t size_ = 0;
    bool failed_ = false;
};

/// A file to be read, of which HDF5 is shown the first bytes; the others are zeros to it.
class ReadOnlyFile final : public Backing {
public:
    ReadOnlyFile(std::span<const std::byte> begin, std::uint64_t size) : begin_(begin), size_(size) {}
    std::uint64_t size() const noexcept override { return size_; }
    bool read(std::uint64_t offset, std::span<std::byte> into) noexcept override;
    bool write(std::uint64_t, std::span<const std::byte>) noexcept override { return false; }
    void set_size(std::uint64_t) noexcept override {}

private:
    std::span<const std::byte> begin_;
    std::uint64_t size_;
};

/// A list of access properties by which HDF5 reads and writes a Backing.
class BackedAccess {
public:
    /// Throws Refused.
    /// `columns_begin`: where the rows of columns that are made begin; all else has to lie before.
    explicit BackedAccess(Backing& backing, std::uint64_t columns_begin = 0);
    hid_t properties() const noexcept { return properties_.id(); }

private:
    Handle driver_;
    Handle properties_;
};

}  // namespace lamella
