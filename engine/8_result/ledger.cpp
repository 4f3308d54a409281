#include "lamella/ledger.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <new>
#include <stdexcept>

#include "2_grid/quantise.hpp"

namespace lamella {

namespace {

/// Of a horizontal triangle, in square grid units: positive if it faces up.
double area_facing_up(const GridTriangle& t) noexcept {
    const std::int64_t ux = std::int64_t{t[1].x} - t[0].x;
    const std::int64_t uy = std::int64_t{t[1].y} - t[0].y;
    const std::int64_t vx = std::int64_t{t[2].x} - t[0].x;
    const std::int64_t vy = std::int64_t{t[2].y} - t[0].y;
    return (static_cast<double>(ux) * static_cast<double>(vy) - static_cast<double>(uy) * static_cast<double>(vx)) / 2;
}

class Bookkeeping {
public:
    explicit Bookkeeping(const SliceResult& result) : result_(result), unit_mm2_(result.unit_mm * result.unit_mm) {}

    void enter(const GridTriangle& t) {
        ++ledger_.triangles;
        if (is_degenerate(t)) {
            ++ledger_.degenerate;
            return;
        }
        const auto [low, high] = std::minmax({t[0].z, t[1].z, t[2].z});
        const std::size_t above = first_above(low);
        if (above < result_.layers.size() && result_.layers[above].plane.z() < high) {
            ++ledger_.cut;
            return;
        }
        ++ledger_.between;
        Slab& slab = slabs_[above];
        ++slab.triangles;
        if (low == high) {
            ++ledger_.horizontal;
            const double area = area_facing_up(t) * unit_mm2_;
            (area > 0 ? slab.flat_up_mm2 : slab.flat_down_mm2) += std::abs(area);
        }
    }

    Ledger close() {
        for (auto& [layer, slab] : slabs_) {
            slab.layer = layer;
            ledger_.flat_up_mm2 += slab.flat_up_mm2;
            ledger_.flat_down_mm2 += slab.flat_down_mm2;
            ledger_.slabs.push_back(slab);
        }
        find_gaps();
        return std::move(ledger_);
    }

private:
    /// Triangles often come by height: the last answer is tried first.
    std::size_t first_above(std::int32_t z) {
        const auto& layers = result_.layers;
        const bool same =
            (last_ == layers.size() || layers[last_].plane.z() > z) && (last_ == 0 || layers[last_ - 1].plane.z() < z);
        if (!same) {
            last_ = static_cast<std::size_t>(
                std::partition_point(layers.begin(), layers.end(), [z](const Layer& l) { return l.plane.z() < z; }) -
                layers.begin());
        }
        return last_;
    }

    void find_gaps() {
        std::vector<std::uint64_t> empty;
        bool begun = false;
        for (std::size_t l = 0; l < result_.layers.size(); ++l) {
            if (result_.layers[l].contour_count == 0) {
                empty.push_back(l);
                continue;
            }
            if (begun) {
                ledger_.gaps.insert(ledger_.gaps.end(), empty.begin(), empty.end());
            }
            begun = true;
            empty.clear();
        }
    }

    const SliceResult& result_;
    double unit_mm2_;
    Ledger ledger_;
    std::map<std::uint64_t, Slab> slabs_;  // by the layer above
    std::size_t last_ = 0;
};

}  // namespace

Result<Ledger> ledger(const MeshView& mesh, const SliceResult& result) noexcept {
    try {
        if (mesh.triangle_count != result.summary.triangles) {
            return Error{Code::invalid_argument, "the result is not of this mesh"};
        }
        Bookkeeping books(result);
        with_reader(mesh, result.frame, result.unit_mm, [&](const auto& read) {
            for (std::size_t t = 0; t < mesh.triangle_count; ++t) {
                books.enter(read(t));
            }
        });
        return books.close();
    } catch (const std::bad_alloc&) {
        return Error{Code::out_of_memory, "out of memory"};
    } catch (const std::length_error&) {
        return Error{Code::out_of_memory, "out of memory"};
    }
}

}  // namespace lamella
