// Float soups in blocks of 64 triangles, sixteen at a time with AVX-512: the planes that cut them, and their records. Other
// meshes and processors take one triangle at a time, with the same result.
#pragma once

#include <cstddef>
#include <cstdint>

#include "lamella/mesh.hpp"
#include "slicing/buckets/crossed_triangle.hpp"
#include "slicing/buckets/thread_shares.hpp"
#include "slicing/grid/bounds.hpp"
#include "slicing/planes/plane_set.hpp"

namespace lamella {

class SoupScan {
public:
    SoupScan(const MeshView& mesh, const Placing& placing, double unit_mm, const PlaneSet& planes) noexcept;

    /// True where this processor and mesh allow it.
    bool usable() const noexcept { return kernels_ != nullptr; }

    /// Planes from first[t] up to, but not with, last[t] cut triangle t.
    struct Ranges {
        PlaneIndex first[block_triangles];
        PlaneIndex last[block_triangles];
    };
    /// Triangles [begin, begin + 64), all of which must exist; returns which of them planes cut. Precondition: usable().
    std::uint64_t ranges(std::size_t begin, Ranges& ranges) const noexcept { return kernels_->ranges(*this, begin, ranges); }

    /// Where records were written.
    struct Written {
        std::uint32_t record[block_triangles];
        PlaneIndex first[block_triangles];
        PlaneIndex last[block_triangles];
    };
    /// Writes a record for each triangle begin + t with bit t in `crossed`, as ShareRecords::write_each() does; returns
    /// which of them reach as far as reach_end[its first plane]. Precondition: usable().
    std::uint64_t write(std::size_t begin, std::uint64_t crossed, const ShareRecords& to, Written& written) const noexcept {
        return kernels_->write(*this, begin, crossed, to, written);
    }

    /// Writes a record with its first plane for each triangle begin + t with bit t in `wanted` that planes cut, one after
    /// the other; returns how many. Precondition: usable().
    std::size_t append(std::size_t begin, std::uint64_t wanted, CrossedTriangle* records) const noexcept {
        return kernels_->append(*this, begin, wanted, records);
    }

private:
    friend struct SoupKernel;
    struct Kernels {
        std::uint64_t (*ranges)(const SoupScan& scan, std::size_t begin, Ranges& ranges);
        std::uint64_t (*write)(const SoupScan& scan, std::size_t begin, std::uint64_t crossed, const ShareRecords& to,
                               Written& written);
        std::size_t (*append)(const SoupScan& scan, std::size_t begin, std::uint64_t wanted, CrossedTriangle* records);
    };
    static const Kernels* kernels() noexcept;

    const std::byte* vertices_;
    std::int32_t stride_;
    float scale_;  // mm to half grid units
    const PlaneSet& planes_;
    float planes_per_unit_ = 0;         // 0: planes are found by the table
    const Kernels* kernels_ = nullptr;  // null: not usable
};

}  // namespace lamella
