#include "models/fields.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>

#include "models/numbers.hpp"

namespace lamella::models {

namespace {

constexpr double tau = 6.283185307179586476925286766559;

// A torus of tube radius `tube` around a circle of radius `ring`, its axis leaning by the angle of the 3-4-5 triangle.
class Torus final : public Field {
public:
    explicit Torus(const Recipe& recipe) : turn_(sincos_turns(Random(recipe.seed).unit())) {}

    double half_x() const noexcept override { return ring_ + tube_; }
    double half_y() const noexcept override { return ring_ + tube_; }
    void prepare(const Lattice& lattice) override { lattice_ = lattice; }

    void fill(std::uint32_t k, double* values) const override {
        const double z = lattice_.z(k) - 0.5;
        for (std::uint32_t j = 0; j < lattice_.ny; ++j) {
            const double y = lattice_.y(j);
            for (std::uint32_t i = 0; i < lattice_.nx; ++i) {
                const double x = lattice_.x(i);
                const double u = x * turn_.cos + y * turn_.sin;
                const double v = y * turn_.cos - x * turn_.sin;
                const double along = u * lean_sin_ + z * lean_cos_;
                const double across = u * lean_cos_ - z * lean_sin_;
                const double off = std::sqrt(across * across + v * v) - ring_;
                *values++ = tube_ - std::sqrt(off * off + along * along);
            }
        }
    }

private:
    static constexpr double lean_sin_ = 0.8;
    static constexpr double lean_cos_ = 0.6;
    // Height 2 (ring * sin + tube) = 1.
    static constexpr double tube_ = 0.14;
    static constexpr double ring_ = (0.5 - tube_) / lean_sin_;

    SinCos turn_;
    Lattice lattice_;
};

// sin x cos y + sin y cos z + sin z cos x, thickened to both sides, within a ball.
class Gyroid final : public Field {
public:
    explicit Gyroid(const Recipe& recipe) {
        while (periods_ < most_periods_ &&
               2000 * (periods_ + 0.5) * (periods_ + 0.5) * (periods_ + 0.5) < static_cast<double>(recipe.triangles)) {
            periods_ += 0.5;
        }
        Random random(recipe.seed);
        for (double& shift : shift_) {
            shift = random.unit();
        }
    }

    double half_x() const noexcept override { return radius_; }
    double half_y() const noexcept override { return radius_; }

    void prepare(const Lattice& lattice) override {
        lattice_ = lattice;
        x_.clear();
        y_.clear();
        for (std::uint32_t i = 0; i < lattice.nx; ++i) {
            x_.push_back(sincos_turns(lattice.x(i) * periods_ + shift_[0]));
        }
        for (std::uint32_t j = 0; j < lattice.ny; ++j) {
            y_.push_back(sincos_turns(lattice.y(j) * periods_ + shift_[1]));
        }
    }

    void fill(std::uint32_t k, double* values) const override {
        const double z = lattice_.z(k) - 0.5;
        const SinCos c = sincos_turns(z * periods_ + shift_[2]);
        const double slope = tau * periods_;  // brings the sheet's field to about the scale of a distance
        for (std::uint32_t j = 0; j < lattice_.ny; ++j) {
            const SinCos b = y_[j];
            const double ball = radius_ * radius_ - lattice_.y(j) * lattice_.y(j) - z * z;
            for (std::uint32_t i = 0; i < lattice_.nx; ++i) {
                const SinCos a = x_[i];
                const double sheet = a.sin * b.cos + b.sin * c.cos + c.sin * a.cos;
                const double x = lattice_.x(i);
                *values++ = std::min((thickness_ - std::abs(sheet)) / slope, (ball - x * x) / (2 * radius_));
            }
        }
    }

private:
    static constexpr double radius_ = 0.5;
    static constexpr double most_periods_ = 6;
    static constexpr double thickness_ = 0.55;

    double periods_ = 0.5;
    std::array<double, 3> shift_{};
    Lattice lattice_;
    std::vector<SinCos> x_;
    std::vector<SinCos> y_;
};

}  // namespace

std::unique_ptr<Field> make_field(const Recipe& recipe) {
    switch (recipe.shape) {
        case Shape::torus:
            return std::make_unique<Torus>(recipe);
        case Shape::gyroid:
            return std::make_unique<Gyroid>(recipe);
        default:
            assert(recipe.shape == Shape::bone);
            return make_bone(recipe);
    }
}

}  // namespace lamella::models
