#include <cmath>
#include <numbers>
#include <vector>

#include "mesh.hpp"

namespace lamella::bench {

namespace {

struct Corner {
    float x, y;
};

/// Appends triangles to a soup that has enough space for them.
class SoupWriter {
public:
    explicit SoupWriter(float* at) : at_(at) {}
    void triangle(Corner a, float az, Corner b, float bz, Corner c, float cz) noexcept {
        for (const float value : {a.x, a.y, az, b.x, b.y, bz, c.x, c.y, cz}) {
            *at_++ = value;
        }
    }

private:
    float* at_;
};

std::vector<Corner> ring(double x, double y, double radius, std::uint32_t sides) {
    std::vector<Corner> corners;
    for (std::uint32_t i = 0; i < sides; ++i) {
        const double angle = 2 * std::numbers::pi * i / sides;
        corners.push_back(
            {static_cast<float>(x + radius * std::cos(angle)), static_cast<float>(y + radius * std::sin(angle))});
    }
    return corners;
}

}  // namespace

Mesh make_columns(std::uint32_t count, std::uint32_t sides, double height_mm) {
    Mesh mesh;
    mesh.soup.resize_discarding(std::size_t{9} * count * (2 * sides + 2 * (sides - 2)));
    SoupWriter out(mesh.soup.data());
    const auto top = static_cast<float>(height_mm);
    const auto row = static_cast<std::uint32_t>(std::ceil(std::sqrt(static_cast<double>(count))));
    for (std::uint32_t column = 0; column < count; ++column) {
        const double x = column % row;
        const double y = column / row;  // NOLINT(bugprone-integer-division): the row's number
        const std::vector<Corner> low = ring(x, y, 0.40, sides);
        const std::vector<Corner> high = ring(x, y, 0.45, sides);
        for (std::uint32_t i = 0; i < sides; ++i) {
            const std::uint32_t next = (i + 1) % sides;
            out.triangle(low[i], 0, low[next], 0, high[i], top);
            out.triangle(low[next], 0, high[next], top, high[i], top);
        }
        for (std::uint32_t i = 1; i + 1 < sides; ++i) {
            out.triangle(low[0], 0, low[i + 1], 0, low[i], 0);
            out.triangle(high[0], top, high[i], top, high[i + 1], top);
        }
    }
    mesh.measure();
    return mesh;
}

}  // namespace lamella::bench
