#include "slice/slice_arguments.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <system_error>
#include <utility>
#include <variant>

#include "terminal/console.hpp"
#include "terminal/failure.hpp"
#include "terminal/numbers.hpp"

namespace lamella::cli {

namespace {

/// The heading in the help of what neither prints nor pictures need.
constexpr const char* experiments = "Experiments";

UniformLayers uniform_layers(const SliceArguments& arguments) {
    require_positive(arguments.layer_height_mm, "--layer-height");
    if (arguments.first_height_mm && !std::isfinite(*arguments.first_height_mm)) {
        throw Failure(bad_usage, "--first-height: not a finite number of mm");
    }
    UniformLayers layers;
    layers.layer_height_mm = arguments.layer_height_mm.value_or(layers.layer_height_mm);
    layers.first_height_mm = arguments.first_height_mm;
    layers.datum = arguments.datum;
    return layers;
}

RandomLayers random_layers(const SliceArguments& arguments) {
    const std::string& text = arguments.random_heights;
    const std::size_t colon = text.find(':');
    std::optional<double> least;
    std::optional<double> most;
    if (colon != std::string::npos) {
        least = parse_number(std::string_view(text).substr(0, colon));
        most = parse_number(std::string_view(text).substr(colon + 1));
    }
    if (!least || !most || *least <= 0 || *most < *least) {
        throw Failure(bad_usage, "--random-heights: '" + text + "' is not MIN:MAX in mm with 0 < MIN <= MAX");
    }
    return {.min_height_mm = *least, .max_height_mm = *most, .seed = arguments.seed};
}

ExplicitPlanes explicit_planes(const std::string& text) {
    if (std::optional<std::vector<double>> list = parse_list(text)) {
        return {*std::move(list)};
    }
    std::error_code unknown;
    if (text.find(',') != std::string::npos && !std::filesystem::exists(text, unknown)) {
        throw Failure(bad_usage, "--planes: '" + text + "' is neither a list of numbers nor a file");
    }
    NumberFile file = read_numbers(text);
    if (file.values.empty()) {
        throw Failure(bad_input, text + ": no heights");
    }
    return {std::move(file.values)};
}

Transform transform_from_file(const std::string& path) {
    const NumberFile file = read_numbers(path);
    const std::size_t count = file.values.size();
    Transform transform;
    if (count != transform.m.size() && count != 16) {
        throw Failure(bad_input, path + ": " + counted(count, "number") + " where a 3x4 matrix has 12 and a 4x4 one 16");
    }
    if (count == 16 && (file.values[12] != 0 || file.values[13] != 0 || file.values[14] != 0 || file.values[15] != 1)) {
        throw Failure(bad_input, path + ":" + std::to_string(file.lines[12]) + ": the last row is not 0 0 0 1");
    }
    std::copy_n(file.values.begin(), transform.m.size(), transform.m.begin());
    if (transform.is_singular()) {
        throw Failure(bad_input, path + ": the matrix is singular: its determinant is 0, so that it flattens every mesh");
    }
    return transform;
}

Transform transform_of(const SliceArguments& arguments) {
    if (!arguments.transform.empty()) {
        return transform_from_file(arguments.transform);
    }
    if (arguments.normal.empty()) {
        return {};
    }
    const std::vector<double> normal = parse_triple(arguments.normal, "--normal");
    const double length = std::hypot(normal[0], normal[1], normal[2]);
    if (length == 0 || !std::isfinite(length)) {
        throw Failure(bad_usage, "--normal: '" + arguments.normal + "' has no direction");
    }
    return Transform::from_normal(normal[0], normal[1], normal[2]);
}

const std::map<std::string, FillRule>& fill_rules() {
    static const std::map<std::string, FillRule> rules = {{"contours", FillRule::contours},
                                                          {"even-odd", FillRule::even_odd},
                                                          {"non-zero", FillRule::non_zero},
                                                          {"positive", FillRule::positive},
                                                          {"outermost", FillRule::outermost}};
    return rules;
}

FillFrom fill_from(const std::string& text) {
    const std::size_t colon = std::min(text.find(':'), text.size());
    const auto rule = fill_rules().find(text.substr(std::min(colon + 1, text.size())));
    FillFrom from;
    const char* const end = text.data() + colon;
    const auto [stop, error] = std::from_chars(text.data(), end, from.first_layer);
    if (stop != end || error != std::errc() || rule == fill_rules().end()) {
        throw Failure(bad_usage, "--fill-from: '" + text + "' is not LAYER:RULE, such as 12:non-zero");
    }
    from.rule = rule->second;
    return from;
}

RegionRules region_of(const SliceArguments& arguments) {
    RegionRules rules = arguments.region;
    for (const std::string& text : arguments.fill_from) {
        rules.fill_from.push_back(fill_from(text));
    }
    return rules;
}

template <class Enum>
CLI::Option* declare_choice(CLI::App& command, const std::string& flag, Enum& value,
                            const std::map<std::string, Enum>& choices, const std::string& help) {
    std::string names;
    for (const auto& [name, ignored] : choices) {
        names += (names.empty() ? "" : "|") + name;
    }
    const auto store = [flag, names, choices, &value](const std::string& text) {
        const auto found = choices.find(text);
        if (found == choices.end()) {
            throw CLI::ValidationError(flag, "'" + text + "' is not one of " + names);
        }
        value = found->second;
    };
    return command.add_option_function<std::string>(flag, store, help)->type_name(names)->transform(lower_case);
}

void declare_planes(CLI::App& command, SliceArguments& arguments) {
    CLI::Option* const layers =
        command.add_option("--layer-height", arguments.layer_height_mm, "Height of uniform layers (0.2)");
    CLI::Option* const planes =
        command.add_option("--planes", arguments.planes, "Cut at these heights in mm: a file, or a list Z,Z,...");
    CLI::Option* const random =
        command.add_option("--random-heights", arguments.random_heights, "Random steps between MIN and MAX mm");
    CLI::Option* const first = command.add_option("--first-height", arguments.first_height_mm,
                                                  "Height of the first plane above the datum (half a layer)");
    CLI::Option* const datum =
        declare_choice<Datum>(command, "--datum", arguments.datum, {{"mesh-min", Datum::mesh_min}, {"zero", Datum::zero}},
                              "Where heights count from (mesh-min)");
    layers->type_name("MM")->excludes(planes)->excludes(random);
    planes->type_name("FILE|Z,Z,...")->check(given)->excludes(random)->excludes(first)->excludes(datum);
    random->type_name("MIN:MAX")->check(given)->excludes(first)->excludes(datum)->group(experiments);
    first->type_name("MM");
    command.add_option("--seed", arguments.seed, "Seed of the random heights (1)")
        ->type_name("N")
        ->needs(random)
        ->group(experiments);
    declare_choice<PlaneSide>(command, "--side", arguments.side, {{"below", PlaneSide::below}, {"above", PlaneSide::above}},
                              "Where a plane passes a vertex of exactly its height (below)");
}

void declare_region(CLI::App& command, SliceArguments& arguments) {
    RegionRules& rules = arguments.region;
    declare_choice<FillRule>(command, "--fill-rule", rules.fill_rule, fill_rules(),
                             "What is solid where shells overlap (non-zero: they are united)");
    command
        .add_option("--fill-from", arguments.fill_from, "Another fill rule from this layer on, counted from 0; repeatable")
        ->type_name("LAYER:RULE")
        ->transform(lower_case)
        ->take_all()
        ->allow_extra_args(false);
    command.add_option("--close", rules.close_mm, "Close gaps narrower than twice MM between and within contours (off)")
        ->type_name("MM");
    command.add_option("--offset", rules.offset_mm, "Grow what is solid by MM, or shrink it by -MM (off)")->type_name("MM");
    command
        .add_option("--miter-limit", rules.miter_limit,
                    "Cut corners off that --close or --offset would move farther than N times its MM (3)")
        ->type_name("N");
    command.add_flag("--drop-collinear", rules.drop_collinear, "Drop points that lie within straight lines");
    command
        .add_option("--simplify,--tolerance", rules.simplify_mm,
                    "Drop points that lie within MM of the lines left, last of all (off)")
        ->type_name("MM");
    command.add_flag("--largest-only", rules.largest_only, "Keep the largest contour of a layer only, with its holes");
    command
        .add_option("--mark-near", rules.mark_near_mm,
                    "Mark contours that --close MM would change, and change nothing (off)")
        ->type_name("MM");
}

}  // namespace

void declare(CLI::App& command, SliceArguments& arguments) {
    command.add_option("mesh", arguments.meshes, mesh_help("Mesh files, or - for standard input"))
        ->required()
        ->type_name("MESH|-")
        ->check(given_path);
    declare_reading(command, arguments);
    declare_outputs(command, arguments.outputs);
    declare_planes(command, arguments);
    declare_image(command, arguments.image);
    command.add_option("--weld", arguments.weld_mm, "Join vertices at most MM apart before slicing (off)")->type_name("MM");
    command.add_flag("--orient-shells", arguments.orient_shells,
                     "Turn each closed shell outwards, or inwards where it bounds a cavity, before slicing");
    command
        .add_option("--close-gaps", arguments.close_gaps,
                    "Join ends of open polylines at most MM apart; 0: none (auto: a hundredth of the mesh's diagonal)")
        ->type_name("MM|auto")
        ->check(given);
    declare_choice<GapSense>(command, "--gap-sense", arguments.gap_sense, {{"kept", GapSense::kept}, {"any", GapSense::any}},
                             "Which ends --close-gaps joins: any also turns polylines whose facets disagree (kept)");
    declare_region(command, arguments);
    CLI::Option* const normal = command.add_option("--normal", arguments.normal, "Cut perpendicular to this direction");
    CLI::Option* const transform = command.add_option("--transform", arguments.transform,
                                                      "File of a 3x4 matrix, row by row, that is applied to the mesh first");
    normal->type_name("X,Y,Z")->check(given)->excludes(transform);
    transform->type_name("FILE")->check(given_path);
    command.add_option("--band", arguments.band_planes, "Planes swept as one task (0: chosen by the work)")
        ->type_name("N")
        ->check(CLI::Range(0, std::numeric_limits<int>::max()))
        ->group(experiments);
    declare_choice<ContourForm>(command, "--form", arguments.form,
                                {{"swept", ContourForm::swept}, {"assembled", ContourForm::assembled}},
                                "How contours are built (swept); the results are identical")
        ->group(experiments);
    command.add_flag("--map", arguments.map_file, "Map the mesh file into memory instead of reading it");
    CLI::Option* const memory = command.add_option("--memory", arguments.memory,
                                                   "Slice a binary STL or PLY file larger than memory, in ranges of layers "
                                                   "within so many bytes (at least 300k a thread)");
    memory->type_name("BYTES[k|M|G]")->check(given);
    declare_choice<bool>(command, "--split", arguments.split, {{"objects", true}},
                         "Make each 3MF object, OBJ object or group, or STL solid a mesh with its own label, ROI and row");
    for (const char* other : {"--weld", "--orient-shells", "--map", "--split"}) {
        memory->excludes(command.get_option(other));
    }
    command
        .add_option("--layers", arguments.layers,
                    "Cut these layers of the plan only, counted from 0; B is one past the last")
        ->type_name("A:B")
        ->check(given);
    command.add_flag("--hash", arguments.hash, "Print the hash of the result");
    command.add_option("--report", arguments.report, "JSON report to write; - for standard output")
        ->type_name("FILE|-")
        ->check(given_path);
    declare_progress(command, arguments);
    for (const char* image : {"--like", "--spacing"}) {
        for (const char* other :
             {"--layer-height", "--planes", "--random-heights", "--first-height", "--datum", "--normal", "--transform"}) {
            command.get_option(image)->excludes(command.get_option(other));
        }
    }
}

void declare_progress(CLI::App& command, MeshArguments& arguments) {
    declare_choice<ProgressBar::When>(
        command, "--progress", arguments.progress,
        {{"auto", ProgressBar::When::automatic}, {"always", ProgressBar::When::always}, {"never", ProgressBar::When::never}},
        "Progress bar on stderr (auto: on a terminal)");
}

std::optional<double> least_plane_distance(const LayerPlan& plan) {
    if (const auto* uniform = std::get_if<UniformLayers>(&plan.spacing)) {
        return uniform->layer_height_mm;
    }
    if (const auto* random = std::get_if<RandomLayers>(&plan.spacing)) {
        return random->min_height_mm;
    }
    std::optional<double> least;
    std::vector<double> heights = std::get<ExplicitPlanes>(plan.spacing).heights_mm;
    std::sort(heights.begin(), heights.end());
    heights.erase(std::unique(heights.begin(), heights.end()), heights.end());
    for (std::size_t i = 1; i < heights.size(); ++i) {
        least = std::min(least.value_or(heights[i] - heights[i - 1]), heights[i] - heights[i - 1]);
    }
    return least;
}

SliceOptions options_of(const SliceArguments& arguments) {
    SliceOptions options;
    LayerPlan& plan = options.plan;
    if (!arguments.planes.empty()) {
        plan.spacing = explicit_planes(arguments.planes);
    } else if (!arguments.random_heights.empty()) {
        plan.spacing = random_layers(arguments);
    } else {
        plan.spacing = uniform_layers(arguments);
    }
    plan.side = arguments.side;
    if (!arguments.layers.empty()) {
        options.layers = parse_layers(arguments.layers, "--layers");
    }
    options.unit_mm = parse_grid(arguments.grid);
    options.transform = transform_of(arguments);
    if (arguments.weld_mm && !(*arguments.weld_mm >= 0 && std::isfinite(*arguments.weld_mm))) {
        throw Failure(bad_usage, "--weld: not a number of mm that is at least 0");
    }
    options.close_gaps_mm = parse_gaps(arguments.close_gaps);
    options.gap_sense = arguments.gap_sense;
    options.region = region_of(arguments);
    options.control.threads = arguments.threads;
    options.tuning.band_planes = arguments.band_planes;
    options.tuning.form = arguments.form;
    return options;
}

}  // namespace lamella::cli
