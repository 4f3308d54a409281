// The triangles that planes cut and that are not done with, in memory.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "lamella/array.hpp"
#include "lamella/mesh.hpp"
#include "slicing/planes/plane_set.hpp"

namespace lamella {

/// As in the file, and the planes that cut it: from `first` up to, but not with, `last`.
struct StoredTriangle {
    std::byte corners[9 * sizeof(float)];  ///< coordinates, or three indices of 32 bits
    PlaneIndex first;
    PlaneIndex last;
};
static_assert(sizeof(StoredTriangle) == 44, "the memory model counts 44 bytes");

class TriangleStore {
public:
    explicit TriangleStore(const Memory* memory) : triangles_(memory) {}

    /// Empties it and makes it hold up to `capacity` triangles. Throws std::bad_alloc.
    void reserve(std::size_t capacity) {
        clear();
        triangles_ = Array<StoredTriangle>(triangles_.memory());  // never two at once
        triangles_.resize_discarding(capacity);
    }

    /// From any thread. Precondition: there is room.
    void append(std::span<const StoredTriangle> some) noexcept {
        const std::size_t at = size_.fetch_add(some.size(), std::memory_order_relaxed);
        if (!some.empty()) {
            std::memcpy(triangles_.data() + at, some.data(), some.size_bytes());
        }
    }
    /// Drops what no plane from `plane` on cuts. O(size).
    void drop_below(PlaneIndex plane) noexcept {
        std::size_t kept = 0;
        for (std::size_t i = 0, end = size(); i < end; ++i) {
            if (triangles_[i].last > plane) {
                triangles_[kept++] = triangles_[i];
            }
        }
        size_ = kept;
    }
    void clear() noexcept { size_ = 0; }

    std::size_t size() const noexcept { return size_.load(std::memory_order_relaxed); }
    std::size_t room() const noexcept { return triangles_.size() - size(); }
    std::size_t capacity() const noexcept { return triangles_.size(); }
    std::span<const StoredTriangle> triangles() const noexcept { return triangles_.span().first(size()); }

    /// `vertices`: those that indices name, or none where triangles hold coordinates.
    MeshView view(const MeshView& vertices) const noexcept {
        const auto* const first = reinterpret_cast<const std::byte*>(triangles_.data());
        if (vertices.vertices == nullptr) {
            return MeshView::strided_soup(first, size(), sizeof(StoredTriangle), CoordinateType::f32);
        }
        return MeshView::indexed(vertices.vertices, vertices.vertex_count, vertices.stride, vertices.coordinate_type, first,
                                 size(), sizeof(StoredTriangle), IndexType::u32);
    }

private:
    Array<StoredTriangle> triangles_;
    std::atomic<std::size_t> size_ = 0;
};

}  // namespace lamella
