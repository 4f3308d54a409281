#include <algorithm>
#include <bit>
#include <limits>

#include "base/numbers.hpp"
#include "medical/hdf5/load.hpp"
#include "slicing/grid/exact.hpp"

namespace lamella {

namespace {

/// A place in the file, and what is wrong with it; empty where nothing is.
struct Complaint {
    const char* path = nullptr;
    std::uint64_t row = 0;
    const char* why = nullptr;
};

/// The contours and points of a result that is being read, with offsets that have not been looked at.
class LoadedCheck {
public:
    explicit LoadedCheck(SliceResult& result) : result_(result) {
        for (const Layer& layer : result.layers) {
            open_.push_back(layer.contour_count != 0);
        }
    }

    /// Counts of contours and points, by where the next layer and contour begin.
    Complaint offsets() {
        const auto layers =
            counts(result_.layers, result_.contours.size(), &Layer::first_contour, [](Layer& layer, std::uint64_t count) {
                layer.contour_count = count;
                return true;
            });
        if (layers < result_.layers.size()) {
            return {"/layers/first_contour", layers, "does not lead on to the next row"};
        }
        const auto contours = counts(result_.contours, result_.points.size(), &Contour::first_point,
                                     [](Contour& contour, std::uint64_t count) {
                                         contour.point_count = static_cast<std::uint32_t>(count);
                                         return count > 0 && count <= std::numeric_limits<std::uint32_t>::max();
                                     });
        if (contours < result_.contours.size()) {
            return {"/contours/first_point", contours, "does not lead on to the next row"};
        }
        return {};
    }

    /// Precondition: offsets() had no complaint.
    Complaint layer(std::size_t index) {
        const Layer& layer = result_.layers[index];
        if (index > 0 && layer.plane <= result_.layers[index - 1].plane) {
            return {"/layers/plane", index, "not above the row before"};
        }
        if (!(layer.bottom_mm <= layer.plane_mm && layer.plane_mm <= layer.top_mm)) {
            return {"/layers/plane_mm", index, "not between bottom and top"};
        }
        for (std::uint64_t c = layer.first_contour; c < layer.first_contour + layer.contour_count; ++c) {
            Contour& contour = result_.contours[c];
            const auto given = std::bit_cast<double>(contour.twice_area.low);
            contour.twice_area = area_of(contour);
            if (stored_area(result_, contour) != given) {
                return {"/contours/area_mm2", c, "is not the area of the contour's points"};
            }
        }
        if (open_[index] != is_open(result_, layer)) {
            return {"/layers/open", index, "is not what the contours of the layer are"};
        }
        for (std::uint64_t c = layer.first_contour; c < layer.first_contour + layer.contour_count; ++c) {
            if (!is_parent(layer, c)) {
                return {"/contours/parent", c, "cannot lie around the contour"};
            }
        }
        return {};
    }

private:
    /// How many rows have their count before one that has not.
    template <class T, class Set>
    static std::uint64_t counts(Array<T>& rows, std::uint64_t end, std::uint64_t T::*first, Set set) {
        for (std::size_t i = 0; i < rows.size(); ++i) {
            const std::uint64_t begin = rows[i].*first;
            const std::uint64_t next = i + 1 < rows.size() ? rows[i + 1].*first : end;
            if ((i == 0 && begin != 0) || next < begin || next > end || !set(rows[i], next - begin)) {
                return i;
            }
        }
        return rows.size();
    }

    Integer128 area_of(const Contour& contour) const {
        if (contour.role == Role::flat || contour.role == Role::open) {
            return {};
        }
        const std::span<const Point> points = result_.points_of(contour);
        Int128 sum = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            sum += cross(points[i], points[i + 1 == points.size() ? 0 : i + 1]);
        }
        return to_integer128(sum);
    }

    Int128 size_of(const Contour& contour) const {
        const Int128 area = to_int128(contour.twice_area);
        return area < 0 ? -area : area;
    }

    /// Parents start before their children, or there and are larger, so that no chain of parents runs in a ring.
    bool is_parent(const Layer& layer, std::uint64_t index) const {
        const Contour& contour = result_.contours[index];
        if (contour.parent < 0) {
            return contour.parent == -1;
        }
        const auto parent_index = static_cast<std::uint64_t>(contour.parent);
        if (parent_index < layer.first_contour || parent_index >= layer.first_contour + layer.contour_count) {
            return false;
        }
        const Contour& parent = result_.contours[parent_index];
        const Point start = result_.points[contour.first_point];
        const Point around = result_.points[parent.first_point];
        return parent.role <= Role::hole && (around < start || (around == start && size_of(parent) > size_of(contour)));
    }

    SliceResult& result_;
    std::vector<bool> open_;  ///< of each layer, as the file says
};

void refuse_if(const InputFile& file, const Complaint& complaint) {
    if (complaint.path != nullptr) {
        refuse_place(file, complaint.path, "row " + std::to_string(complaint.row) + " " + complaint.why);
    }
}

}  // namespace

void check_loaded(const InputFile& file, SliceResult& result, const Parallel& parallel) {
    LoadedCheck check(result);
    refuse_if(file, check.offsets());
    std::vector<Complaint> complaints(result.layers.size());
    parallel.run_ranges(result.layers.size(), 16, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            complaints[i] = check.layer(i);
        }
    });
    for (const Complaint& complaint : complaints) {
        refuse_if(file, complaint);
    }
}

}  // namespace lamella
