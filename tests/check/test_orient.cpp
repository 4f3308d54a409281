// Shells turned by where they lie.
#include <catch2/catch.hpp>

#include "engine/shapes.hpp"
#include "lamella/lamella.hpp"

using namespace lamella;
using namespace shapes;

namespace {

OrientedMesh oriented(const Soup& soup, double mm_per_unit = 1, const Context& context = {}) {
    MeshView mesh = MeshView::soup(std::span<const double>(soup));
    mesh.mm_per_unit = mm_per_unit;
    Result<OrientedMesh> turned = orient_shells(mesh, 0, context);
    REQUIRE(turned.ok());
    CHECK(turned->complete);
    return std::move(turned).value();
}

double volume_of(const OrientedMesh& oriented) {
    return check(oriented.view(), {.counts_only = true}).value().volume_mm3;
}

}  // namespace

TEST_CASE("orient: shells are turned outwards, and inwards within an odd number of others", "[check][orient]") {
    const Soup nested[] = {box({0, 0, 0}, {10, 10, 10}), box({1, 1, 1}, {9, 9, 9}), box({2, 2, 2}, {8, 8, 8})};
    for (int turns = 0; turns < 8; ++turns) {
        Soup soup;
        for (int shell = 0; shell < 3; ++shell) {
            soup = joined({soup, (turns >> shell & 1) != 0 ? flipped(nested[shell]) : nested[shell]});
        }
        const OrientedMesh turned = oriented(soup);
        CHECK(turned.shells == 3);
        CHECK(turned.turned_shells == static_cast<std::uint64_t>((turns & 1) + (turns >> 2 & 1) + (~turns >> 1 & 1)));
        CHECK(volume_of(turned) == 1000 - 512 + 216);
    }
}

TEST_CASE("orient: a shell that touches another from inside lies within it; one that crosses it does not",
          "[check][orient]") {
    const Soup body = box({0, 0, 0}, {10, 10, 10});
    CHECK(volume_of(oriented(joined({body, box({0, 3, 1}, {5, 7, 9})}))) == 840);
    CHECK(volume_of(oriented(joined({body, flipped(box({5, 5, 2}, {15, 15, 8}))}))) == 1600);
    CHECK(volume_of(oriented(joined({body, flipped(box({0, 0, 5}, {10, 10, 15}))}))) == 2000);
    CHECK(volume_of(oriented(joined({flipped(body), flipped(box({10, 0, 0}, {12, 3, 3}))}))) == 1018);
    // All corners of the ball lie within the box, or nearly: its faces cross those of the box.
    CHECK(oriented(joined({body, flipped(octasphere({5, 5, 5}, 5.5, 3))})).turned_shells == 1);
    CHECK(oriented(joined({body, octasphere({5, 5, 5}, 4.5, 3)})).turned_shells == 1);
}

TEST_CASE("orient: what is open stays; the answer has the unit, and does not depend on threads", "[check][orient]") {
    Soup open = box({0, 0, 0}, {1, 1, 1});
    open.resize(90);
    CHECK(oriented(flipped(open)).turned_shells == 0);
    const Soup both = joined({open, flipped(box({3, 0, 0}, {4, 1, 1}))});
    const Result<OrientedMesh> beside = orient_shells(MeshView::soup(std::span<const double>(both)));
    REQUIRE(beside.ok());
    CHECK(beside->turned_shells == 1);
    CHECK_FALSE(beside->complete);
    const Soup many = random_tetrahedra(7, 200, 60);
    const OrientedMesh one = oriented(many, 10, {.threads = 1});
    const OrientedMesh several = oriented(many, 10, {.threads = 5});
    CHECK(one.mesh.mm_per_unit == 10);
    CHECK(one.turned_shells > 0);
    CHECK(std::equal(one.mesh.indices.begin(), one.mesh.indices.end(), several.mesh.indices.begin()));
}
