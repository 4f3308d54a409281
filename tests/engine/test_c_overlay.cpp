// lamella_overlay_combine(): the bytes of Overlay::combine() for every form of set and rule; what is refused.
#include <cmath>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/c_handles.hpp"
#include "engine/everywhere.hpp"
#include "lamella/overlay.hpp"

using namespace lamella;
using namespace c_handles;

namespace {

constexpr std::int32_t mm = 1 << 20;  // grid units
const std::vector<Point> window = {{0, 0}, {6 * mm, 0}, {6 * mm, 6 * mm}, {0, 6 * mm}};
const lamella_path window_path = {reinterpret_cast<const lamella_point*>(window.data()), window.size()};

/// A ball and a bar through it, as parts 0 and 1: by C, and by C++.
struct BothStacks {
    BothStacks() {
        const std::vector<float> ball = shapes::floats(shapes::octasphere({0, 0, 4}, 4, 3));
        const std::vector<float> bar = shapes::floats(shapes::box({-9, -1, 2}, {9, 2, 7}));
        lamella_mesh meshes[2];
        for (const auto* const soup : {&ball, &bar}) {
            lamella_mesh& mesh = meshes[soup == &bar ? 1 : 0];
            mesh = fresh<lamella_mesh>(LAMELLA_MESH);
            mesh.vertices = soup->data();
            mesh.triangle_count = soup->size() / 9;
        }
        const lamella_part parts[] = {{&meshes[0], {}}, {&meshes[1], {}}};
        auto source = fresh<lamella_source>(LAMELLA_SOURCE);
        source.parts = parts;
        source.part_count = 2;
        auto options = fresh<lamella_options>(LAMELLA_OPTIONS);
        options.layer_height_mm = 0.5;
        options.fill_rule = LAMELLA_FILL_RULE_NON_ZERO;
        lamella_result* result = nullptr;
        const lamella_destination to = into(&result, nullptr, nullptr);
        REQUIRE(lamella_slice_to(nullptr, &to, &source, &options, nullptr, nullptr, nullptr) == LAMELLA_OK);
        c.reset(result);
        const Part in_cpp[] = {{MeshView::soup(ball)}, {MeshView::soup(bar)}};
        cpp = sliced(in_cpp, {.layer_height_mm = 0.5, .region = {.fill_rule = FillRule::non_zero}});
        REQUIRE(cpp.hash() == lamella_result_hash(c.get()));
    }

    lamella_layer_set set(std::int64_t part = -1) const {
        auto it = fresh<lamella_layer_set>(LAMELLA_LAYER_SET);
        it.result = c.get();
        it.part = part;
        return it;
    }

    Owned<lamella_result> c;
    SliceResult cpp;
};

lamella_layer_set window_set() {
    auto it = fresh<lamella_layer_set>(LAMELLA_LAYER_SET);
    it.contours = &window_path;
    it.contour_count = 1;
    return it;
}

}  // namespace

TEST_CASE("sets and rules of every form combine by C to the bytes of C++", "[c][overlay]") {
    const BothStacks both;
    const std::span<const Point> contours[] = {window};
    const ContourSet given{.contours = contours};
    const LayerView fourth = both.cpp[4];
    std::vector<lamella_layer_set> sets = {both.set(0), both.set(1), window_set(), both.set(),
                                           fresh<lamella_layer_set>(LAMELLA_LAYER_SET)};
    sets[1].grow_mm = 0.25;
    sets[1].from = -1;
    sets[1].to = 2;
    sets[2].fill_rule = LAMELLA_FILL_RULE_POSITIVE;
    sets[3].layer = 4;
    const LayerSet expected_sets[] = {
        {.layers = both.cpp, .part = 0},
        {.layers = both.cpp, .from = -1, .to = 2, .grow_mm = 0.25, .part = 1},
        {.layers = given, .fill_rule = FillRule::positive},
        {.layers = fourth},
        {},
    };
    std::vector<std::uint32_t> table(32);
    for (std::uint32_t in = 0; in < 32; ++in) {
        table[in] = in % 7;
    }
    auto from_table = [&table](std::uint64_t in) noexcept { return table[in]; };
    const std::pair<std::function<void(lamella_rule&)>, Rule> cases[] = {
        {[](lamella_rule&) {}, unite},
        {[](lamella_rule& it) { it.any = 1, it.none = ~std::uint64_t{1}; }, subtract},
        {[](lamella_rule& it) { it.all = 15; }, intersect(4)},
        {[](lamella_rule& it) { it.odd = 1; }, exclusive},
        {[](lamella_rule& it) { it.not_all = 3, it.last_wins = 1; }, {.not_all = 3, .last_wins = true}},
        {[&](lamella_rule& it) { it.labels = table.data(), it.label_count = 32; }, {.labels = table}},
        {[&](lamella_rule& it) {
             it.label_object = table.data();
             it.label_of = [](void* self, std::uint64_t in) { return static_cast<std::uint32_t*>(self)[in]; };
         },
         {.label_of = from_table}},
    };
    const Owned<lamella_overlay> overlay(lamella_overlay_create());
    auto after = fresh<lamella_options>(LAMELLA_OPTIONS);
    after.drop_collinear = 1;
    for (const auto& [in_c, rule] : cases) {
        auto asked = fresh<lamella_rule>(LAMELLA_RULE);
        in_c(asked);
        SliceResult expected;
        REQUIRE(Overlay().combine(expected, expected_sets, rule, {.drop_collinear = true}).ok());
        for (lamella_overlay* const kept : {overlay.get(), static_cast<lamella_overlay*>(nullptr)}) {
            lamella_result* made = nullptr;
            const lamella_destination to = into(&made, nullptr, nullptr);
            auto info = fresh<lamella_info>(LAMELLA_INFO);
            REQUIRE(lamella_overlay_combine(kept, &to, sets.data(), sets.size(), &asked, &after, nullptr, &info, nullptr) ==
                    LAMELLA_OK);
            const Owned<lamella_result> result(made);
            CHECK(lamella_result_hash(made) == expected.hash());
            CHECK(info.part_count == expected.info.part_count);
            CHECK(info.contours == expected.contours.size());
        }
    }
    // To a sink, by the union that no rule stands for, and with the program's stop.
    std::uint64_t contours_taken = 0;
    auto sink = fresh<lamella_sink>(LAMELLA_SINK);
    sink.object = &contours_taken;
    sink.take = [](void* self, const lamella_layer_view* layer) {
        *static_cast<std::uint64_t*>(self) += layer->layer.contour_count;
    };
    const lamella_destination to = into(nullptr, &sink, nullptr);
    auto context = fresh<lamella_context>(LAMELLA_CONTEXT);
    SliceResult united;
    REQUIRE(Overlay().combine(united, expected_sets).ok());
    REQUIRE(lamella_overlay_combine(overlay.get(), &to, sets.data(), sets.size(), nullptr, nullptr, &context, nullptr,
                                    nullptr) == LAMELLA_OK);
    CHECK(contours_taken == united.contours.size());
    lamella_overlay_reset(overlay.get());
    context.stop = [](void*) { return std::int32_t{1}; };
    CHECK(lamella_overlay_combine(overlay.get(), &to, sets.data(), sets.size(), nullptr, nullptr, &context, nullptr,
                                  nullptr) == LAMELLA_CANCELLED);
}

TEST_CASE("offsets by C are the bytes of C++, and what they are given wrongly is refused", "[c][offset]") {
    const BothStacks both;
    const lamella_layer_set set = both.set(0);
    const LayerSet expected_set{.layers = both.cpp, .part = 0};
    const lamella_offset_step steps[] = {{-0.5, 0, 0}, {-0.25, 1, 0}, {0.5, 0, 0}};
    const OffsetStep expected_steps[] = {{-0.5}, {-0.25, false}, {0.5}};
    SliceResult expected;
    REQUIRE(Overlay()
                .offset(expected, expected_set, expected_steps, {.join = Join::round, .arc_tolerance_mm = 0.1},
                        {.drop_collinear = true})
                .ok());
    auto offset = fresh<lamella_offset>(LAMELLA_OFFSET);
    offset.join = LAMELLA_JOIN_ROUND;
    offset.arc_tolerance_mm = 0.1;
    auto after = fresh<lamella_options>(LAMELLA_OPTIONS);
    after.drop_collinear = 1;
    lamella_result* made = nullptr;
    const lamella_destination to = into(&made, nullptr, nullptr);
    auto info = fresh<lamella_info>(LAMELLA_INFO);
    auto error = fresh<lamella_error>(LAMELLA_ERROR);
    REQUIRE(lamella_overlay_offset(nullptr, &to, &set, steps, 3, &offset, &after, nullptr, &info, &error) == LAMELLA_OK);
    const Owned<lamella_result> result(made);
    CHECK(lamella_result_hash(made) == expected.hash());
    CHECK(info.part_count == 2);
    made = nullptr;
    const auto message = [&](const lamella_offset_step* given, std::size_t count) {
        CHECK(lamella_overlay_offset(nullptr, &to, &set, given, count, &offset, nullptr, nullptr, nullptr, &error) ==
              LAMELLA_INVALID_ARGUMENT);
        CHECK(made == nullptr);
        return std::string(error.message);
    };
    CHECK(message(nullptr, 2) == "steps is NULL, but its count is not 0");
    CHECK(message(steps, 0) == "an offset has from 1 to 65535 steps, not 0");
    const lamella_offset_step reserved[] = {{1, 0, 1}};
    CHECK(message(reserved, 1) == "step 0: reserved must be 0");
    offset.join = 3;
    CHECK(message(steps, 3) == "join is 3, but the choices are 0 to 2");
    offset.join = 0;
    offset.end = -1;
    CHECK(message(steps, 3) == "end is -1, but the choices are 0 to 3");
}

TEST_CASE("what C gives wrongly to combine is refused by name", "[c][overlay]") {
    const BothStacks both;
    const lamella_path no_points = {nullptr, 3};
    const std::uint32_t labels[] = {1, 1, 0, 0};
    struct Asked {
        std::vector<lamella_layer_set> sets;
        lamella_rule rule = fresh<lamella_rule>(LAMELLA_RULE);
    };
    const std::pair<std::function<void(Asked&)>, std::string> cases[] = {
        {[](Asked& it) { it.sets.clear(); }, "from 1 to 63 sets of layers can be combined, not 0"},
        {[](Asked& it) { it.sets[0].struct_size = 4; }, "struct_size of lamella_layer_set is 4"},
        {[](Asked& it) { it.sets[1].struct_size -= 8; }, "the sets do not begin with one size"},
        {[](Asked& it) { it.sets[1].fill_rule = 9; }, "set 1: fill_rule is 9, but the choices are 0 to 4"},
        {[](Asked& it) { it.sets[0].contours = &window_path; }, "set 0: of result and contours one can be set"},
        {[](Asked& it) { it.sets[0].layer = 16; }, "set 0: the result has no layer 16"},
        {[](Asked& it) { it.sets[0].layer = -2; }, "set 0: the result has no layer -2"},
        {[](Asked& it) { it.sets[1].part = -2; }, "set 1: part is -2, but parts are -1, for all, to 4294967295"},
        {[](Asked& it) { it.sets[1].contours = nullptr; }, "contours is NULL, but its count is not 0"},
        {[&](Asked& it) { it.sets[1].contours = &no_points; }, "points of a contour is NULL, but its count is not 0"},
        {[](Asked& it) { it.sets[1].contour_grid_mm = 1; }, "set 1: its grid unit is 1 mm"},
        {[](Asked& it) { it.sets[1].contour_grid_mm = NAN; }, "set 1: its grid unit is nan mm"},
        {[](Asked& it) { it.rule.reserved = 1; }, "lamella_rule has a field set"},
        {[&](Asked& it) { it.rule.labels = labels; }, "labels is set, but its count is 0"},
        {[](Asked& it) { it.rule.label_count = 4; }, "labels is NULL, but its count is not 0"},
        {[&](Asked& it) { it.rule.labels = labels, it.rule.label_count = 3; }, "a table of labels has 2^n"},
    };
    for (const auto& [spoil, message] : cases) {
        Asked asked{{both.set(), window_set()}};
        spoil(asked);
        lamella_result* result = nullptr;
        const lamella_destination to = into(&result, nullptr, nullptr);
        auto error = fresh<lamella_error>(LAMELLA_ERROR);
        CHECK(lamella_overlay_combine(nullptr, &to, asked.sets.data(), asked.sets.size(), &asked.rule, nullptr, nullptr,
                                      nullptr, &error) == LAMELLA_INVALID_ARGUMENT);
        CHECK(std::string(error.message).substr(0, message.size()) == message);
        CHECK(result == nullptr);
    }
    // A set's result is not the answer's place.
    lamella_result* own = both.c.get();
    const lamella_destination to = into(&own, nullptr, nullptr);
    const lamella_layer_set set = both.set();
    CHECK(lamella_overlay_combine(nullptr, &to, &set, 1, nullptr, nullptr, nullptr, nullptr, nullptr) ==
          LAMELLA_INVALID_ARGUMENT);
    CHECK(lamella_result_hash(own) == both.cpp.hash());
    // Sets of a program that knows no parts, and whose elements are nearer to one another.
    struct alignas(8) Earlier {
        unsigned char bytes[offsetof(lamella_layer_set, part)];
    } earlier[2];
    for (Earlier& it : earlier) {
        lamella_init_sized(&it, LAMELLA_LAYER_SET, sizeof it);
    }
    const lamella_result* const given = both.c.get();
    std::memcpy(earlier[1].bytes + offsetof(lamella_layer_set, result), &given, sizeof given);
    lamella_result* made = nullptr;
    const lamella_destination fresh_place = into(&made, nullptr, nullptr);
    REQUIRE(lamella_overlay_combine(nullptr, &fresh_place, reinterpret_cast<const lamella_layer_set*>(earlier), 2, nullptr,
                                    nullptr, nullptr, nullptr, nullptr) == LAMELLA_OK);
    const Owned<lamella_result> result(made);
    const LayerSet alone[] = {{.layers = both.cpp}};
    SliceResult expected;
    REQUIRE(Overlay().combine(expected, alone).ok());
    CHECK(lamella_result_hash(made) == expected.hash());
}

TEST_CASE("polylines are clipped by C to the bytes of C++", "[c][overlay][clip]") {
    const BothStacks both;
    const std::span<const Point> contours[] = {window};
    const ContourSet given{.contours = contours};
    lamella_layer_set by = both.set(0);
    by.grow_mm = 0.25;
    lamella_layer_set lines = window_set();
    lamella_result* made = nullptr;
    const lamella_destination to = into(&made, nullptr, nullptr);
    auto error = fresh<lamella_error>(LAMELLA_ERROR);
    for (const int keep : {0, int(LAMELLA_CLIP_OUTSIDE), int(LAMELLA_CLIP_BOUNDARY_IS_OUTSIDE)}) {
        SliceResult expected;
        const ClipOptions options{keep != LAMELLA_CLIP_OUTSIDE, keep != LAMELLA_CLIP_BOUNDARY_IS_OUTSIDE};
        REQUIRE(Overlay().clip(expected, given, {.layers = both.cpp, .grow_mm = 0.25, .part = 0}, options).ok());
        REQUIRE(lamella_overlay_clip(nullptr, &to, &lines, &by, keep, nullptr, nullptr, &error) == LAMELLA_OK);
        CHECK(lamella_result_hash(made) == expected.hash());
    }
    const Owned<lamella_result> result(made);
    const auto refused = [&](const lamella_layer_set* polylines, std::int32_t keep) {
        CHECK(lamella_overlay_clip(nullptr, &to, polylines, &by, keep, nullptr, nullptr, &error) ==
              LAMELLA_INVALID_ARGUMENT);
        return std::string(error.message);
    };
    CHECK(refused(&lines, 4) == "keep is 4, but the choices are 0 to 3");
    CHECK(refused(nullptr, 0).find("sets is NULL") == 0);
    CHECK(refused(&by, 0).find("set 0: polylines are clipped as they are") == 0);
    by.layer = 99;
    CHECK(refused(&lines, 0) == "set 1: the result has no layer 99");
}
