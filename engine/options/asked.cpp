#include "options/asked.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/words.hpp"

namespace lamella {

namespace {

/// As a sentence of a report and as a line of a summary, either of which may be empty.
struct RuleWords {
    bool asked;
    std::string sentence;
    std::string line;
};

std::vector<RuleWords> words_of(const RegionRules& rules) {
    const std::string offset = std::string(rules.offset_mm > 0 ? "grown" : "shrunk") + " by " +
                               exact_text(std::abs(rules.offset_mm)) + " mm, miter limit " + exact_text(rules.miter_limit);
    const std::string simplify = exact_text(rules.simplify_mm) + " mm";
    return {{rules.closing_mm > 0, "Regions closed by " + exact_text(rules.closing_mm) + " mm",
             "closed    gaps under " + exact_text(2 * rules.closing_mm) + " mm"},
            {rules.offset_mm != 0, "Regions " + offset, "offset    " + offset},
            {rules.largest_only, "Only the largest contour of each layer, with its holes",
             "kept      the largest contour of each layer, with its holes"},
            {rules.drop_collinear, "Points within straight lines dropped", "dropped   points within straight lines"},
            {rules.simplify_mm > 0, "Contours simplified by at most " + simplify,
             "dropped   points within " + simplify + " of the lines left"},
            {rules.flag_closing_mm > 0,
             "Contours marked that closing by " + exact_text(rules.flag_closing_mm) + " mm would change", ""}};
}

/// "rule non-zero, from layer 12 on contours"
std::string rule_by_layer(const RegionRules& rules) {
    std::string text = "rule " + std::string(name_of(rules.fill_rule));
    for (const FillFrom& from : rules.fill_from) {
        text += ", from layer " + std::to_string(from.first_layer) + " on " + std::string(name_of(from.rule));
    }
    return text;
}

/// ", in slabs of 0.08 to 0.28 mm"; empty where none were given.
std::string describe_slabs(const std::vector<Slab>& slabs) {
    if (slabs.empty()) {
        return {};
    }
    const auto [least, most] = std::minmax_element(slabs.begin(), slabs.end(), [](const Slab& a, const Slab& b) {
        return a.top_mm - a.bottom_mm < b.top_mm - b.bottom_mm;
    });
    const auto height = [](const Slab& slab) { return exact_text(std::round((slab.top_mm - slab.bottom_mm) * 1e6) / 1e6); };
    return ", in slabs of " + height(*least) + " to " + height(*most) + " mm";
}

std::string describe_heights(const SliceOptions& options) {
    const PlaneOptions& planes = options.planes;
    if (options.heights_mm) {
        const std::size_t count = options.heights_mm->size();
        return counted(count, "plane") + " at " + (count == 1 ? "a given absolute height" : "given absolute heights") +
               describe_slabs(options.slabs);
    }
    const std::string from = planes.datum == Datum::mesh_min ? "the mesh's lowest vertex" : "z = 0";
    std::string text = "layers of " + exact_text(options.layer_height_mm) + " mm from " + from + " up (datum " +
                       std::string(name_of(planes.datum)) + "), ";
    if (planes.first_height_mm) {
        return text + "the first plane at " + exact_text(*planes.first_height_mm) + " mm above the datum";
    }
    return text + "the plane in the middle of each";
}

}  // namespace

bool goes_beyond_one_rule(const RegionRules& rules) noexcept {
    return rules != RegionRules{.fill_rule = rules.fill_rule, .miter_limit = rules.miter_limit};
}

void set_layers(SliceOptions& options, std::uint64_t first, std::uint64_t end) noexcept {
    options.planes.first_layer = first;
    options.planes.end_layer = end;
}

bool are_all_layers(const SliceOptions& options) noexcept {
    return options.planes.first_layer == 0 && options.planes.end_layer == all_layers;
}

std::vector<AskedValue> values_of_plan(const SliceOptions& options) {
    std::vector<AskedValue> values = {{"kind", std::string(options.heights_mm ? "explicit" : "uniform")}};
    if (options.heights_mm) {
        values.push_back({"heights", std::uint64_t{options.heights_mm->size()}});
    } else {
        const std::optional<double>& first = options.planes.first_height_mm;
        values.push_back({"layer_height_mm", options.layer_height_mm});
        values.push_back({"first_height_mm", nullptr});
        if (first) {
            values.back().value = *first;
        }
        values.push_back({"datum", std::string(name_of(options.planes.datum))});
    }
    values.push_back({"side", std::string(name_of(options.planes.side))});
    values.push_back({"rule", describe_planes(options)});
    return values;
}

std::vector<AskedValue> values_of_stitching(const SliceOptions& options) {
    return {{"reach_mm", options.stitch_mm}, {"direction", std::string(name_of(options.stitch_direction))}};
}

std::vector<AskedValue> values_of_rules(const RegionRules& rules) {
    std::vector<AskedValue> values = {{"closing_mm", rules.closing_mm},
                                      {"offset_mm", rules.offset_mm},
                                      {"miter_limit", rules.miter_limit},
                                      {"largest_only", rules.largest_only},
                                      {"drop_collinear", rules.drop_collinear}};
    if (rules.simplify_mm > 0) {
        values.push_back({"simplify_mm", rules.simplify_mm});
    }
    values.push_back({"flag_closing_mm", rules.flag_closing_mm});
    return values;
}

std::string describe_planes(const SliceOptions& options) {
    return describe_heights(options) + "; each height rounded as a vertex of that height would be, then one grid unit " +
           side_in_short(options);
}

std::string describe_frame(const Frame& frame) {
    std::string text = "Frame (rows of a 3x4 matrix from mesh to layers):";
    for (const double entry : frame.transform.m) {
        text += " " + exact_text(entry);
    }
    return text;
}

std::string describe_rules(const RegionRules& rules) {
    std::string text = "Fill " + rule_by_layer(rules);
    for (const RuleWords& words : words_of(rules)) {
        text += words.asked ? ". " + words.sentence : "";
    }
    return text;
}

std::string describe_stitching(const SliceOptions& options) {
    return "of at most " + exact_text(options.stitch_mm) + " mm";
}

std::string heights_in_short(const SliceOptions& options) {
    if (options.heights_mm) {
        return "at given heights" + describe_slabs(options.slabs);
    }
    const std::optional<double>& first = options.planes.first_height_mm;
    return exact_text(options.layer_height_mm) + " mm apart, datum " +
           (options.planes.datum == Datum::mesh_min ? "the mesh's lowest vertex" : "zero") + ", the first " +
           (first ? exact_text(*first) + " mm above it" : "half a layer above it");
}

std::string side_in_short(const SliceOptions& options) {
    const PlaneSide side = options.planes.side;
    return std::string(side == PlaneSide::below ? "down" : "up") + " (side " + std::string(name_of(side)) + ")";
}

std::string rules_in_short(const RegionRules& rules, const std::string& flagged) {
    std::string near;
    if (rules.flag_closing_mm > 0) {
        near = "near      " + flagged + " would change if gaps under " + exact_text(2 * rules.flag_closing_mm) +
               " mm were closed\n";
    }
    std::string lines;
    for (const RuleWords& words : words_of(rules)) {
        lines += words.asked && !words.line.empty() ? words.line + "\n" : "";
    }
    return rules.keeps_contours() ? lines + near : near + "filled    by the " + rule_by_layer(rules) + "\n" + lines;
}

}  // namespace lamella
