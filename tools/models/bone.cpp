// A bone-like solid after the femur: a bowed shaft between two condyles below and a head and a trochanter above. A
// cortex encloses trabeculae (the level set of a random field of plane waves) in the ends and a medullary cavity in the
// shaft.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "models/lattice.hpp"
#include "models/numbers.hpp"

namespace lamella::models {

namespace {

// The field of an ellipsoid along one lattice row: c - (a x + b)^2 - (d x + e)^2. It is positive inside; near the
// surface its value is about the distance from it.
struct RowQuadric {
    double c = 0;
    double a = 0;
    double b = 0;
    double d = 0;
    double e = 0;
};

// An ellipsoid turned in the x-z plane by `lean` turns.
struct Ellipsoid {
    std::array<double, 3> centre{};
    std::array<double, 3> radii{};
    double lean = 0;
    SinCos turn{};

    RowQuadric at(double y, double z) const noexcept {
        const double r = std::min({radii[0], radii[1], radii[2]});
        const double half = std::sqrt(r / 2);
        const double dy = (y - centre[1]) / radii[1];
        const double dz = z - centre[2];
        return {.c = r / 2 * (1 - dy * dy),
                .a = half * turn.cos / radii[0],
                .b = half * (dz * turn.sin - centre[0] * turn.cos) / radii[0],
                .d = -half * turn.sin / radii[2],
                .e = half * (dz * turn.cos + centre[0] * turn.sin) / radii[2]};
    }
};

constexpr std::size_t part_count = 7;

constexpr std::array<Ellipsoid, part_count - 1> anatomy{{
    {{-0.065, -0.01, 0.088}, {0.066, 0.088, 0.084}, 0},  // condyles
    {{0.065, -0.01, 0.088}, {0.066, 0.084, 0.080}, 0},
    {{0.0, 0.012, 0.15}, {0.092, 0.060, 0.13}, 0},        // the flare above them
    {{-0.045, -0.005, 0.860}, {0.050, 0.050, 0.095}, 0},  // greater trochanter
    {{0.045, 0.0, 0.875}, {0.115, 0.042, 0.045}, 0.11},   // neck
    {{0.105, 0.0, 0.920}, {0.074, 0.074, 0.074}, 0},      // head
}};

// Smooth maximum: rounds the corner where a and b differ by less than `width`.
inline double join(double a, double b, double width) noexcept {
    const double near = std::max(width - std::abs(a - b), 0.0);
    return std::max(a, b) + near * near / (4 * width);
}

// A random field: the sum of plane waves of about one wavelength in random directions, scaled to unit variance.
class Waves {
public:
    Waves(std::size_t count, double wavelength, double z_stretch, Random& random) {
        for (std::size_t n = 0; n < count; ++n) {
            // Directions cover the half sphere: equal steps in height, random azimuths.
            const double up = (static_cast<double>(n) + random.unit()) / static_cast<double>(count);
            const SinCos azimuth = sincos_turns(random.unit());
            const double level = std::sqrt(1 - up * up);
            const double turns = (0.85 + 0.3 * random.unit()) / wavelength;
            waves_.push_back(
                {turns * level * azimuth.cos, turns * level * azimuth.sin, turns * up / z_stretch, random.unit()});
        }
        scale_ = std::sqrt(2 / static_cast<double>(count));
    }

    void prepare(const Lattice& lattice) {
        nx_ = lattice.nx;
        cos_.resize(waves_.size() * nx_);
        sin_.resize(waves_.size() * nx_);
        for (std::size_t n = 0; n < waves_.size(); ++n) {
            for (std::uint32_t i = 0; i < lattice.nx; ++i) {
                const SinCos at = sincos_turns(waves_[n].x * lattice.x(i));
                cos_[n * nx_ + i] = at.cos * scale_;
                sin_[n * nx_ + i] = at.sin * scale_;
            }
        }
    }

    // Sets values[i] to the field at node i of the row.
    void row(double y, double z, double* values) const {
        std::fill(values, values + nx_, 0.0);
        for (std::size_t n = 0; n < waves_.size(); ++n) {
            const SinCos phase = sincos_turns(waves_[n].y * y + waves_[n].z * z + waves_[n].phase);
            const double* c = cos_.data() + n * nx_;
            const double* s = sin_.data() + n * nx_;
            for (std::size_t i = 0; i < nx_; ++i) {
                values[i] += phase.cos * c[i] - phase.sin * s[i];
            }
        }
    }

private:
    struct Wave {
        double x, y, z;  // turns per unit length
        double phase;    // turns
    };
    std::vector<Wave> waves_;
    double scale_ = 1;
    std::size_t nx_ = 0;
    std::vector<double> cos_;
    std::vector<double> sin_;
};

class Bone final : public Field {
public:
    explicit Bone(const Recipe& recipe) : Bone(recipe, Random(recipe.seed)) {}

    void prepare(const Lattice& lattice) override {
        lattice_ = lattice;
        relief_.prepare(lattice);
        pores_.prepare(lattice);
        // Farther out than this, the field affects neither a join nor a node's neighbour.
        const double step = 2 * lattice.longest_step();
        margin_ = join_width + step + 10 * step * step;
        pore_values_.resize(lattice.nx);
        relief_values_.resize(lattice.nx);
    }

    bool fill_row(std::uint32_t k, std::uint32_t j, double* row) override {
        const double z = lattice_.z(k);
        const double y = lattice_.y(j);
        const std::array<RowQuadric, part_count> parts = parts_at(y, z);
        if (std::none_of(parts.begin(), parts.end(), [&](const RowQuadric& part) { return part.c + margin_ > 0; })) {
            return false;
        }
        outside(parts, row);
        relief_.row(y, z, relief_values_.data());
        pores_.row(y, z, pore_values_.data());
        hollow(y, z, row);
        return true;
    }

private:
    static constexpr double join_width = 0.03;
    static constexpr double relief_height = 0.0015;

    Bone(const Recipe& recipe, Random random)
        : Field(0.185, 0.125),
          pore_size_(std::max(0.0063, 11 / std::sqrt(static_cast<double>(recipe.triangles)))),
          cortex_(std::max(0.0075, pore_size_ / 2)),
          relief_(6, std::max(0.07, 4 * pore_size_), 1.5, random),
          pores_(16, pore_size_, 1.5, random),
          anatomy_(anatomy) {
        for (Ellipsoid& part : anatomy_) {
            part.turn = sincos_turns(part.lean);
        }
    }

    std::array<RowQuadric, part_count> parts_at(double y, double z) const noexcept {
        std::array<RowQuadric, part_count> parts;
        // The shaft bows forward and fades out within the ends.
        const double waist = (z - 0.5) * (z - 0.5);
        const double radius = 0.047 + 0.07 * waist;
        const double dy = y - 0.022 * (1 - 4 * waist);
        const double past_end = std::max({0.0, 0.12 - z, z - 0.87});
        parts[0] = {(radius - dy * dy / radius) / 2 - 8 * past_end * past_end, std::sqrt(0.5 / radius), 0, 0, 0};
        for (std::size_t p = 1; p < part_count; ++p) {
            parts[p] = anatomy_[p - 1].at(y, z);
        }
        return parts;
    }

    // The approximate depth below the smooth outer surface.
    void outside(const std::array<RowQuadric, part_count>& parts, double* values) const noexcept {
        for (std::uint32_t i = 1; i + 1 < lattice_.nx; ++i) {
            const double x = lattice_.x(i);
            double joined = -1;
            for (const RowQuadric& part : parts) {
                const double u = part.a * x + part.b;
                const double v = part.d * x + part.e;
                joined = join(joined, part.c - u * u - v * v, join_width);
            }
            values[i] = joined;
        }
    }

    // Roughens the outer surface and removes the pores between the trabeculae and the medullary cavity.
    void hollow(double y, double z, double* values) const noexcept {
        constexpr double half_length = 0.30;
        constexpr double cavity_radius = 0.022;
        constexpr double density = -0.35;  // level of the random field: about two thirds stay solid
        const double along = (z - 0.5) / half_length;
        const double dy = y - 0.022 * (1 - 4 * (z - 0.5) * (z - 0.5));
        const double cavity = cavity_radius / 2 * (1 - along * along * along * along) - dy * dy / (2 * cavity_radius);
        const double strut = pore_size_ / tau;
        for (std::uint32_t i = 1; i + 1 < lattice_.nx; ++i) {
            const double x = lattice_.x(i);
            const double depth = values[i] + relief_height * relief_values_[i];
            const double marrow = x * x / (2 * cavity_radius) - cavity;
            const double trabecula = std::min((pore_values_[i] - density) * strut, marrow);
            values[i] = std::min(depth, std::max(cortex_ - depth, trabecula));
        }
    }

    double pore_size_;
    double cortex_;
    Waves relief_;
    Waves pores_;
    std::array<Ellipsoid, part_count - 1> anatomy_;
    Lattice lattice_;
    double margin_ = 0;
    std::vector<double> relief_values_;
    std::vector<double> pore_values_;
};

}  // namespace

std::unique_ptr<Field> make_bone(const Recipe& recipe) {
    return std::make_unique<Bone>(recipe);
}

}  // namespace lamella::models
