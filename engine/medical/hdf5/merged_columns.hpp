// The columns of several archives, one after the other, as those of one.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "medical/hdf5/tree.hpp"

namespace lamella {

/// An archive of some layers of a plan.
struct ArchivePart {
    std::filesystem::path path;
    std::vector<PlacedColumn> columns;
    std::uint64_t first_layer = 0;
    std::uint64_t layers = 0;

    std::uint64_t end() const noexcept { return first_layer + layers; }
    std::uint64_t rows(ColumnId id) const noexcept;
};

/// Files are opened for each piece of rows: a thousand parts may be more than a process may have open.
class MergedColumns final : public ColumnSource {
public:
    /// By their layers. They must outlive it.
    explicit MergedColumns(const std::vector<ArchivePart>& parts);
    std::uint64_t rows(ColumnId id) const override;
    void fill(ColumnId id, std::uint64_t first, std::span<std::byte> to) const override;

private:
    /// What comes before a part.
    struct Before {
        std::uint64_t layers = 0;
        std::uint64_t contours = 0;
        std::uint64_t points = 0;
    };

    std::uint64_t own_rows(ColumnId id, std::size_t part) const noexcept;
    void fill_from(std::size_t part, ColumnId id, std::uint64_t first, std::span<std::byte> to) const;

    const std::vector<ArchivePart>& parts_;
    std::vector<Before> before_;  ///< of each part
};

}  // namespace lamella
