// The ledger accounts for every triangle once, and reports all that no plane cuts.
#include <array>
#include <map>
#include <numeric>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/shapes.hpp"
#include "engine/slicing.hpp"
#include "oracle/oracle.hpp"

using lamella::Ledger;
using lamella::SliceResult;
using lamella::SurfacePiece;
using lamella::SurfacePieceKind;

namespace {

/// Disjoint sets in their simplest form.
class Sets {
public:
    std::size_t add() {
        parents_.push_back(parents_.size());
        return parents_.size() - 1;
    }
    std::size_t find(std::size_t i) const { return parents_[i] == i ? i : find(parents_[i]); }
    void unite(std::size_t a, std::size_t b) { parents_[find(a)] = find(b); }
    std::size_t size() const { return parents_.size(); }

private:
    std::vector<std::size_t> parents_;
};

/// Counts shells, peaks and pits by definition. Each triangle is split at the planes. Its parts are joined to parts of
/// other triangles in the same slab that share a vertex there or a piece of an edge.
std::array<std::size_t, 3> pieces_of(const shapes::Soup& soup, const SliceResult& result) {
    struct Part {
        std::size_t set;
        bool meets_below;
        bool meets_above;
    };
    const auto slab_of = [&](std::int32_t z) {
        std::size_t slab = 0;
        while (slab < result.layers.size() && result.layers[slab].plane.z() < z) {
            ++slab;
        }
        return slab;
    };
    Sets sets;
    std::vector<Part> parts;
    std::map<std::pair<std::size_t, std::pair<lamella::GridVertex, lamella::GridVertex>>, std::size_t> shared;
    for (const oracle::Triangle& t : oracle::quantise(soup, result.info.grid_mm)) {
        const std::array<std::size_t, 3> slabs = {slab_of(t[0].z), slab_of(t[1].z), slab_of(t[2].z)};
        const auto [low, high] = std::minmax({slabs[0], slabs[1], slabs[2]});
        for (std::size_t slab = low; slab <= high; ++slab) {
            const std::size_t set = sets.add();
            parts.push_back({set, slab > low, slab < high});
            for (std::size_t i = 0; i < 3; ++i) {
                const std::size_t next = (i + 1) % 3;
                const auto [first, last] = std::minmax(slabs[i], slabs[next]);
                if (slabs[i] == slab) {
                    sets.unite(set, shared.try_emplace({slab, {t[i], t[i]}}, set).first->second);
                }
                if (first <= slab && slab <= last) {
                    sets.unite(set, shared.try_emplace({slab, std::minmax(t[i], t[next])}, set).first->second);
                }
            }
        }
    }
    std::vector<int> meets(sets.size(), 0);
    for (const Part& part : parts) {
        meets[sets.find(part.set)] |= (part.meets_below ? 1 : 0) | (part.meets_above ? 2 : 0);
    }
    std::array<std::size_t, 3> counts{};
    for (std::size_t set = 0; set < sets.size(); ++set) {
        if (sets.find(set) == set && meets[set] != 3) {
            ++counts[static_cast<std::size_t>(meets[set])];
        }
    }
    return counts;
}

Ledger booked(const shapes::Soup& soup, const SliceResult& result) {
    Ledger books = value_of(audits::ledger_of(result, view_of(soup)));
    CHECK(books.triangles == soup.size() / 9);
    CHECK(books.cut + books.between + books.degenerate == books.triangles);
    CHECK(books.cut == result.info.crossed);
    CHECK(books.degenerate == result.info.degenerate);
    lamella::Slab all;
    for (const lamella::Slab& slab : books.slabs) {
        all.triangles += slab.triangles;
        all.shells += slab.shells;
        all.peaks += slab.peaks;
        all.pits += slab.pits;
        CHECK(slab.triangles + slab.shells + slab.peaks + slab.pits > 0);
    }
    CHECK(all.triangles == books.between);
    CHECK(all.shells == books.shells.count);
    CHECK(all.peaks == books.peaks.count);
    CHECK(all.pits == books.pits.count);
    CHECK(books.shells.triangles + books.peaks.triangles + books.pits.triangles <= books.between);
    CHECK(books.pieces.size() == all.shells + all.peaks + all.pits);
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

TEST_CASE("ledger: a body between two planes and an empty layer between full ones are reported", "[engine][ledger]") {
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

TEST_CASE("ledger: all triangles are accounted for, degenerate and turned ones too", "[engine][ledger]") {
    shapes::Soup soup = shapes::octasphere({0, 0, 0}, 10, 5);
    soup.insert(soup.end(), {1, 1, 1, 1, 1, 1, 2, 2, 2});
    for (const double height : {0.05, 0.7, 30.0}) {
        lamella::SliceOptions options = uniform(height);
        CHECK(booked(soup, sliced(soup, options)).degenerate == 1);
        options.frame.transform = lamella::Transform::from_normal(1, 2, 3);
        (void)booked(soup, sliced(soup, options));
    }
    const SliceResult result = sliced(soup, uniform(1));
    const shapes::Soup other = shapes::box({0, 0, 0}, {1, 1, 1});
    CHECK(audits::ledger_of(result, view_of(other)).error().code == lamella::ErrorCode::invalid_argument);
}

TEST_CASE("ledger: shells, peaks and pits are reported with their positions", "[engine][ledger]") {
    const shapes::Soup soup = shapes::joined({
        shapes::box({0, 0, 0}, {10, 10, 10}),   // its bottom is below all planes, its top between those at 9 and 12
        shapes::octasphere({20, 0, 10}, 1, 0),  // wholly between the planes at 9 and 12
        shapes::octasphere({30, 0, 8}, 3, 0),   // cut at 6 and 9; its top ends between 9 and 12
        shapes::octasphere({40, 0, 12}, 2, 0),  // its bottom lies between 9 and 12
    });
    const SliceResult result = sliced(soup, at_heights({3, 6, 9, 12}));
    const Ledger books = booked(soup, result);
    CHECK(books.shells == lamella::SurfacePieceCount{1, 8});
    CHECK(books.peaks == lamella::SurfacePieceCount{3, 6});
    CHECK(books.pits == lamella::SurfacePieceCount{3, 2});
    REQUIRE(books.pieces.size() == 7);
    CHECK(books.pieces[0] == SurfacePiece{SurfacePieceKind::pit, 0, {0, 0, 0}, 2.5, 2});
    CHECK(books.pieces[1] == SurfacePiece{SurfacePieceKind::pit, 1, {30, 0, 5}, 0.5, 0});
    CHECK(books.pieces[2] == SurfacePiece{SurfacePieceKind::shell, 3, {20, 0, 9}, 2, 8});
    CHECK(books.pieces[3] == SurfacePiece{SurfacePieceKind::peak, 3, {0, 0, 10}, 1.5, 2});
    CHECK(books.pieces[4] == SurfacePiece{SurfacePieceKind::peak, 3, {30, 0, 11}, 2.5, 0});
    CHECK(books.pieces[5] == SurfacePiece{SurfacePieceKind::pit, 3, {40, 0, 10}, 1.5, 0});
    CHECK(books.pieces[6] == SurfacePiece{SurfacePieceKind::peak, 4, {40, 0, 14}, 2.5, 4});
    REQUIRE(books.slabs.size() == 4);
    CHECK(books.slabs[2] == lamella::Slab{3, 10, 100, 0, 1, 2, 1});
    CHECK(name_of(SurfacePieceKind::shell) == "shell");
    CHECK(name_of(SurfacePieceKind::pit) == "pit");
}

TEST_CASE("ledger: pieces agree with their definition", "[engine][ledger]") {
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        const int count = 1 + static_cast<int>(seed % 25);
        const shapes::Soup soup =
            seed % 2 == 0 ? shapes::random_soup(seed, 2 * count, 12) : shapes::random_tetrahedra(seed, count, 9 + seed % 8);
        for (const auto& heights : {std::vector<double>{2, 3, 4, 7, 8}, {5}, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}}) {
            INFO("seed " << seed);
            const SliceResult result = sliced(soup, at_heights(heights));
            const Ledger books = booked(soup, result);
            CHECK(pieces_of(soup, result) ==
                  std::array<std::size_t, 3>{books.shells.count, books.peaks.count, books.pits.count});
        }
    }
}
