// Every triangle is in the ledger once, and what no plane meets is told.
#include <catch2/catch.hpp>

#include "engine/shapes.hpp"
#include "engine/slicing.hpp"

using lamella::Ledger;
using lamella::SliceResult;

namespace {

Ledger booked(const shapes::Soup& soup, const SliceResult& result) {
    const lamella::Result<Ledger> ledger = lamella::ledger(view_of(soup), result);
    REQUIRE(ledger.ok());
    const Ledger& books = ledger.value();
    CHECK(books.triangles == soup.size() / 9);
    CHECK(books.cut + books.between + books.degenerate == books.triangles);
    CHECK(books.cut == result.summary.crossed);
    CHECK(books.degenerate == result.summary.degenerate);
    std::uint64_t in_slabs = 0;
    for (const lamella::Slab& slab : books.slabs) {
        in_slabs += slab.triangles;
        CHECK(slab.triangles > 0);
    }
    CHECK(in_slabs == books.between);
    return books;
}

}  // namespace

TEST_CASE("ledger: a box's bottom and top lie below and above all planes", "[engine][ledger]") {
    const shapes::Soup box = shapes::box({0, 0, 0}, {10, 20, 10});
    const Ledger books = booked(box, sliced(box, at_heights({3, 5})));
    CHECK(books.cut == 8);
    CHECK(books.horizontal == 4);
    CHECK(books.flat_up_mm2 == 200);
    CHECK(books.flat_down_mm2 == 200);
    REQUIRE(books.slabs.size() == 2);
    CHECK(books.slabs[0].layer == 0);
    CHECK(books.slabs[0].flat_down_mm2 == 200);
    CHECK(books.slabs[0].flat_up_mm2 == 0);
    CHECK(books.slabs[1].layer == 2);
    CHECK(books.slabs[1].flat_up_mm2 == 200);
    CHECK(books.gaps.empty());
}

TEST_CASE("ledger: a body between two planes is told, and an empty layer between full ones", "[engine][ledger]") {
    const shapes::Soup soup = shapes::joined({shapes::box({0, 0, 0}, {10, 10, 10}), shapes::box({0, 0, 12}, {10, 10, 14}),
                                              shapes::box({0, 0, 20}, {10, 10, 30})});
    const SliceResult result = sliced(soup, at_heights({5, 11, 15, 25, 40}));
    const Ledger books = booked(soup, result);
    CHECK(books.gaps == std::vector<std::uint64_t>{1, 2});
    REQUIRE(books.slabs.size() == 5);
    CHECK(books.slabs[2].layer == 2);  // between the planes at 11 and 15
    CHECK(books.slabs[2].triangles == 12);
    CHECK(books.slabs[4].layer == 4);
    CHECK(books.cut == 16);
}

TEST_CASE("ledger: degenerate triangles, meshes in any order, turned ones and real ones add up", "[engine][ledger]") {
    shapes::Soup soup = shapes::octasphere({0, 0, 0}, 10, 5);
    soup.insert(soup.end(), {1, 1, 1, 1, 1, 1, 2, 2, 2});
    for (const double height : {0.05, 0.7, 30.0}) {
        lamella::SliceOptions options = uniform(height);
        CHECK(booked(soup, sliced(soup, options)).degenerate == 1);
        options.transform = lamella::Transform::from_normal(1, 2, 3);
        (void)booked(soup, sliced(soup, options));
    }
    const SliceResult result = sliced(soup, uniform(1));
    const shapes::Soup other = shapes::box({0, 0, 0}, {1, 1, 1});
    CHECK(lamella::ledger(view_of(other), result).error().code == lamella::Code::invalid_argument);
}
