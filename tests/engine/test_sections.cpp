// Sections by planes of any direction: each is what slice() gives with its frame.
#include <random>

#include "engine/slicing.hpp"
#include "lamella/sections.hpp"

using namespace lamella;

namespace {

/// Random directions and places through a mesh of about that size; the first are axes of space.
std::vector<Transform> frames_through(double size, std::size_t count, unsigned seed) {
    std::mt19937 random(seed);
    const auto between = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
    std::vector<Transform> frames;
    for (std::size_t i = 0; i < count; ++i) {
        Transform frame = i == 0 ? Transform() : Transform::from_normal(between(-1, 1), between(-1, 1), between(-1, 1));
        for (std::size_t row = 3; row < 12; row += 4) {
            frame.m[row] = between(-size, size);
        }
        frames.push_back(frame);
    }
    return frames;
}

/// Layer i of the sections has the contours, points and origins of slice() with that frame.
void check_each(const MeshView& mesh, std::span<const Transform> frames, SliceOptions options) {
    const SliceResult sections = value_of(slice_sections(mesh, frames, options));
    REQUIRE(sections.size() == frames.size());
    options.heights_mm = {0};
    options.allow_empty = true;
    const Transform first = options.frame.transform;
    std::size_t crossed = 0;
    for (std::size_t i = 0; i < frames.size(); ++i) {
        INFO("frame " << i);
        options.frame.transform = frames[i] * first;
        const SliceResult alone = value_of(slice(mesh, options));
        const LayerView own = sections[i];
        const LayerView right = alone[0];
        REQUIRE(own.grid_mm == right.grid_mm);
        REQUIRE(own.segments == right.segments);
        REQUIRE(own.plane == right.plane);
        REQUIRE(own.contours.size() == right.contours.size());
        for (std::size_t c = 0; c < own.contours.size(); ++c) {
            const Contour& a = own.contours[c];
            const Contour& b = right.contours[c];
            CHECK((a.role == b.role && a.twice_area == b.twice_area && a.flags == b.flags && a.segments == b.segments));
            CHECK((own.parent_of(a) == nullptr) == (right.parent_of(b) == nullptr));
        }
        CHECK(std::equal(own.points.begin(), own.points.end(), right.points.begin(), right.points.end()));
        CHECK(std::equal(own.origins.begin(), own.origins.end(), right.origins.begin(), right.origins.end()));
        CHECK(own.stitches.size() == right.stitches.size());
        crossed += own.contours.empty() ? 0 : 1;
    }
    CHECK(crossed > frames.size() / 4);
}

void check_each(const shapes::Soup& soup, std::span<const Transform> frames, const SliceOptions& options) {
    check_each(MeshView::soup(soup), frames, options);
}

}  // namespace

TEST_CASE("sections by planes of any direction are those of slices, one by one", "[sections]") {
    const shapes::Soup ball = shapes::octasphere({1, 2, 3}, 10, 5);
    const std::vector<Transform> frames = frames_through(6, 40, 1);
    check_each(ball, frames, {});
    check_each(ball, frames, {.origins = true});
    check_each(ball, frames, {.stitch_mm = 0.5, .region = {.fill_rule = FillRule::non_zero}});
    check_each(shapes::without(ball, 100, 300), frames, {.stitch_mm = 2});
    check_each(generated(models::Shape::bone, 20'000), frames_through(8, 30, 2), {.frame = {.grid_mm = 1e-3}});
    SliceOptions turned;
    turned.frame.transform = Transform::from_normal(1, 2, 3) * Transform::scale(1.5);
    check_each(ball, frames, turned);
    turned.frame.as_mesh_numbers = true;
    check_each(ball, frames, turned);
    check_each(shapes::shuffled(ball, 3), frames, {});
    const std::vector<float> in_floats = shapes::floats(ball);
    const WeldedMesh indexed = value_of(weld(MeshView::soup(in_floats), 0));
    check_each(indexed.view(), frames, {.origins = true});
}

TEST_CASE("joints of sections by the mesh's length cross no wall in a wide gap, as those of slices", "[sections]") {
    // A tube of a metre with a gap of 10 mm, in which a thin wall may stand. The length is a hundredth of the diagonal.
    const shapes::Soup tube = shapes::joined({shapes::wall({0, 0}, {495, 0}), shapes::wall({505, 0}, {1000, 0}),
                                              shapes::wall({1000, 0}, {1000, 1000}), shapes::wall({1000, 1000}, {0, 1000}),
                                              shapes::wall({0, 1000}, {0, 0})});
    const shapes::Soup walled = shapes::joined({tube, shapes::wall({500, -5}, {500, 5}), shapes::wall({500, 5}, {500, -5})});
    std::vector<Transform> frames(3);
    for (std::size_t i = 0; i < frames.size(); ++i) {
        frames[i].m[11] = -1 - 3.0 * static_cast<double>(i);
    }
    const SliceOptions options{.stitch_mm = stitch_by_mesh, .frame = {.grid_mm = 1e-3}};
    check_each(tube, frames, options);
    check_each(walled, frames, options);
    CHECK(value_of(slice_sections(MeshView::soup(tube), frames, options)).info.open_contours == 0);
    CHECK(value_of(slice_sections(MeshView::soup(walled), frames, options)).info.open_contours > 0);
}

TEST_CASE("sections together are held to the limit on memory, on any number of threads", "[sections]") {
    const shapes::Soup soup = shapes::octasphere({0, 0, 0}, 10, 4);
    const std::vector<Transform> frames(50);
    const SliceResult all = value_of(slice_sections(MeshView::soup(soup), frames));
    const std::uint64_t points = all.points.size() * sizeof(Point);
    for (const int threads : {1, 2, 5}) {
        const auto sections = [&](std::uint64_t limit) {
            return slice_sections(MeshView::soup(soup), frames, {}, {.threads = threads, .memory_limit_bytes = limit});
        };
        CHECK(value_of(sections(2 * points)).hash() == all.hash());
        CHECK(error_of(sections(points)).message ==
              "the sections need more than the memory limit of " + std::to_string(points) + " bytes");
        CHECK(error_of(sections(100)).code == ErrorCode::result_too_large);
    }
}

TEST_CASE("sections have the same bytes on any number of threads, and none are a result too", "[sections]") {
    const shapes::Soup soup = shapes::octasphere({0, 0, 0}, 10, 4);
    const MeshView ball = MeshView::soup(soup);
    const std::vector<Transform> frames = frames_through(6, 33, 4);
    const std::uint64_t hash = value_of(slice_sections(ball, frames)).hash();
    for (const int threads : {1, 2, 5}) {
        CHECK(value_of(slice_sections(ball, frames, {}, {.threads = threads})).hash() == hash);
    }
    CHECK(value_of(slice_sections(ball, {})).size() == 0);
}

TEST_CASE("what is wrong with sections names the one", "[sections]") {
    const shapes::Soup soup = shapes::octasphere({0, 0, 0}, 10, 3);
    const MeshView ball = MeshView::soup(soup);
    std::vector<Transform> frames(3);
    frames[1].m[2] = std::numeric_limits<double>::quiet_NaN();
    CHECK(error_of(slice_sections(ball, frames)).message == "section 1: its frame has a number that is not finite");
    frames[1] = Transform::scale(0);
    CHECK(error_of(slice_sections(ball, frames)).code == ErrorCode::invalid_argument);
    frames[1] = {};
    CHECK(error_of(slice_sections(ball, frames, {.region = {.miter_limit = -1}})).code == ErrorCode::invalid_argument);
    CHECK(error_of(slice_sections(ball, frames, {.content = LayerContent::upward_faces})).code ==
          ErrorCode::invalid_argument);
    CHECK(error_of(slice_sections(MeshView{}, frames)).code == ErrorCode::empty_mesh);
    const std::vector<float> xyz = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const std::vector<std::uint32_t> beyond = {0, 1, 3};
    CHECK(error_of(slice_sections(MeshView::indexed(xyz, beyond), frames)).code == ErrorCode::invalid_argument);
}

TEST_CASE("of a section the island around the middle is kept, or the nearest", "[sections]") {
    // A tube around the middle, a rod beside it, and one within the tube's hole, aside from the middle.
    const shapes::Soup soup =
        shapes::joined({shapes::box({-5, -5, 0}, {5, 5, 9}), shapes::flipped(shapes::box({-4, -4, -1}, {4, 4, 10})),
                        shapes::box({6, 0, 0}, {8, 1, 9}), shapes::box({2, 2, 0}, {3, 3, 9})});
    Transform at_rod;
    at_rod.m[3] = -7;
    Transform in_hole;
    in_hole.m[3] = in_hole.m[7] = -1.75;
    std::vector<Transform> frames = {{}, at_rod, in_hole};
    for (Transform& frame : frames) {
        frame.m[11] = -4;
    }
    const SliceResult sections = value_of(slice_sections(MeshView::soup(soup), frames));
    REQUIRE(sections.contours_of(sections.layers[0]).size() == 4);
    const SliceResult kept = value_of(keep_nearest_islands(sections));
    const auto area = [&](std::size_t i) { return std::lround(kept[i].area_mm2()); };
    CHECK(area(0) == 1);  // the middle lies in the hole: the rod in it is nearer than the tube's outer contour
    CHECK(area(1) == 2);
    CHECK(area(2) == 1);
    Transform in_wall;
    in_wall.m[3] = -4.5;
    in_wall.m[11] = -4;
    const SliceResult wall = value_of(keep_nearest_islands(value_of(slice_sections(MeshView::soup(soup), {{in_wall}}))));
    REQUIRE(wall.contours.size() == 2);
    CHECK(std::lround(wall[0].area_mm2()) == 36);
    CHECK(wall.contours[1].parent == 0);
    CHECK(wall.info.holes == 1);
}
