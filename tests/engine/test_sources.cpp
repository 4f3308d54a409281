// A question has one answer, byte for byte: whatever the source, the destination, the threads, bands and form, the order of
// triangles, and which layers are cut. And what is refused is refused in the same words.
#include <initializer_list>
#include <iterator>
#include <limits>

#include <catch2/catch.hpp>

#include "engine/everywhere.hpp"
#include "golden/golden.hpp"

using namespace lamella;
using shapes::octasphere;

namespace {

#ifdef LAMELLA_TESTS_SANITIZED
constexpr double region_layer_mm = 5;
#else
constexpr double region_layer_mm = 2.5;
#endif

struct Question {
    std::string name;
    shapes::Soup mesh;
    SliceOptions options;
    bool changes = false;  ///< regions and stitches, as asked for, change the answer
};

/// By name, each option that changes the way through the engine at least once.
std::map<std::string, SliceOptions> asked_of(const shapes::Soup& mesh) {
    std::map<std::string, SliceOptions> asked = shape_cases::plans(mesh);
    asked["stitched"] = {.layer_height_mm = 0.25, .stitch_mm = 0.5};
    asked["heights in any order"] = {.heights_mm = {{4, -1, 0.5, 4, 30, 2, 5e8}}};
    asked["origins of some layers, turned and above"] = {
        .layer_height_mm = 0.5,
        .origins = true,
        .planes = {.side = PlaneSide::above, .first_layer = 3, .end_layer = 12},
        .frame = {.transform = Transform::from_normal(1, 2, 3), .grid_mm = 0x1p-18}};
    asked["regions"] = {.layer_height_mm = region_layer_mm,
                        .region = {.fill_rule = FillRule::non_zero,
                                   .offset_mm = -0.4,
                                   .flag_closing_mm = 0.1,
                                   .largest_only = true,
                                   .fill_from = {{2, FillRule::even_odd}}}};
    asked["simplified"] = {.layer_height_mm = region_layer_mm,
                           .origins = true,
                           .region = {.fill_rule = FillRule::non_zero, .simplify_mm = 0.05}};
    asked["upward faces"] = {.layer_height_mm = region_layer_mm, .content = LayerContent::upward_faces};
    asked["downward faces"] = {.layer_height_mm = region_layer_mm, .content = LayerContent::downward_faces};
    return asked;
}

std::vector<Question> questions() {
    std::vector<Question> all;
    const std::map<std::string, shapes::Soup> meshes = shape_cases::meshes();
    for (const auto& [name, mesh] : meshes) {
        for (const auto& [option, options] : asked_of(mesh)) {
            all.push_back({name + ", " + option, mesh, options});
        }
    }
    const shapes::Soup bodies = shapes::joined({octasphere({0, 0, 0}, 10, 3), octasphere({12, 3, 1}, 7, 2),
                                                shapes::flipped(octasphere({1, 0, 0}, 4, 2)),
                                                shapes::box({19.05, -3, -8}, {25, 3, 8}), octasphere({30, 0, 0}, 4.95, 3)});
    constexpr FillRule united = FillRule::non_zero;
    for (const RegionRules& rules : std::initializer_list<RegionRules>{
             {.fill_rule = FillRule::outermost},
             {.fill_rule = united, .largest_only = true},
             {.fill_rule = united, .drop_collinear = true},
             {.fill_rule = united, .closing_mm = 0.3},
             {.fill_rule = united, .closing_mm = 0.3, .offset_mm = -0.4, .miter_limit = 1.2},
             {.fill_rule = united, .flag_closing_mm = 0.3},
             {.fill_rule = united,
             .fill_from = {{5, FillRule::outermost}, {20, FillRule::even_odd}, {33, FillRule::contours}}}}) {
        all.push_back({"bodies", bodies, {.layer_height_mm = 0.5, .region = rules}, true});
    }
    for (const FillRule rule : {FillRule::even_odd, united, FillRule::positive}) {
        all.push_back({"filled", meshes.at("tetrahedra"), {.layer_height_mm = 0.1, .region = {.fill_rule = rule}}, true});
    }
    const shapes::Soup ball = octasphere({0, 0, 0}, 5, 1);
    const shapes::Soup tangle = shapes::random_tetrahedra(3, 6, 4);
    for (const shapes::Soup& repeated : {shapes::joined({ball, ball}), shapes::joined({ball, ball, ball}),
                                         shapes::joined({ball, shapes::flipped(ball), ball}),
                                         shapes::joined({tangle, tangle, shapes::flipped(tangle), tangle})}) {
        all.push_back({"repeated triangles", repeated, uniform(0.25)});
    }
    all.push_back({"torn", meshes.at("torn ball"), {.layer_height_mm = 0.05, .stitch_mm = 1}, true});
    all.push_back({"gaps in any direction",
                   meshes.at("tangle"),
                   {.layer_height_mm = 0.05, .stitch_mm = 1, .stitch_direction = StitchDirection::any},
                   true});
    return all;
}

/// A mesh as every source that can be made of it in memory, as floats where asked for.
class EverySource {
public:
    EverySource(const shapes::Soup& soup, const Frame& frame, bool as_floats = false)
        : soup_(soup, as_floats ? Form::f32_soup : Form::f64_soup),
          shuffled_(shapes::shuffled(soup, 5), as_floats ? Form::f32_soup : Form::f64_soup),
          indexed_(soup, as_floats ? Form::f32_indexed : Form::f64_indexed),
          prepared_(value_of(prepare(mesh(), frame))),
          part_{{.mesh = mesh()}} {}

    MeshView mesh() const { return soup_.view(); }
    /// Those that may be asked so: faces are those of a mesh, and origins depend on the order of triangles.
    std::vector<std::pair<std::string, Source>> all(const SliceOptions& options) const {
        std::vector<std::pair<std::string, Source>> sources = {{"soup", mesh()}, {"indexed", indexed_.view()}};
        if (options.content == LayerContent::section) {
            sources.insert(sources.end(), {{"prepared", prepared_}, {"part", part_}});
        }
        if (!options.origins) {
            sources.emplace_back("shuffled", shuffled_.view());
        }
        return sources;
    }

private:
    using Form = golden::Form;
    golden::HeldMesh soup_;
    golden::HeldMesh shuffled_;
    golden::HeldMesh indexed_;
    PreparedMesh prepared_;
    std::vector<Part> part_;
};

/// An outline says, and a sink is told before its first layer, all but the counts of contours.
void require_known_before(const SliceInfo& expected, const Source& source, const SliceOptions& options) {
    SliceInfo told;
    std::uint64_t layers = 0;
    const auto begin = [&](const SliceInfo& info) noexcept { told = layers == 0 ? info : SliceInfo{}; };
    const auto take = [&](const LayerView& /*layer*/) noexcept { ++layers; };
    sliced_to(LayerSink{.take = take, .begin = begin}, source, options);
    for (const SliceInfo& info : {value_of(Slicer().outline(source, options)), told}) {
        const bool adds_points = options.region.fill_rule != FillRule::contours || options.content != LayerContent::section;
        CHECK((adds_points || info.segments >= expected.contours));
        CHECK((adds_points || (expected.open_contours > 0 ? 2 : 1) * info.segments >= expected.points));
        CHECK(info.layers == expected.layers);
        CHECK(info.first_layer == expected.first_layer);
        CHECK(info.planned_layers == expected.planned_layers);
        CHECK(info.segments == expected.segments);
        CHECK(info.triangles == expected.triangles);
        CHECK(info.box == expected.box);
        CHECK(info.grid_mm == expected.grid_mm);
        SliceOptions asked = info.options;
        asked.frame.grid_mm = expected.options.frame.grid_mm;  // a prepared mesh's frame holds the grid that was chosen
        CHECK(asked == expected.options);
        CHECK(info.layer_of == expected.layer_of);
    }
}

/// Slices to every destination fail with the same error.
void require_refused_alike(const Source& source, const SliceOptions& options, const Context& context,
                           const Error& expected) {
    SliceResult result;
    GuardedArrays host({1000, 1000, 1000});
    const auto nothing = [](const LayerView&) noexcept {};
    const LayerSink sinks[] = {{.take = nothing}, {.take = nothing, .order = SinkOrder::any}};
    for (const Destination to :
         {Destination(result), Destination(sinks[0]), Destination(sinks[1]), Destination(host.arrays)}) {
        const Error found = error_of(Slicer().slice_to(to, source, options, context));
        CHECK(found.code == expected.code);
        CHECK(found.message == expected.message);
        CHECK(found.triangle == expected.triangle);
        CHECK(found.plane == expected.plane);
    }
}

const PointForm forms[] = {
    {Number::i32, 0, 1, 0},       {Number::i32, 8, 1, 3},         {Number::i32, 12, 1, 0},
    {Number::i32, 0, 3, 0},       {Number::i64, 0, 1, 0},         {Number::i64, 24, 4294967296.0, 1},
    {Number::i64, 17, 1000, 0},   {Number::f32, 0, 0x1p-20, 0},   {Number::f32, 12, 1.0 / 3, 2},
    {Number::f64, 0, 0x1p-20, 0}, {Number::f64, 40, 1e-6 / 7, 5},
};

static_assert(std::forward_iterator<Islands::Iterator> && std::forward_iterator<SliceResult::Iterator>);

/// The islands hold every outer and every hole once.
void check_islands(const SliceResult& result) {
    std::size_t held = 0;
    for (const LayerView layer : result) {
        for (const Island island : layer.islands()) {
            held += 1 + island.holes.size();
            for (const Contour& hole : island.holes) {  // in its outer, or in a hole of it
                const Contour* const around = layer.parent_of(hole);
                REQUIRE((around == island.outer || around->role == Role::hole));
            }
        }
    }
    CHECK(held + result.info.open_contours + result.info.flat_contours == result.contours.size());
}

/// The next of some ranges of layers has the bytes that it has in the whole.
void require_layers_alone(const SliceResult& whole, const Source& source, SliceOptions options, const Way& way,
                          std::size_t next) {
    const std::size_t k = whole.size();
    const std::size_t first = k < 2 ? 0 : next * 7 % k;
    const std::size_t counts[] = {1, 2, k / 3 + 1, k};
    const std::size_t end = std::min(k, first + counts[next % 4]);
    options.planes.first_layer = whole.info.first_layer + first;
    options.planes.end_layer = whole.info.first_layer + (whole.info.planned_layers == k ? first + counts[next % 4] : end);
    INFO("layers " << first << " to " << end << " of " << k);
    const SliceResult part = sliced(source, options, way.context, way.tuning);
    REQUIRE(part.size() == end - first);
    for (std::size_t layer = first; layer < end; ++layer) {
        REQUIRE(is_same(part[layer - first], whole[layer]));
    }
    CHECK(part.info.first_layer == options.planes.first_layer);
    CHECK(part.info.planned_layers == whole.info.planned_layers);
    CHECK(part.info.layer_of == whole.info.layer_of);
    ComparedLayers compared(whole, first);
    sliced_to(LayerSink{.take = compared}, source, options, way.context, way.tuning);
    compared.require_all(end - first);
}

TEST_CASE("a question has one answer, whatever is sliced, to where, by how many threads, and which of its layers",
          "[engine][determinism][sources][sink][host][prepare][layers][slicer][threads]") {
    const std::vector<Way> all_ways = ways();
    const shapes::Soup broken(18, 1e300);
    Slicer kept;  // from question to question, and after refused ones
    SliceResult again;
    std::size_t first_way = 0;  // of the question
    std::size_t turn = 0;
    unsigned number = 0;
    for (const auto& [name, mesh, options, changes] : questions()) {
        if (!tried(number++)) {
            continue;
        }
        const EverySource every(mesh, options.frame, turn % 3 == 2);
        const SliceResult expected = sliced(every.mesh(), options, {.threads = 1});
        check_islands(expected);
        if (changes) {
            SliceOptions plain = options;
            plain.region = {};
            plain.stitch_mm = 0;
            CHECK(sliced(every.mesh(), plain).hash() != expected.hash());
        }
        const auto sources = every.all(options);
        for (std::size_t w = first_way++ % 7; w < all_ways.size(); w += 7, ++turn) {
            const Way& way = all_ways[w];
            const auto& [source_name, source] = sources[turn / 3 % sources.size()];
            INFO(name << " as " << source_name << ", " << way);
            if (turn % 3 == 0) {
                require_at_every_destination(expected, source, options, way, forms[turn / 3 % std::size(forms)]);
                require_known_before(expected.info, source, options);
            } else if (turn % 3 == 1 && !expected.layers.empty()) {
                require_layers_alone(expected, source, options, way, turn);
            } else {
                value_of(slice_tuned(kept, again, source, options, way.tuning, way.context));
                require_same(again, expected);
                CHECK_FALSE(kept.slice_to(again, view_of(broken), options).ok());
                if (turn % 2 == 0) {
                    kept.trim();
                }
            }
        }
    }
}

TEST_CASE("every destination gets planes that all threads work on together, or that fall back to a band's sweep",
          "[engine][sources][sink][origins][wide][threads]") {
    constexpr int quarters = 1 << 15;  // eight facets each: 2^18 segments
    SliceOptions options{.heights_mm = {{0.25, 0.5, 0.75}}, .origins = true};
    // The box is cut by the first plane alone, so that the prisms' records are not those with the first numbers.
    const shapes::Soup prisms =
        shapes::joined({shapes::box({0, 0, 0}, {4, 4, 0.3}), shapes::prism(quarters, 400, 1), shapes::prism(1 << 10, 90, 1),
                        shapes::moved(shapes::prism(8, 90, 1), {600, 0, 0})});
    const shapes::Soup open = shapes::without(prisms, 12, 1);  // each band is begun twice
    unsigned number = 0;
    for (const shapes::Soup& mesh : {prisms, open, shapes::joined({prisms, shapes::only(prisms, 12, 1)})}) {
        if (!tried(number++)) {
            continue;
        }
        options.stitch_mm = mesh == open ? 1 : 0;
        const SliceResult expected = sliced(mesh, options, {.threads = 1});
        const std::uint64_t doubled = mesh.size() > prisms.size() ? 1 : 0;  // a facet, which is an open polyline
        CHECK(expected.layers[1].contour_count == 3 + doubled);
        CHECK(expected.info.open_contours == 3 * doubled);
        require_at_every_destination(expected, view_of(mesh), options, {.context = {.threads = 2}});
        // No plane is wide in this form.
        require_same(sliced(mesh, options, {.threads = 2}, {.form = ContourForm::assembled}), expected);
    }
}

TEST_CASE("an empty mesh gives every destination empty layers where asked for", "[engine][sources][empty]") {
    const shapes::Soup collapsed = {0, 0, 0, 0, 0, 0, 0, 0, 10, 5, 5, 0, 5, 5, 10, 5, 5, 10};  // each along a line
    for (const shapes::Soup& mesh : {shapes::Soup{}, collapsed}) {
        const EverySource sources(mesh, {.grid_mm = coarse_unit_mm});
        for (const LayerContent content :
             {LayerContent::section, LayerContent::upward_faces, LayerContent::downward_faces}) {
            SliceOptions options = at_heights({5, 2, 5});
            options.content = content;
            CHECK(failure_of(view_of(mesh), options).code == ErrorCode::empty_mesh);
            options.allow_empty = true;
            const SliceResult given = sliced(mesh, options);
            REQUIRE(given.layers.size() == 2);
            CHECK(given.layers[0].plane_mm == 2);
            CHECK(given.layers[0].contour_count == 0);
            CHECK(given.info.layer_of == std::vector<std::uint64_t>{1, 0, 1});
            CHECK(given.info.triangles == mesh.size() / 9);
            CHECK(given.info.degenerate == mesh.size() / 9);
            for (const auto& [name, source] : sources.all(options)) {
                INFO(name);
                require_at_every_destination(given, source, options);
            }
            options.heights_mm.reset();
            options.layer_height_mm = 3;
            CHECK(sliced(mesh, options).layers.empty());
            options.layer_height_mm = -1;
            CHECK(failure_of(view_of(mesh), options).code == ErrorCode::invalid_argument);
        }
        const Tuning random{.random_heights = RandomHeights{1, 2, 3}};
        CHECK(sliced(view_of(mesh), {.allow_empty = true}, {}, random).layers.empty());
    }
}

TEST_CASE("every destination and content refuses alike, in the same words, and names triangle or plane",
          "[engine][sources][sink][planes][transform][errors]") {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    constexpr double infinity = std::numeric_limits<double>::infinity();
    const shapes::Soup box = shapes::box({0, 0, 0}, {4, 4, 4});
    const std::vector<float> floats = shapes::floats(box);
    const std::vector<float> far = shapes::floats(shapes::box({0, 0, 700}, {1, 1, 700.01}));  // floats are 6e-5 mm apart
    const shapes::Soup point = shapes::triangle({0, 0, 0}, {0.01, 0, 0}, {0, 0.01, 0});
    shapes::Indexed beyond = shapes::indexed(box);
    beyond.indices[7] = 99;
    struct Refusal {
        MeshView mesh;
        SliceOptions options;
        ErrorCode code;
        std::int64_t triangle = -1;
        std::int64_t plane = -1;
        Context context{};
    };
    const auto layers = [](std::uint64_t first, std::uint64_t end) {
        return SliceOptions{.layer_height_mm = 1, .planes = {.first_layer = first, .end_layer = end}};
    };
    const Frame too_large{.transform = Transform::scale(1e39), .as_mesh_numbers = true};
    std::vector<Refusal> refusals = {
        {view_of(box), layers(4, 9), ErrorCode::bad_planes},
        {view_of(box), layers(2, 2), ErrorCode::bad_planes},
        {view_of(box), layers(3, 1), ErrorCode::bad_planes},
        {view_of(box), layers(all_layers, all_layers), ErrorCode::bad_planes},
        {view_of(floats), {.frame = too_large}, ErrorCode::bad_coordinate, 0},
        {MeshView{}, at_heights({1}), ErrorCode::empty_mesh},
        {view_of(point), at_heights({1}), ErrorCode::empty_mesh},
        {beyond.view(), at_heights({1}), ErrorCode::invalid_argument, 2},
        {view_of(box), at_heights({3, 1, nan, 2, -nan}), ErrorCode::bad_planes, -1, 2},
        {view_of(box), at_heights({1, infinity}), ErrorCode::bad_planes, -1, 1},
        {view_of(far), uniform(1e-5), ErrorCode::bad_planes, -1, 1},
        {view_of(box), uniform(0.9, coarse_unit_mm), ErrorCode::bad_planes},
        {view_of(box), uniform(1e-12), ErrorCode::bad_planes},
        {view_of(box), uniform(0), ErrorCode::invalid_argument},
        {view_of(box), uniform(1, 1e-18), ErrorCode::invalid_argument},
        {view_of(box), uniform(1, 1e-9), ErrorCode::bad_coordinate},
        {view_of(box), {.stitch_mm = nan}, ErrorCode::invalid_argument},
        {view_of(box), uniform(0.001), ErrorCode::result_too_large, -1, -1, {.memory_limit_bytes = 1000}},
    };
    std::vector<shapes::Soup> spoiled;
    for (const double bad : {nan, infinity, -infinity, 3e38, -3e38, 1.1e9, 1e300}) {
        for (const std::size_t at : {0U, 31U, 107U}) {
            spoiled.push_back(box);
            spoiled.back()[at] = bad;
            const auto triangle = static_cast<std::int64_t>(at / 9);
            refusals.push_back({view_of(spoiled.back()), uniform(0.1), ErrorCode::bad_coordinate, triangle});
        }
    }
    for (const auto& [mesh, options, code, triangle, plane, context] : refusals) {
        const Error expected = failure_of(mesh, options, context);
        INFO(expected.message);
        CHECK(expected.code == code);
        CHECK((triangle < 0 || expected.triangle == triangle));
        CHECK((plane < 0 || expected.plane == plane));
        for (const LayerContent content :
             {LayerContent::section, LayerContent::upward_faces, LayerContent::downward_faces}) {
            INFO(name_of(content));
            SliceOptions asked = options;
            asked.content = content;
            require_refused_alike(mesh, asked, context, expected);
        }
    }
    CHECK_THAT(failure_of(view_of(far), uniform(1e-5)).message,
               Catch::Contains("planes 0 and 1 (") && Catch::Contains("the same on the grid"));
    CHECK(code_of(Slicer().slice_to(LayerSink{}, view_of(box))) == ErrorCode::invalid_argument);
}

}  // namespace
