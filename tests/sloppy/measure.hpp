// What a reader made of a file, in the words of answers.txt: the triangles, the box of their corners, and their area.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <limits>
#include <string>

namespace sloppy {

using Point = std::array<double, 3>;

class Measure {
public:
    void add(const Point& a, const Point& b, const Point& c) {
        ++triangles_;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            min_[axis] = std::min({min_[axis], a[axis], b[axis], c[axis]});
            max_[axis] = std::max({max_[axis], a[axis], b[axis], c[axis]});
        }
        Point cross{};
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t j = (i + 1) % 3;
            const std::size_t k = (i + 2) % 3;
            cross[i] = (b[j] - a[j]) * (c[k] - a[k]) - (b[k] - a[k]) * (c[j] - a[j]);
        }
        area_ += std::sqrt(cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]) / 2;
    }

    std::string words() const {
        if (triangles_ == 0) {
            return "no triangles";
        }
        char text[256];
        std::snprintf(text, sizeof text, "%zu triangles, box %.5g %.5g %.5g to %.5g %.5g %.5g, area %.5g", triangles_,
                      min_[0], min_[1], min_[2], max_[0], max_[1], max_[2], area_);
        return text;
    }

private:
    static constexpr double infinity = std::numeric_limits<double>::infinity();
    std::size_t triangles_ = 0;
    Point min_ = {infinity, infinity, infinity};
    Point max_ = {-infinity, -infinity, -infinity};
    double area_ = 0;
};

}  // namespace sloppy
