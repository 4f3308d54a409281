#include "golden/shape_cases.hpp"

#include "engine/slicing.hpp"
#include "slicing/tuning.hpp"

using lamella::models::Shape;

namespace shape_cases {

std::map<std::string, shapes::Soup> meshes() {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 4);
    shapes::Soup torn = ball;
    torn.resize(torn.size() - 9 * std::size_t{40});
    return {{"ball", ball},
            {"torn ball", torn},
            {"crossing balls", shapes::joined({ball, shapes::moved(ball, {3, 4, 5}), shapes::flipped(ball)})},
            {"tetrahedra", shapes::random_tetrahedra(11, 60, 9)},
            {"tangle", shapes::joined({shapes::random_soup(5, 200, 8), shapes::random_tetrahedra(6, 20, 8)})},
            {"bone", generated(Shape::bone, 30'000)},
            {"gyroid", generated(Shape::gyroid, 30'000)},
            {"torus", generated(Shape::torus, 5'000)},
            {"prism", generated(Shape::prism, 2'000)}};
}

std::map<std::string, lamella::SliceOptions> plans(const shapes::Soup& mesh) {
    std::map<std::string, lamella::SliceOptions> plans;
    plans["uniform"] = uniform(0.25);
    plans["coarse grid"] = uniform(0.25, 0x1p-8);
    const lamella::Tuning random{.random_heights = lamella::RandomHeights{0.1, 0.4, 1}};
    plans["random"].heights_mm = sliced(mesh, {}, {}, random).info.options.heights_mm;
    plans["explicit"].heights_mm = {{-8.5, -3, -1, 0, 0.5, 1, 2, 3, 3.0625, 4, 7, 9, 15}};
    plans["explicit"].planes.side = lamella::PlaneSide::above;
    return plans;
}

}  // namespace shape_cases
