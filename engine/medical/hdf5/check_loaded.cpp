#include <algorithm>
#include <bit>
#include <limits>

#include "base/int128.hpp"
#include "medical/hdf5/archive_file.hpp"
#include "slicing/grid/exact.hpp"

namespace lamella {

namespace {

/// A place in the file, and what is wrong with it; empty where nothing is.
struct Complaint {
    const char* path = nullptr;
    std::uint64_t row = 0;
    const char* why = nullptr;
};

void refuse_if(const InputFile& file, const Complaint& complaint) {
    if (complaint.path != nullptr) {
        refuse_place(file, complaint.path, "row " + std::to_string(complaint.row) + " " + complaint.why);
    }
}

/// Calls set(row, count) with how many of `end` follow from each row's first one to the next row's.
template <class T, class Set>
Complaint set_row_counts(const char* path, Array<T>& rows, std::uint64_t end, std::uint64_t T::*first, Set set) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const std::uint64_t begin = rows[i].*first;
        const std::uint64_t next = i + 1 < rows.size() ? rows[i + 1].*first : end;
        if ((i == 0 && begin != 0) || next < begin || next > end || !set(rows[i], next - begin)) {
            return {path, i, "does not lead on to the next row"};
        }
    }
    return {};
}

Integer128 twice_area_of(const SliceResult& result, const Contour& contour) {
    if (contour.role == Role::flat || contour.role == Role::open) {
        return {};
    }
    const std::span<const Point> points = result.points_of(contour);
    Int128 sum = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        sum += cross(points[i], points[i + 1 == points.size() ? 0 : i + 1]);
    }
    return to_integer128(sum);
}

Int128 size_of(const Contour& contour) {
    const Int128 area = to_int128(contour.twice_area);
    return area < 0 ? -area : area;
}

/// Parents start before their children, or there and are larger, so that no chain of parents runs in a ring.
bool is_parent(const SliceResult& result, const Layer& layer, const Contour& contour) {
    if (contour.parent < 0) {
        return contour.parent == -1;
    }
    const auto index = static_cast<std::uint64_t>(contour.parent);
    if (index < layer.first_contour || index >= layer.first_contour + layer.contour_count) {
        return false;
    }
    const Contour& parent = result.contours[index];
    const Point start = result.points[contour.first_point];
    const Point around = result.points[parent.first_point];
    return parent.role <= Role::hole && (around < start || (around == start && size_of(parent) > size_of(contour)));
}

/// Sets the areas of the layer's contours. `open`: as the file says.
Complaint check_layer(SliceResult& result, std::size_t index, bool open) {
    const Layer& layer = result.layers[index];
    if (index > 0 && layer.plane <= result.layers[index - 1].plane) {
        return {"/layers/plane", index, "not above the row before"};
    }
    if (!(layer.bottom_mm <= layer.plane_mm && layer.plane_mm <= layer.top_mm)) {
        return {"/layers/plane_mm", index, "not between bottom and top"};
    }
    const std::uint64_t end = layer.first_contour + layer.contour_count;
    for (std::uint64_t c = layer.first_contour; c < end; ++c) {
        Contour& contour = result.contours[c];
        const auto given = std::bit_cast<double>(contour.twice_area.low);
        contour.twice_area = twice_area_of(result, contour);
        if (stored_area(result, contour) != given) {
            return {"/contours/area_mm2", c, "is not the area of the contour's points"};
        }
    }
    if (open != is_open(result, layer)) {
        return {"/layers/open", index, "is not what the contours of the layer are"};
    }
    for (std::uint64_t c = layer.first_contour; c < end; ++c) {
        if (!is_parent(result, layer, result.contours[c])) {
            return {"/contours/parent", c, "cannot lie around the contour"};
        }
    }
    return {};
}

}  // namespace

void check_loaded(const InputFile& file, SliceResult& result, const Parallel& parallel) {
    std::vector<bool> open;  // of each layer, as the file says
    for (const Layer& layer : result.layers) {
        open.push_back(layer.contour_count != 0);
    }
    refuse_if(file, set_row_counts("/layers/first_contour", result.layers, result.contours.size(), &Layer::first_contour,
                                   [](Layer& layer, std::uint64_t count) {
                                       layer.contour_count = count;
                                       return true;
                                   }));
    refuse_if(file, set_row_counts("/contours/first_point", result.contours, result.points.size(), &Contour::first_point,
                                   [](Contour& contour, std::uint64_t count) {
                                       contour.point_count = static_cast<std::uint32_t>(count);
                                       return count > 0 && count <= std::numeric_limits<std::uint32_t>::max();
                                   }));
    std::vector<Complaint> complaints(result.layers.size());
    parallel.run_ranges(result.layers.size(), 16, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            complaints[i] = check_layer(result, i, open[i]);
        }
    });
    for (const Complaint& complaint : complaints) {
        refuse_if(file, complaint);
    }
}

}  // namespace lamella
