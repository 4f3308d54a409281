// Binary PLY sliced in ranges gives what slice() gives of the whole mesh.
#include <cmath>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/counting_memory.hpp"
#include "engine/shapes.hpp"
#include "input/ply_writer.hpp"
#include "input/slices_in_ranges.hpp"
#include "lamella/io.hpp"
#include "lamella/lamella.hpp"
#include "models/models.hpp"
#include "temp_folder.hpp"

namespace {

using lamella::FileSliceOptions;
using lamella::SliceOptions;
using lamella::input_test::budget_heights_mm;
using lamella::input_test::layers_of;
using lamella::input_test::least_budget;
using lamella::input_test::require_same_at_all_budgets;

/// How a PLY file is written.
struct PlyForm {
    std::string encoding = "binary_little_endian";
    std::string number = "float";
    std::string index = "int";
    bool more = false;  ///< other elements, and other properties before and after those that are read
};

std::string ply_of(const shapes::Soup& soup, const PlyForm& form) {
    const shapes::Indexed mesh = shapes::indexed(soup);
    lamella::ply_test::PlyWriter ply(form.encoding);
    const std::string more = form.more ? "property short more" : "comment no more";
    ply.header(form.more ? "element first 2\nproperty double d" : "comment none");
    ply.header("element vertex " + std::to_string(mesh.xyz.size() / 3)).header(more);
    for (const char* axis : {" x", " y", " z"}) {
        ply.header("property " + form.number + axis);
    }
    ply.header("element face " + std::to_string(mesh.indices.size() / 3)).header(more);
    ply.header("property list uchar " + form.index + " vertex_indices\n" + (form.more ? "property uchar red" : "comment"));
    for (int i = 0; form.more && i < 2; ++i) {
        ply.number("double", std::nan(""));
    }
    const auto add = [&](const char* type) { form.more ? void(ply.number(type, 7)) : void(); };
    for (std::size_t v = 0; v < mesh.xyz.size(); v += 3) {
        add("short");
        ply.number(form.number, mesh.xyz[v]).number(form.number, mesh.xyz[v + 1]).number(form.number, mesh.xyz[v + 2]);
    }
    for (std::size_t t = 0; t < mesh.indices.size(); t += 3) {
        add("short");
        ply.number("uchar", 3);
        for (std::size_t corner = 0; corner < 3; ++corner) {
            ply.number(form.index, mesh.indices[t + corner]);
        }
        add("uchar");
    }
    return ply.file();
}

shapes::Soup soup_of(lamella::models::Shape shape, lamella::models::Order order, std::uint64_t triangles) {
    const std::vector<float> soup = lamella::models::make_soup({.shape = shape, .triangles = triangles, .order = order});
    return {soup.begin(), soup.end()};
}

}  // namespace

TEST_CASE("binary PLY gives the same layers in ranges", "[slice_file][threads]") {
    using enum lamella::models::Shape;
    using enum lamella::models::Order;
    const TempFolder folder;
#ifdef LAMELLA_TESTS_SANITIZED
    const PlyForm form{.encoding = "binary_big_endian", .number = "double", .index = "uint", .more = true};
#else
    const auto form = GENERATE(PlyForm{}, PlyForm{.encoding = "binary_big_endian", .number = "double", .index = "uint"},
                               PlyForm{.number = "double", .more = true},
                               PlyForm{.encoding = "binary_big_endian", .index = "uint", .more = true});
#endif
    shapes::Soup soup;
    SliceOptions options = layers_of(0.6);
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
        options.transform = lamella::Transform::from_normal(1, 2, 3);
        options.unit_mm = 0.001;
    }
    require_same_at_all_budgets(folder.write("mesh.ply", ply_of(soup, form)), options);
}

TEST_CASE("vertices count against the budget", "[slice_file]") {
    const TempFolder folder;
    const auto order = GENERATE(lamella::models::Order::z, lamella::models::Order::random);
    const auto* const number = GENERATE("float", "double");
    const auto soup = soup_of(lamella::models::Shape::bone, order, 100'000);
    const auto path = folder.write("mesh.ply", ply_of(soup, {.number = number}));
    for (const double height : budget_heights_mm) {
        for (const int threads : {1, 2}) {
            CountingMemory memory;
            FileSliceOptions options;
            options.slice = layers_of(height);
            options.slice.control = {.threads = threads};
            options.memory_bytes = least_budget(path, options);
            options.slice.control.memory = &memory;
            INFO(options.memory_bytes << " bytes, " << threads << " threads");
            const auto take = [](const lamella::LayerView&) noexcept {};
            CHECK(lamella::slice_file(path, lamella::LayerSink::to(take, lamella::SinkOrder::ascending), options).ok());
            CHECK(memory.peak() <= options.memory_bytes);
        }
    }
    FileSliceOptions options;
    options.memory_bytes = 10'000;
    const auto refused = lamella::slice_file(path, options);
    REQUIRE(!refused);
    CHECK(refused.error().message.find("vertices stay in memory, which takes at least") != std::string::npos);
}

TEST_CASE("a damaged PLY is refused as in memory", "[slice_file]") {
    const TempFolder folder;
    const PlyForm form = GENERATE(PlyForm{}, PlyForm{.encoding = "binary_big_endian", .number = "double", .more = true});
    const std::string good = ply_of(shapes::octasphere({0, 0, 10}, 10, 5), form);
    const std::size_t row = form.more ? 16 : 13;
    const std::size_t begin = form.more ? 2 : 0;
    const std::size_t face = good.size() - (8192 - 5000) * row + begin;  // of one in the middle
    const auto refusal_of = [&](const std::string& bytes) {
        const auto refused = lamella::slice_file(folder.write("a.ply", bytes));
        REQUIRE(!refused);
        return refused.error().message;
    };
    const auto require_as_in_memory = [&](const std::string& bytes) {
        const std::string message = refusal_of(bytes);
        const auto read = lamella::read_mesh(folder / "a.ply");
        CHECK(message == (read ? lamella::slice(*read).error().message : read.error().message));
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
    CHECK(refusal_of(bad).find("face 5000 has 4 corners: only triangles") != std::string::npos);
    bad[face] = 2;
    CHECK(refusal_of(bad.substr(0, bad.size() - 1)).find("face 5000 has 2 corners: only triangles") != std::string::npos);
    bad = good;
    bad.replace(good.size() - 8192 * row - 8, 8, std::string(8, '\xff'));  // of the last vertex
    const std::string message = refusal_of(bad);
    CHECK(message.find("is not finite") != std::string::npos);
    CHECK(message.find(lamella::slice(*lamella::read_mesh(folder / "a.ply")).error().message) != std::string::npos);
}

TEST_CASE("a PLY that cannot be read in pieces is refused by name", "[slice_file]") {
    const TempFolder folder;
    const auto refusal_of = [&](const std::string& bytes) {
        const auto refused = lamella::slice_file(folder.write("a.ply", bytes));
        REQUIRE(!refused);
        return refused.error().message;
    };
    const std::string good = ply_of(shapes::box({0, 0, 0}, {5, 5, 5}), {});
    const auto with = [&](const std::string& from, const std::string& to) {
        return std::string(good).replace(good.find(from), from.size(), to);
    };
    CHECK(refusal_of(with("uchar int", "uchar float")).find("'face' has other lists") != std::string::npos);
    CHECK(refusal_of(with("element face", "element tristrips")).find("'tristrips' has other lists") != std::string::npos);
    CHECK(refusal_of(with("element face 12", "element face 0")).find("holds no faces") != std::string::npos);
    CHECK(refusal_of(with("comment none", "comment " + std::string(70'000, 'a'))).find("64 KiB") != std::string::npos);
    CHECK(refusal_of(ply_of(shapes::box({0, 0, 0}, {5, 5, 5}), {.encoding = "ascii"})).find("is a text PLY file") !=
          std::string::npos);
    const auto said = lamella::describe_file(folder.write("a.ply", with("comment none", "comment SPACE=RAS") + "rest"));
    REQUIRE(said);
    const auto read = lamella::read_mesh(folder / "a.ply");
    REQUIRE(read);
    CHECK(said->warnings == read->warnings);
    CHECK(said->patient_frame == read->patient_frame);
    CHECK(said->triangle_count == read->triangle_count);
    CHECK(said->vertex_count == read->vertex_count);
}
