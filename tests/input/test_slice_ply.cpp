// Binary PLY sliced in ranges gives what slice() gives of the whole mesh.
#include <string>
#include <vector>

#include "engine/counting_memory.hpp"
#include "engine/shapes.hpp"
#include "input/ply_writer.hpp"
#include "input/read.hpp"
#include "input/slices_in_ranges.hpp"
#include "lamella/io.hpp"
#include "models/models.hpp"

using namespace lamella;
using namespace lamella::input_test;
using Catch::Contains;
using ply_test::PlyVariant;

namespace {

std::string ply_of(const shapes::Soup& soup, const PlyVariant& form) {
    return ply_test::ply(form, shapes::indexed(soup));
}

constexpr std::string_view little = "binary_little_endian";
constexpr std::string_view big = "binary_big_endian";

shapes::Soup soup_of(models::Shape shape, models::Order order, std::uint64_t triangles) {
    const std::vector<float> soup = models::make_soup({.shape = shape, .triangles = triangles, .order = order});
    return {soup.begin(), soup.end()};
}

}  // namespace

TEST_CASE("binary PLY gives the same layers in ranges", "[slice_file][threads]") {
    using enum models::Shape;
    using enum models::Order;
#ifdef LAMELLA_TESTS_SANITIZED
    const PlyVariant form{.encoding = big, .coordinate = "double", .index = "uint", .extra_numbers = true};
#else
    const auto form =
        GENERATE(PlyVariant{.encoding = little}, PlyVariant{.encoding = big, .coordinate = "double", .index = "uint"},
                 PlyVariant{.encoding = little, .coordinate = "double", .extra_numbers = true},
                 PlyVariant{.encoding = big, .index = "uint", .extra_numbers = true});
#endif
    shapes::Soup soup;
    SliceOptions options = uniform(0.6);
    SECTION("in the order of height") {
        soup = soup_of(bone, z, 60'000);
    }
    SECTION("in any order") {
        soup = soup_of(gyroid, random, 60'000);
    }
    SECTION("of a few small numbers, with all that soup can have") {
        soup = shapes::shuffled(shapes::joined({shapes::random_soup(3, 3000, 40), shapes::octasphere({9, 9, 9}, 7, 4)}), 3);
    }
    SECTION("moved, on another grid") {
        soup = shapes::scaled(shapes::shuffled(shapes::octasphere({0, 0, 10}, 10, 6), 11), {1 / 3.0, 1 / 3.0, 2 / 3.0});
        options.frame.transform = Transform::from_normal(1, 2, 3);
        options.frame.grid_mm = 0.001;
    }
    require_same_at_all_budgets(dir.write("mesh.ply", ply_of(soup, form)), options);
}

TEST_CASE("vertices count against the budget", "[slice_file]") {
    const auto order = GENERATE(models::Order::z, models::Order::random);
    const auto* const number = GENERATE("float", "double");
    const auto soup = soup_of(models::Shape::bone, order, 100'000);
    const auto path = dir.write("mesh.ply", ply_of(soup, {.encoding = little, .coordinate = number}));
    for (const double height : budget_heights_mm) {
        for (const int threads : {1, 2}) {
            CountingMemory memory;
            const SliceOptions options = uniform(height);
            const StreamOptions stream{.memory_bytes = least_budget(path, options, {.threads = threads})};
            INFO(stream.memory_bytes << " bytes, " << threads << " threads");
            CHECK(refusal_of(path, stream, options, {.threads = threads, .memory = &memory}).empty());
            CHECK(memory.peak() <= stream.memory_bytes);
        }
    }
    CHECK_THAT(refusal_of(path, {.memory_bytes = 10'000}), Contains("vertices stay in memory, which takes at least"));
}

TEST_CASE("a damaged PLY is refused as in memory", "[slice_file]") {
    const PlyVariant form =
        GENERATE(PlyVariant{.encoding = little}, PlyVariant{.encoding = big, .coordinate = "double", .extra_numbers = true});
    const std::string good = ply_of(shapes::octasphere({0, 0, 10}, 10, 5), form);
    const std::size_t begin = form.extra_numbers ? 9 : 0;  // of what stands before the list, and after it
    const std::size_t row = 13 + 2 * begin;
    const std::size_t face = good.size() - (8192 - 5000) * row + begin;  // of one in the middle
    const auto refused = [&](const std::string& bytes) { return refusal_of(dir.write("a.ply", bytes)); };
    const auto require_as_in_memory = [&](const std::string& bytes) {
        const std::string message = refused(bytes);
        const auto read = read_mesh(dir / "a.ply");
        CHECK(message == (read ? slice(*read).error().message : read.error().message));
    };
    for (const std::size_t cut : {std::size_t{1}, row - 1, row, row + 1, 100 * row, 8192 * row + 5}) {
        INFO("ends " << cut << " bytes early");
        require_as_in_memory(good.substr(0, good.size() - cut));
    }
    require_as_in_memory(good.substr(0, 90));
    std::string bad = good;
    bad.replace(face + 1, 4, "\x7f\x7f\x7f\x7f");
    require_as_in_memory(bad);
    require_as_in_memory(bad.substr(0, bad.size() - 7));
    bad.replace(face + 1, 4, "\xff\xff\xff\xff");
    require_as_in_memory(bad);
    bad = good;
    bad[face] = 4;
    CHECK_THAT(refused(bad), Contains("face 5000 has 4 corners: only triangles"));
    bad[face] = 2;
    CHECK_THAT(refused(bad.substr(0, bad.size() - 1)), Contains("face 5000 has 2 corners: only triangles"));
    bad = good;
    bad.replace(good.size() - 8192 * row - begin - 8, 8, std::string(8, '\xff'));  // of the last vertex
    const std::string message = refused(bad);
    CHECK_THAT(message, Contains("is not finite"));
    CHECK_THAT(message, Contains(slice(*read_mesh(dir / "a.ply")).error().message));
}

TEST_CASE("a PLY that cannot be read in pieces is refused by name", "[slice_file]") {
    const auto refused = [&](const std::string& bytes) { return refusal_of(dir.write("a.ply", bytes)); };
    const std::string good = ply_of(shapes::box({0, 0, 0}, {5, 5, 5}), {.encoding = little});
    const auto with = [&](const std::string& from, const std::string& to) {
        return std::string(good).replace(good.find(from), from.size(), to);
    };
    CHECK_THAT(refused(with("uchar int", "uchar float")), Contains("'face' has other lists"));
    CHECK_THAT(refused(with("element face", "element tristrips")), Contains("'tristrips' has other lists"));
    CHECK_THAT(refused(with("element face 12", "element face 0")), Contains("holds no faces"));
    CHECK_THAT(refused(with("end_header", "comment " + std::string(70'000, 'a') + "\nend_header")), Contains("64 KiB"));
    CHECK_THAT(refused(ply_of(shapes::box({0, 0, 0}, {5, 5, 5}), {.encoding = "ascii"})), Contains("is a text PLY file"));
    const auto path = dir.write("a.ply", with("end_header", "comment SPACE=RAS\nend_header") + "rest");
    const MeshStream file = value_of(open_mesh(path));
    const MeshFile read = value_of(read_mesh(path));
    CHECK(file.about().warnings == read.warnings);
    CHECK(file.about().patient_frame == read.patient_frame);
    CHECK(file.about().triangle_count == read.triangle_count);
    CHECK(file.about().vertex_count == read.vertex_count);
}
