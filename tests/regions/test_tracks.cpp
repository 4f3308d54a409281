// Islands from layer to layer, judged cell by cell: on a lattice, islands, voids and what they share are sets of triangles.
#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <tuple>

#include <catch2/catch.hpp>

#include "base/numbers.hpp"
#include "c/call.hpp"
#include "engine/c_handles.hpp"
#include "engine/region_checks.hpp"
#include "engine/slicing.hpp"
#include "lamella/tracks.hpp"
#include "regions/region.hpp"

using namespace lamella;
using regions::Polygon;
using regions::Polygons;

namespace {

constexpr RegionRules positive{.fill_rule = FillRule::positive};

/// Slabs of 1 mm, each with the region of its polygons, on a grid of 1 mm.
SliceResult stack_of(const std::vector<Polygons>& layers, const std::function<RegionRules(std::size_t)>& rules) {
    std::vector<SliceResult> each;
    SliceResult stack;
    std::size_t contours = 0;
    std::size_t points = 0;
    for (const Polygons& polygons : layers) {
        each.push_back(value_of(regions::region(polygons, rules(each.size()), 1)));
        contours += each.back().contours.size();
        points += each.back().points.size();
    }
    stack.info.grid_mm = 1;
    stack.layers.resize_discarding(layers.size());
    stack.contours.resize_discarding(contours);
    stack.points.resize_discarding(points);
    contours = points = 0;
    for (std::size_t n = 0; n < each.size(); ++n) {
        stack.layers[n] = {
            .bottom_mm = double(n), .plane_mm = double(n) + 0.5, .top_mm = double(n + 1), .first_contour = contours};
        stack.layers[n].contour_count = each[n].contours.size();
        for (Contour contour : each[n].contours) {
            contour.first_point += points;
            contour.parent += contour.parent < 0 ? 0 : std::int64_t(stack.layers[n].first_contour);
            stack.contours[contours++] = contour;
        }
        std::copy(each[n].points.begin(), each[n].points.end(), stack.points.begin() + points);
        points += each[n].points.size();
    }
    return stack;
}

SliceResult stack_of(const std::vector<Polygons>& layers) {
    return stack_of(layers, [](std::size_t) { return positive; });
}

Polygon rectangle(std::int32_t x, std::int32_t y, std::int32_t to_x, std::int32_t to_y) {
    return {{x, y}, {to_x, y}, {to_x, to_y}, {x, to_y}};
}
Polygon square(std::int32_t low, std::int32_t high) {
    return rectangle(low, low, high, high);
}
/// With a hole.
Polygons frame(std::int32_t low, std::int32_t high, std::int32_t hole_low, std::int32_t hole_high) {
    Polygons both = {square(low, high), square(hole_low, hole_high)};
    std::reverse(both[1].begin(), both[1].end());
    return both;
}

/// "islands links births merges", then pockets.
std::string summary(const std::vector<Polygons>& layers, bool drop_collinear = false) {
    const Tracks tracks = value_of(find_tracks(stack_of(layers,
                                                        [=](std::size_t) {
                                                            return RegionRules{.fill_rule = FillRule::positive,
                                                                               .drop_collinear = drop_collinear};
                                                        }),
                                               {.pockets = true}));
    const auto count = [&](auto test) {
        return std::to_string(std::count_if(tracks.islands.begin(), tracks.islands.end(), test));
    };
    std::string text = std::to_string(tracks.islands.size()) + " " + std::to_string(tracks.links.size()) + " " +
                       count([](const Track& t) { return t.below == 0; }) + " " +
                       count([](const Track& t) { return t.below > 1; });
    for (const Pocket& pocket : tracks.pockets) {
        text += (pocket.is_cavity ? " cavity " : " cup ") + std::to_string(pocket.first_layer) + "-" +
                std::to_string(pocket.end_layer) + ":" + std::to_string(int(pocket.volume_mm3));
    }
    return text;
}

// A lattice of cells in an empty border, each cut into four triangles by its diagonals: bottom, right, top, left.
constexpr int side = 6;
constexpr int cells = 4 * side * side;
using Cells = std::vector<char>;

/// Orientation stays, and no edge lies along an axis.
Point placed(std::int32_t x, std::int32_t y) {
    return {7 * x + 2 * y - 40, -3 * x + 5 * y};
}

Polygon cell_at(int number) {
    const std::int32_t x = 12 * (number / 4 % side);
    const std::int32_t y = 12 * (number / 4 / side);
    const std::array<std::array<std::int32_t, 2>, 4> corners{{{x, y}, {x + 12, y}, {x + 12, y + 12}, {x, y + 12}}};
    const auto& a = corners[std::size_t(number % 4)];
    const auto& b = corners[std::size_t((number % 4 + 1) % 4)];
    return {placed(a[0], a[1]), placed(b[0], b[1]), placed(x + 6, y + 6)};
}

bool touch(int a, int b, bool along_an_edge) {
    const Polygon of_a = cell_at(a);
    const Polygon of_b = cell_at(b);
    const auto shared =
        std::count_if(of_a.begin(), of_a.end(), [&](Point p) { return std::count(of_b.begin(), of_b.end(), p) != 0; });
    return shared >= (along_an_edge ? 2 : 1);
}

/// Triangles that touch, along an edge for solids, in a point for voids.
const std::vector<int>& neighbours(int cell, bool solid) {
    static const auto all = [] {
        std::array<std::vector<std::vector<int>>, 2> lists{std::vector<std::vector<int>>(cells),
                                                           std::vector<std::vector<int>>(cells)};
        for (int a = 0; a < cells; ++a) {
            for (int b = 0; b < cells; ++b) {
                for (const int solids : {0, 1}) {
                    if (a != b && touch(a, b, solids != 0)) {
                        lists[std::size_t(solids)][std::size_t(a)].push_back(b);
                    }
                }
            }
        }
        return lists;
    }();
    return all[solid ? 1 : 0][std::size_t(cell)];
}

bool in_border(int cell) {
    const int x = cell / 4 % side;
    const int y = cell / 4 / side;
    return x == 0 || y == 0 || x == side - 1 || y == side - 1;
}

/// Numbers from 0 for sets of cells (layer, cell) of layers up to `end` that hang together; -1 for the others.
std::vector<std::vector<int>> flooded(const std::vector<Cells>& layers, std::size_t begin, std::size_t end, bool solid) {
    std::vector<std::vector<int>> numbers(layers.size(), std::vector<int>(cells, -1));
    int next = 0;
    std::vector<std::pair<std::size_t, int>> open;
    const auto enter = [&](std::size_t n, int c) {
        if ((layers[n][std::size_t(c)] != 0) == solid && numbers[n][std::size_t(c)] < 0) {
            numbers[n][std::size_t(c)] = next;
            open.emplace_back(n, c);
        }
    };
    for (std::size_t first = begin; first < end; ++first) {
        for (int start = 0; start < cells; ++start) {
            enter(first, start);
            next += open.empty() ? 0 : 1;
            for (; !open.empty();) {
                const auto [n, c] = open.back();
                open.pop_back();
                --next;
                for (const int other : neighbours(c, solid)) {
                    enter(n, other);
                }
                if (n > begin) {
                    enter(n - 1, c);
                }
                if (n + 1 < end) {
                    enter(n + 1, c);
                }
                ++next;
            }
        }
    }
    return numbers;
}

using PocketKey = std::tuple<std::uint64_t, std::uint64_t, bool, double>;

/// By flooding the layers up to each one.
std::multiset<PocketKey> pockets_of(const std::vector<Cells>& layers) {
    struct Space {
        bool open = false;
        std::size_t first = ~std::size_t{0};
        double volume = 0;
        std::set<std::size_t> in;  // layers
    };
    const auto spaces_up_to = [&](std::size_t end, const std::vector<std::vector<int>>& numbers) {
        std::map<int, Space> spaces;
        for (std::size_t n = 0; n < end; ++n) {
            for (int c = 0; c < cells; ++c) {
                if (numbers[n][std::size_t(c)] >= 0) {
                    Space& space = spaces[numbers[n][std::size_t(c)]];
                    space.open = space.open || n == 0 || in_border(c);
                    space.first = std::min(space.first, n);
                    space.volume += double(rings::twice_area(cell_at(c))) / 2;
                    space.in.insert(n);
                }
            }
        }
        return spaces;
    };
    std::multiset<PocketKey> found;
    for (std::size_t end = 1; end <= layers.size(); ++end) {
        const auto numbers = flooded(layers, 0, end, false);
        const auto next = flooded(layers, 0, std::min(end + 1, layers.size()), false);
        const auto then = spaces_up_to(std::min(end + 1, layers.size()), next);
        for (const auto& [number, space] : spaces_up_to(end, numbers)) {
            if (space.open || space.in.count(end - 1) == 0) {
                continue;
            }
            const auto at = std::find(numbers[end - 1].begin(), numbers[end - 1].end(), number) - numbers[end - 1].begin();
            const Space& after = then.at(next[end - 1][std::size_t(at)]);
            const bool closed = end < layers.size() && !after.open && after.in.count(end) == 0;
            if (closed || end == layers.size() || after.open) {
                found.emplace(end, space.first, closed, space.volume);
            }
        }
    }
    return found;
}

struct Judged {
    std::vector<std::set<int>> islands;  // cells, plus `cells` for each layer
    std::set<std::pair<std::set<int>, std::set<int>>> links;
};

/// By flooding each layer.
Judged judged(const std::vector<Cells>& layers) {
    Judged all;
    std::vector<std::map<int, std::set<int>>> of(layers.size());
    for (std::size_t n = 0; n < layers.size(); ++n) {
        const auto numbers = flooded(layers, n, n + 1, true)[n];
        for (int c = 0; c < cells; ++c) {
            if (numbers[std::size_t(c)] >= 0) {
                of[n][numbers[std::size_t(c)]].insert(int(n) * cells + c);
            }
        }
        for (const auto& [number, island] : of[n]) {
            all.islands.push_back(island);
            for (const auto& [other, others] : n == 0 ? std::map<int, std::set<int>>() : of[n - 1]) {
                if (std::any_of(island.begin(), island.end(),
                                [&lower = others](int c) { return lower.count(c - cells) != 0; })) {
                    all.links.emplace(others, island);
                }
            }
        }
    }
    std::sort(all.islands.begin(), all.islands.end());
    return all;
}

/// The cells of an island.
std::set<int> cells_of(const SliceResult& stack, const Track& track) {
    std::set<int> own;
    for (const Island island : stack[track.layer].islands()) {
        if (island.outer != &stack.contours[track.contour]) {
            continue;
        }
        for (int c = 0; c < cells; ++c) {
            const Polygon corners = cell_at(c);
            const rings::Place middle{corners[0].x + corners[1].x + corners[2].x, corners[0].y + corners[1].y + corners[2].y,
                                      3};
            int winding = *rings::winding(stack.points_of(*island.outer), middle);
            for (const Contour& hole : island.holes) {
                winding += *rings::winding(stack.points_of(hole), middle);
            }
            if (winding == 1) {
                own.insert(int(track.layer) * cells + c);
            }
        }
    }
    return own;
}

std::vector<Cells> random_layers(std::mt19937& random) {
    std::vector<Cells> layers(2 + random() % 4, Cells(cells));
    const bool whole = random() % 4 != 0;  // squares
    for (std::size_t n = 0; n < layers.size(); ++n) {
        const unsigned filled = 8 + random() % 12;  // of 20
        const unsigned kept = random() % 10;
        for (int c = 0; c < cells; ++c) {
            const bool as_before = n > 0 && random() % 10 < kept;
            const bool solid = as_before ? layers[n - 1][std::size_t(c)] != 0 : random() % 20 < filled;
            layers[n][std::size_t(c)] =
                !in_border(c) && (whole && c % 4 != 0 ? layers[n][std::size_t(c - 1)] != 0 : solid) ? 1 : 0;
        }
    }
    return layers;
}

SliceResult stack_of(const std::vector<Cells>& layers, std::mt19937& random) {
    std::vector<Polygons> polygons(layers.size());
    for (std::size_t n = 0; n < layers.size(); ++n) {
        for (int c = 0; c < cells; ++c) {
            if (layers[n][std::size_t(c)] != 0) {
                polygons[n].push_back(cell_at(c));
            }
        }
        std::shuffle(polygons[n].begin(), polygons[n].end(), random);
    }
    return stack_of(polygons, [&](std::size_t) {
        return RegionRules{.fill_rule = FillRule::positive, .drop_collinear = random() % 2 == 0};
    });
}

void check_arrays(const Tracks& tracks) {
    std::vector<std::uint32_t> body(tracks.islands.size());
    std::iota(body.begin(), body.end(), 0);
    for (bool changed = true; changed;) {
        changed = false;
        for (const TrackLink& link : tracks.links) {
            const std::uint32_t least = std::min(body[link.lower], body[link.upper]);
            changed = changed || body[link.lower] != least || body[link.upper] != least;
            body[link.lower] = body[link.upper] = least;
        }
    }
    std::map<std::uint32_t, std::uint32_t> numbers;
    for (std::uint32_t i = 0; i < tracks.islands.size(); ++i) {
        const Track& track = tracks.islands[i];
        for (std::uint32_t k = 0; k < track.above; ++k) {
            REQUIRE(tracks.links[track.first_above + k].lower == i);
        }
        for (std::uint32_t k = 0; k < track.below; ++k) {
            REQUIRE(tracks.links[tracks.links_by_upper[track.first_below + k]].upper == i);
        }
        numbers.emplace(body[i], numbers.size());
        REQUIRE(track.body == numbers[body[i]]);
    }
    REQUIRE(tracks.bodies == numbers.size());
    const auto sum = [&](auto of) {
        return std::accumulate(tracks.islands.begin(), tracks.islands.end(), std::size_t{0},
                               [&](std::size_t s, const Track& t) { return s + t.*of; });
    };
    REQUIRE(sum(&Track::above) == tracks.links.size());
    REQUIRE(sum(&Track::below) == tracks.links.size());
}

template <class T>
bool are_same(const Array<T>& a, const Array<T>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

bool are_equal(const Tracks& a, const Tracks& b) {
    return are_same(a.islands, b.islands) && are_same(a.links, b.links) && are_same(a.links_by_upper, b.links_by_upper) &&
           are_same(a.pockets, b.pockets) && a.bodies == b.bodies;
}

}  // namespace

TEST_CASE("islands and pockets of squares are the known ones", "[regions][tracks]") {
    const Polygons two = {square(0, 2), rectangle(4, 0, 6, 2)};
    CHECK(summary({two, two, {rectangle(0, 0, 6, 2)}}) == "5 4 2 1");
    CHECK(summary({{square(0, 2)}, {square(2, 4)}}) == "2 0 2 0");
    CHECK(summary({{square(0, 2)}, {rectangle(2, 0, 4, 2)}}) == "2 0 2 0");
    CHECK(summary({frame(0, 7, 1, 6), {square(3, 4)}}) == "2 0 2 0");
    CHECK(summary({frame(0, 7, 1, 6), {square(1, 6)}, frame(0, 7, 1, 6)}) == "3 0 3 0 cup 2-3:25");
    CHECK(summary({{square(0, 7)}, frame(1, 6, 3, 4), frame(0, 7, 3, 4)}) == "3 2 1 0 cup 1-3:2");
    CHECK(summary({{square(0, 6)}, frame(0, 6, 2, 4), {square(0, 6)}}) == "3 2 1 0 cavity 1-2:4");
    CHECK(summary({{square(0, 6)}, frame(0, 6, 2, 4)}) == "2 1 1 0 cup 1-2:4");
    CHECK(summary({frame(0, 6, 2, 4), frame(0, 6, 2, 4), {square(0, 6)}}) == "3 2 1 0");
    CHECK(summary({{}, {}}) == "0 0 0 0");
    CHECK(summary({}) == "0 0 0 0");
    // Two holes that touch in a point are one void, over which a lid and an opening lie.
    const Polygons holes = {square(0, 8), {{2, 2}, {2, 4}, {4, 4}, {4, 2}}, {{4, 4}, {4, 6}, {6, 6}, {6, 4}}};
    CHECK(summary({{square(0, 8)}, holes, frame(0, 8, 4, 6)}) == "3 2 1 0 cup 1-3:12");
    CHECK(summary({{square(0, 8)}, holes, {square(0, 8)}}) == "3 2 1 0 cavity 1-2:8");
    // An island's corner on another's edge, which has no corner there, as the edge of the void above that fits it has not.
    Polygons two_inside = frame(-20, 28, -4, 12);
    two_inside.insert(two_inside.end(), {rectangle(0, 0, 8, 4), {{4, 4}, {6, 6}, {2, 6}}});
    Polygons above = {square(-20, 28), {{0, 0}, {0, 4}, {8, 4}, {8, 0}}};
    CHECK(summary({{square(-20, 28)}, two_inside, above, {square(-20, 28)}}, true) ==
          "6 6 1 1 cavity 1-2:220 cavity 2-3:32");
    // Two contours that cross where corners of both layers lie: all around that point is solid in one of them.
    const Polygons pinched = {{{92, 84},   {344, -24}, {398, -12}, {368, 36},  {452, 0},   {476, 60},  {392, 96},
                               {416, 156}, {332, 192}, {308, 132}, {254, 120}, {194, 216}, {248, 228}, {164, 264},
                               {116, 144}, {170, 156}, {200, 108}, {284, 72},  {230, 60},  {200, 108}, {116, 144}},
                              {{224, 168}, {308, 132}, {278, 180}},
                              {{248, 228}, {278, 180}, {332, 192}},
                              {{320, -84}, {374, -72}, {344, -24}},
                              {{416, 156}, {476, 60}, {500, 120}}};
    const Polygons over = {{{68, 24}, {152, -12}, {176, 48}, {92, 84}},
                           {{92, 84},
                            {146, 96},
                            {176, 48},
                            {260, 12},
                            {152, -12},
                            {320, -84},
                            {344, -24},
                            {374, -72},
                            {320, -84},
                            {404, -120},
                            {500, 120},
                            {164, 264}},
                           {{170, 156}, {278, 180}, {308, 132}, {224, 168}, {200, 108}},
                           {{284, 72}, {338, 84}, {368, 36}, {314, 24}}};
    CHECK(summary({pinched, over}, true) == "7 3 6 1 cup 1-2:2952 cup 1-2:2952");
}

TEST_CASE("areas and centres are exact far from the origin", "[regions][tracks]") {
    constexpr std::int32_t far = grid_limit;
    const Tracks tracks = value_of(find_tracks(stack_of({frame(far - 8, far, far - 6, far - 4), {square(-far, far)}})));
    REQUIRE(tracks.islands.size() == 2);
    CHECK(tracks.islands[0].area_mm2 == 60);
    CHECK(tracks.islands[0].centroid_mm[0] == Approx(far - 4 + 4.0 / 60).margin(1e-6));
    CHECK(tracks.islands[1].area_mm2 == 4.0 * far * far);
    CHECK(tracks.islands[1].centroid_mm == std::array<double, 2>{0, 0});
}

TEST_CASE("lattices are followed as their cells are", "[regions][tracks]") {
    std::mt19937 random(20261130);
    std::size_t links = 0;
    std::size_t pockets = 0;
    for (int turn = 0; turn < 1000; ++turn) {
        const std::vector<Cells> layers = random_layers(random);
        SliceResult stack = stack_of(layers, random);
        const Tracks tracks = value_of(find_tracks(stack, {.pockets = true}));
        const Judged expected = judged(layers);
        INFO("turn " << turn);
        Judged found;
        for (const Track& track : tracks.islands) {
            found.islands.push_back(cells_of(stack, track));
        }
        for (const TrackLink& link : tracks.links) {
            found.links.emplace(found.islands[link.lower], found.islands[link.upper]);
        }
        REQUIRE(found.links.size() == tracks.links.size());
        std::sort(found.islands.begin(), found.islands.end());
        REQUIRE(found.islands == expected.islands);
        REQUIRE(found.links == expected.links);
        check_arrays(tracks);
        std::multiset<PocketKey> own;
        for (const Pocket& pocket : tracks.pockets) {
            own.emplace(pocket.end_layer, pocket.first_layer, pocket.is_cavity, pocket.volume_mm3);
            REQUIRE(stack.contours[pocket.contour].role == Role::hole);
        }
        REQUIRE(own == pockets_of(layers));
        for (const Contour& contour : stack.contours) {  // from other starts
            const auto first = stack.points.begin() + contour.first_point;
            std::rotate(first, first + random() % contour.point_count, first + contour.point_count);
        }
        REQUIRE(are_equal(value_of(find_tracks(stack, {.pockets = true}, {.threads = 1})), tracks));
        const Tracks alone = value_of(find_tracks(stack));
        REQUIRE((alone.pockets.empty() && are_same(alone.links, tracks.links)));
        links += tracks.links.size();
        pockets += tracks.pockets.size();
    }
    CHECK(links > 1000);
    CHECK(pockets > 50);
}

TEST_CASE("many islands have one answer on any threads, through C too", "[regions][tracks][threads][c]") {
    const shapes::Soup soup = generated(models::Shape::gyroid, 20000);
    SliceOptions options = uniform(0.05);
    options.region.fill_rule = FillRule::non_zero;
    lamella_result held{sliced(soup, options)};
    const Tracks tracks = value_of(find_tracks(held.result, {.pockets = true}, {.threads = 1}));
    check_arrays(tracks);
    REQUIRE(tracks.islands.size() > 500);
    CHECK(are_equal(value_of(find_tracks(held.result, {.pockets = true}, {.threads = 8})), tracks));

    auto how = c_handles::fresh<lamella_track_options>(LAMELLA_TRACK_OPTIONS);
    how.pockets = 1;
    lamella_tracks* found = nullptr;
    REQUIRE(lamella_find_tracks(&held, &how, nullptr, &found, nullptr) == LAMELLA_OK);
    auto view = c_handles::fresh<lamella_track_arrays>(LAMELLA_TRACK_ARRAYS);
    lamella_tracks_view(found, &view);
    CHECK(are_equal(found->tracks, tracks));
    CHECK((view.island_count == tracks.islands.size() && view.link_count == tracks.links.size() &&
           view.pocket_count == tracks.pockets.size() && view.bodies == tracks.bodies));
    CHECK(view.islands[view.island_count - 1].body == (tracks.islands.end() - 1)->body);
    lamella_tracks_free(found);
    lamella_tracks_view(nullptr, &view);
    CHECK((view.islands == nullptr && view.island_count == 0));
    CHECK(lamella_find_tracks(nullptr, nullptr, nullptr, &found, nullptr) == LAMELLA_INVALID_ARGUMENT);
}

TEST_CASE("layers of which islands are not known are refused", "[regions][tracks][errors]") {
    SliceResult stack = stack_of({{square(0, 2)}, {square(0, 2)}});
    CHECK(error_of(find_tracks(stack, {}, {.memory_limit_bytes = 100})).code == ErrorCode::result_too_large);
    CHECK(error_of(find_tracks(stack, {}, {.memory_limit_bytes = 130})).message ==
          "2 islands with 1 links need more than the memory limit of 130 bytes");
    stack.points[5].y = -grid_limit - 1;
    CHECK(error_of(find_tracks(stack)).message == "layer 1 has a point beyond the grid, which ends at 1073741824 units");
    stack.contours[1].role = Role::flat;
    CHECK(value_of(find_tracks(stack)).islands.size() == 1);
    stack.contours[1].role = Role::open;
    CHECK(error_of(find_tracks(stack)).message ==
          "layer 1 has an open contour, which bounds no island: close the mesh, or slice with a longer stitch_mm");
}
