// Solids that are given by a field rather than by rings.
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <vector>

#include "models/lattice.hpp"
#include "models/numbers.hpp"

namespace lamella::models {

namespace {

// A torus of tube radius `tube` around a circle of radius `ring`. Its axis leans by an angle of the 3-4-5 triangle.
class Torus final : public Field {
public:
    explicit Torus(const Recipe& recipe)
        : Field(ring_ + tube_, ring_ + tube_), turn_(sincos_turns(Random(recipe.seed).unit())) {}

    void prepare(const Lattice& lattice) override { lattice_ = lattice; }

    // With q the squared distance from the centre and rho the distance from the axis, the solid is where (q + ring^2 -
    // tube^2)^2 <= 4 ring^2 rho^2.
    bool fill_row(std::uint32_t k, std::uint32_t j, double* row) override {
        const double z = lattice_.z(k) - 0.5;
        const double y = lattice_.y(j);
        const double along_base = y * turn_.sin * lean_sin_ + z * lean_cos_;
        const double along_slope = turn_.cos * lean_sin_;
        const double reach = ring_ + tube_ + 2 * lattice_.longest_step();
        if (reach * reach <= y * y + z * z) {
            return false;
        }
        for (std::uint32_t i = 1; i + 1 < lattice_.nx; ++i) {
            const double x = lattice_.x(i);
            const double along = along_base + along_slope * x;
            const double q = x * x + y * y + z * z;
            const double sum = q + ring_ * ring_ - tube_ * tube_;
            row[i] = 4 * ring_ * ring_ * (q - along * along) - sum * sum;
        }
        return true;
    }

private:
    static constexpr double lean_sin_ = 0.8;
    static constexpr double lean_cos_ = 0.6;
    // Makes the height 1: 2 (ring * sin + tube) = 1.
    static constexpr double tube_ = 0.14;
    static constexpr double ring_ = (0.5 - tube_) / lean_sin_;

    SinCos turn_;
    Lattice lattice_;
};

// The sheet sin x cos y + sin y cos z + sin z cos x = 0, thickened on both sides, within a ball.
class Gyroid final : public Field {
public:
    explicit Gyroid(const Recipe& recipe) : Field(radius_, radius_) {
        // A smooth sheet needs about twelve thousand triangles per period cubed.
        while (periods_ < most_periods_ &&
               12000 * (periods_ + 0.5) * (periods_ + 0.5) * (periods_ + 0.5) < static_cast<double>(recipe.triangles)) {
            periods_ += 0.5;
        }
        Random random(recipe.seed);
        for (double& shift : shift_) {
            shift = random.unit();
        }
    }

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

    bool fill_row(std::uint32_t k, std::uint32_t j, double* row) override {
        const double z = lattice_.z(k) - 0.5;
        const double y = lattice_.y(j);
        const double reach = radius_ + 2 * lattice_.longest_step();
        if (reach * reach <= y * y + z * z) {
            return false;
        }
        const SinCos b = y_[j];
        const SinCos c = sincos_turns(z * periods_ + shift_[2]);
        const double slope = tau * periods_;  // scales the sheet's field to about a distance
        for (std::uint32_t i = 1; i + 1 < lattice_.nx; ++i) {
            const double x = lattice_.x(i);
            const double sheet = x_[i].sin * b.cos + b.sin * c.cos + c.sin * x_[i].cos;
            const double in_sheet = (thickness_ - std::abs(sheet)) / slope;
            const double in_ball = (radius_ * radius_ - x * x - y * y - z * z) / (2 * radius_);
            const double near = std::max(rounding_ - std::abs(in_sheet - in_ball), 0.0);
            row[i] = std::min(in_sheet, in_ball) - near * near / (4 * rounding_);
        }
        return true;
    }

private:
    static constexpr double radius_ = 0.5;
    static constexpr double most_periods_ = 5;
    static constexpr double thickness_ = 0.55;
    static constexpr double rounding_ = 0.015;  // radius that rounds the rim where the sheet meets the ball

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
