// Judgements of a mesh or a result, files written of it, and contours from segments.
#include <catch2/catch.hpp>

#include "golden/calls.hpp"

namespace golden {

namespace {

/// Calls look(name, mesh) for those of the named meshes that are the committed ones.
template <class Look>
void each_mesh(const std::vector<std::string>& names, const Look& look) {
    for (const std::string& name : names) {
        const Soup soup = mesh(name);
        if (same_input(name, hash_of(soup))) {
            const HeldMesh held(soup, Form::f32_soup);
            look(name, held.view());
        }
    }
}

const std::vector<std::string> all_kinds = {
    "voxel body",        "torn body",           "cracked body", "body of mixed senses", "body with degenerate faces",
    "crossing bodies",   "overlapping boxes",   "nested boxes", "checkerboard",         "tetrahedra",
    "lattice triangles", "self-crossing prisms"};

/// A closed polygon, its corners keyed from `first` on.
void add_polygon(Segments& segments, const std::vector<std::array<std::int32_t, 2>>& corners, std::uint64_t first) {
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const std::size_t next = (i + 1) % corners.size();
        segments.push_back(segment(first + i, first + next, corners[i], corners[next]));
    }
}

/// Squares within squares, every third one clockwise.
Segments nested_squares() {
    Segments segments;
    for (std::int32_t i = 0; i < 40; ++i) {
        const std::int32_t a = 3 * i;
        const std::int32_t b = 400 - 3 * i;
        const bool backwards = i % 3 == 1;
        add_polygon(segments,
                    {{a, a}, {backwards ? a : b, backwards ? b : a}, {b, b}, {backwards ? b : a, backwards ? a : b}},
                    static_cast<std::uint64_t>(4 * i));
    }
    return segments;
}

/// Segments between random points of a lattice, so that many meet at a key, some both ways, and some at no other.
Segments random_segments(std::uint64_t seed, int count, int range) {
    SplitMix random(seed);
    const auto key = [&](const std::array<std::int32_t, 2>& p) { return static_cast<std::uint64_t>(p[0] * 1000 + p[1]); };
    Segments segments;
    for (int i = 0; i < count; ++i) {
        const std::array<std::int32_t, 2> from{random.between(0, range), random.between(0, range)};
        const std::array<std::int32_t, 2> to{random.between(0, range), random.between(0, range)};
        const auto from_rank = static_cast<std::uint32_t>(random.between(0, 5));
        segments.push_back(
            segment(key(from), key(to), from, to, from_rank, static_cast<std::uint32_t>(random.between(0, 5))));
    }
    return segments;
}

}  // namespace

TEST_CASE("welded meshes are those committed", "[golden]") {
    Group group("weld");
    each_mesh({"voxel body", "cracked body", "lattice triangles"}, [&](const std::string& name, const auto& mesh) {
        add_weld(group, name + ", exact", mesh, 0);
        add_weld(group, name + ", near", mesh, 0.078125);
        add_weld(group, name + ", far", mesh, 1.25);
    });
    each_mesh({"cracked body"}, [&](const std::string& name, const auto&) {
        add_weld(group, name + ", doubles", HeldMesh(mesh(name)).view(), 0.078125);
        add_weld(group, name + ", indexed", HeldMesh(mesh(name), Form::f64_indexed).view(), 0.078125);
    });
    group.finish();
}

TEST_CASE("ledgers, certificates and crossings are those committed", "[golden]") {
    Group group("audit");
    each_mesh(all_kinds, [&](const std::string& name, const auto& mesh) {
        add_audit(group, name, mesh, uniform(0.75));
        add_audit(group, name + ", thick layers", mesh, above(uniform(2.5)));
        add_audit(group, name + ", turned", mesh, turned(1, 2, 3, uniform(1.5)));
    });
    each_mesh({"crossing bodies", "torn body"}, [&](const std::string& name, const auto& mesh) {
        add_audit(group, name + ", non-zero", mesh, filled(Rule::non_zero, uniform(1.5)));
    });
    group.finish();
}

TEST_CASE("reports and SVG files are those committed", "[golden]") {
    Group group("written");
    each_mesh(all_kinds, [&](const std::string& name, const auto& mesh) { add_written(group, name, mesh, uniform(1.5)); });
    each_mesh({"torn body", "tetrahedra"}, [&](const std::string& name, const auto& mesh) {
        add_written(group, name + ", explicit", mesh, turned(1, 1, 1, at_heights({-4, 0, 1.5, 3, 10.1})));
        add_written(group, name + ", gaps closed", mesh, filled(Rule::positive, stitched(1, uniform(1.5))));
        add_written(group, name + ", coarse grid", mesh, on_grid(0x1p-4, uniform_from(0.25, 1.5)));
    });
    group.finish();
}

TEST_CASE("diagnoses of meshes are those committed", "[golden]") {
    Group group("check");
    each_mesh(all_kinds, [&](const std::string& name, const auto& mesh) { add_check(group, name, mesh); });
    group.finish();
}

TEST_CASE("contours from segments are those committed", "[golden]") {
    Group group("assemble");
    const std::pair<std::string, Segments> all[] = {{"nested squares", nested_squares()},
                                                    {"few segments on a fine lattice", random_segments(1, 400, 30)},
                                                    {"many segments on a coarse lattice", random_segments(2, 2000, 9)},
                                                    {"a bundle", random_segments(3, 300, 2)}};
    for (const auto& [name, segments] : all) {
        add_assembled(group, name, segments);
    }
    group.finish();
}

}  // namespace golden
