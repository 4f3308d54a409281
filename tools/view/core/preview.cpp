#include <algorithm>
#include <cmath>
#include <utility>

#include "view_core.hpp"

namespace lamella::view {

namespace {

template <class T>
double number_at(const std::byte* at) noexcept {
    T number;
    std::memcpy(&number, at, sizeof number);
    return static_cast<double>(number);
}

using Corner = std::array<double, 3>;

/// In mm about the centre.
Corner corner_at(const MeshView& mesh, const Corner& centre, std::size_t triangle, std::size_t corner) noexcept {
    const std::size_t step = 3 * size_of(mesh.vertex_type);
    const std::byte* const at = mesh.indices == nullptr
                                    ? mesh.vertex_at(triangle) + corner * step
                                    : mesh.vertex_at(static_cast<std::size_t>(mesh.vertex_of(triangle, corner)));
    Corner mm{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::byte* const number = at + axis * size_of(mesh.vertex_type);
        const double read = mesh.vertex_type == Number::f32   ? number_at<float>(number)
                            : mesh.vertex_type == Number::f64 ? number_at<double>(number)
                            : mesh.vertex_type == Number::i32 ? number_at<std::int32_t>(number)
                                                              : number_at<std::int64_t>(number);
        mm[axis] = read * mesh.mm_per_unit - centre[axis];
    }
    return mm;
}

/// Cells by their place: open addressing, which std::unordered_map takes four times as long for.
class Cells {
public:
    std::uint32_t add(const Corner& mm, double cell_mm) {
        std::uint64_t key = 0;
        for (const double along : mm) {
            key = key << 21 | (static_cast<std::uint64_t>(std::floor(along / cell_mm) + (1 << 20)) & 0x1fffff);
        }
        if (2 * cells_.size() >= slots_.size()) {
            grow();
        }
        std::uint32_t& slot = slot_of(key);
        if (slot == 0) {
            cells_.push_back({key, mm});
            slot = static_cast<std::uint32_t>(cells_.size());
        }
        return slot - 1;
    }
    const Corner& operator[](std::uint32_t cell) const noexcept { return cells_[cell].second; }

private:
    std::uint32_t& slot_of(std::uint64_t key) noexcept {
        std::size_t at = static_cast<std::size_t>(key * 0x9e3779b97f4a7c15U >> 32);
        while (slots_[at &= slots_.size() - 1] != 0 && cells_[slots_[at] - 1].first != key) {
            ++at;
        }
        return slots_[at];
    }
    void grow() {
        slots_.assign(2 * slots_.size(), 0);
        for (std::uint32_t cell = 0; cell < cells_.size(); ++cell) {
            slot_of(cells_[cell].first) = cell + 1;
        }
    }

    std::vector<std::pair<std::uint64_t, Corner>> cells_;                     ///< its first corner stands for all
    std::vector<std::uint32_t> slots_ = std::vector<std::uint32_t>(1 << 16);  ///< 1 + the cell; 0: none
};

/// Triangles whose corners lie in three cells; empty where there are more than `most`.
std::vector<float> clustered(const MeshView& mesh, const Corner& centre, double cell_mm, std::uint64_t most) {
    Cells cells;
    std::vector<std::array<std::uint32_t, 3>> kept;
    for (std::size_t t = 0; t < mesh.triangle_count; ++t) {
        std::array<std::uint32_t, 3> corners{};
        for (std::size_t c = 0; c < 3; ++c) {
            corners[c] = cells.add(corner_at(mesh, centre, t, c), cell_mm);
        }
        if (corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0]) {
            if (kept.size() == most) {
                return {};
            }
            kept.push_back(corners);
        }
    }
    std::vector<float> soup;
    soup.reserve(9 * kept.size());
    for (const auto& corners : kept) {
        for (const std::uint32_t corner : corners) {
            for (const double along : cells[corner]) {
                soup.push_back(static_cast<float>(along));
            }
        }
    }
    return soup;
}

}  // namespace

std::vector<float> preview(const MeshView& mesh, const Corner& centre, const Box& box, std::uint64_t most_triangles) {
    std::vector<float> soup;
    if (mesh.triangle_count <= most_triangles) {
        soup.reserve(9 * mesh.triangle_count);
        for (std::size_t corner = 0; corner < 3 * mesh.triangle_count; ++corner) {
            for (const double along : corner_at(mesh, centre, corner / 3, corner % 3)) {
                soup.push_back(static_cast<float>(along));
            }
        }
        return soup;
    }
    double longest = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        longest = std::max(longest, box.max_mm[axis] - box.min_mm[axis]);
    }
    for (double cells = 320; soup.empty() && cells > 8; cells *= 0.75) {
        soup = clustered(mesh, centre, longest / cells, most_triangles);
    }
    return soup;
}

}  // namespace lamella::view
