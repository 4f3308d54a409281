// Outers with their holes, as a view of a layer's contours.
#include <iterator>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "golden/shape_cases.hpp"

using lamella::Contour;
using lamella::Island;
using lamella::Role;

static_assert(std::forward_iterator<lamella::Islands::Iterator>);

TEST_CASE("every outer comes with its holes, whatever stands between", "[engine][islands]") {
    std::vector<Contour> contours;
    for (const Role role :
         {Role::open, Role::outer, Role::hole, Role::hole, Role::flat, Role::outer, Role::outer, Role::hole, Role::open}) {
        contours.emplace_back().role = role;
    }
    std::vector<std::pair<std::ptrdiff_t, std::size_t>> found;
    for (const Island island : lamella::islands_of(contours)) {
        found.emplace_back(island.outer - contours.data(), island.holes.size());
        CHECK((island.holes.empty() || island.holes.data() == island.outer + 1));
    }
    CHECK(found == std::vector<std::pair<std::ptrdiff_t, std::size_t>>{{1, 2}, {5, 0}, {6, 1}});
    CHECK(lamella::islands_of({}).begin() == lamella::islands_of({}).end());
}

TEST_CASE("the islands of a slice hold every outer and every hole once", "[engine][islands]") {
    for (const auto& [name, mesh] : shape_cases::meshes()) {
        INFO(name);
        const lamella::SliceResult result = sliced(mesh, uniform(0.25));
        std::size_t outers = 0;
        std::size_t holes = 0;
        for (const lamella::Layer& layer : result.layers) {
            for (const Island island : lamella::islands_of(result.contours_of(layer))) {
                ++outers;
                holes += island.holes.size();
                const auto outer = static_cast<std::int64_t>(island.outer - result.contours.data());
                for (const Contour& hole : island.holes) {
                    // A hole lies in its outer, or in a hole of it.
                    const std::int64_t around = hole.parent;
                    CHECK((around == outer || result.contours[static_cast<std::size_t>(around)].role == Role::hole));
                }
            }
        }
        CHECK(holes == result.summary.holes);
        CHECK(outers + holes + result.summary.open_contours + result.summary.flat_contours == result.contours.size());
    }
}
