#include "oracle/compare.hpp"

#include <algorithm>
#include <sstream>

#include "engine/slicing.hpp"

namespace oracle {

namespace {

using lamella::Point;

void print(std::ostream& out, const Contour& contour, bool any_start) {
    out << word_of(contour.role) << " orientation " << contour.orientation << " flags " << contour.flags << " segments "
        << contour.segments << " twice area " << static_cast<std::int64_t>(contour.twice_area >> 64) << " * 2^64 + "
        << static_cast<std::uint64_t>(contour.twice_area) << " points";
    const bool rotate = any_start && contour.role != lamella::Role::open;
    for (const Point p : rotate ? rings::from_smallest(contour.points) : contour.points) {
        out << ' ' << p.x << ',' << p.y;
    }
}

/// One line for each contour, with its parent written out, so that lines can be compared as a set.
std::vector<std::string> lines_of(const Layer& layer, bool any_start) {
    std::vector<std::string> lines;
    for (const Contour& contour : layer) {
        std::ostringstream line;
        print(line, contour, any_start);
        if (contour.parent >= 0) {
            line << " in ";
            print(line, layer[static_cast<std::size_t>(contour.parent)], any_start);
        }
        lines.push_back(line.str());
    }
    return lines;
}

Layer from_engine(const lamella::SliceResult& result, const lamella::Layer& from) {
    const auto first_contour = static_cast<std::int64_t>(from.first_contour);
    Layer layer;
    for (const lamella::Contour& contour : result.contours_of(from)) {
        Contour copy;
        const std::span<const Point> own = result.points_of(contour);
        copy.points.assign(own.begin(), own.end());
        copy.twice_area = Int128{contour.twice_area.high} * (Int128{1} << 64) + contour.twice_area.low;
        copy.parent = static_cast<int>(contour.parent < 0 ? -1 : contour.parent - first_contour);
        copy.segments = contour.segments;
        copy.role = contour.role;
        copy.orientation = contour.orientation > 0 ? 1 : (contour.orientation < 0 ? -1 : 0);
        copy.flags = contour.flags;
        layer.push_back(copy);
    }
    return layer;
}

bool order_is_settled(const Layer& layer) {
    std::vector<Crossing> starts;
    bool unique = true;
    for (const Contour& contour : layer) {
        unique = unique && contour.start_is_unique;
        starts.push_back(contour.start);
    }
    std::sort(starts.begin(), starts.end());
    return unique && std::adjacent_find(starts.begin(), starts.end()) == starts.end();
}

}  // namespace

std::string difference(const lamella::SliceResult& result, const lamella::Layer& layer, const Layer& expected) {
    const bool settled = order_is_settled(expected);
    std::vector<std::string> got = lines_of(from_engine(result, layer), !settled);
    std::vector<std::string> want = lines_of(expected, !settled);
    if (!settled) {
        std::sort(got.begin(), got.end());
        std::sort(want.begin(), want.end());
    }
    for (std::size_t c = 0; c < std::max(got.size(), want.size()); ++c) {
        const std::string mine = c < got.size() ? got[c] : "nothing";
        const std::string theirs = c < want.size() ? want[c] : "nothing";
        if (mine != theirs) {
            std::ostringstream out;
            out << "contour " << c << ":\n  engine " << mine << "\n  oracle " << theirs;
            return out.str();
        }
    }
    return {};
}

std::string difference(const lamella::SliceResult& result, const Layer& expected) {
    return difference(result, result.layers[0], expected);
}

std::string difference(const lamella::SliceResult& result, std::span<const Triangle> triangles) {
    for (const lamella::Layer& layer : result.layers) {
        const std::string found = difference(result, layer, slice_at(triangles, layer.plane.z()));
        if (!found.empty()) {
            return std::string("plane ").append(std::to_string(layer.plane.z())).append(", ").append(found);
        }
    }
    return {};
}

}  // namespace oracle
