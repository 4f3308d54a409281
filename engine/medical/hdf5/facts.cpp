#include "medical/hdf5/facts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <string_view>
#include <utility>

#include "base/guard.hpp"
#include "lamella/io/name_text.hpp"
#include "medical/geometry/directions.hpp"

namespace lamella {

namespace {

/// Names of an enumeration, in its order.
using Names = std::span<const std::string_view>;

constexpr std::array<std::string_view, 3> frames = {"", "LPS", "RAS"};
constexpr std::array<std::string_view, 2> arithmetics = {"double", "as mesh"};
constexpr std::array<std::string_view, 3> spacings = {"uniform", "explicit", "random"};
constexpr std::array<std::string_view, 2> datums = {"mesh-min", "zero"};
constexpr std::array<std::string_view, 2> sides = {"below", "above"};
constexpr std::array<std::string_view, 5> rules = {"contours", "even-odd", "non-zero", "positive", "outermost"};
constexpr std::array<std::string_view, 2> part_regions = {"separate", "united"};
constexpr std::array<std::string_view, 2> senses = {"kept", "any"};

constexpr std::uint64_t most = std::numeric_limits<std::uint64_t>::max();

/// Writes down what visit() shows it.
class FactWriter {
public:
    static constexpr bool reads = false;

    void begin(const char* group) { group_ = group; }
    void text(const char* name, const std::string& value) { facts_.push_back({group_, name, value}); }
    void file_name(const char* name, const std::string& value) { text(name, text_of_name(value)); }
    void numbers(const char* name, std::span<const double> values) {
        facts_.push_back({group_, name, std::vector<double>(values.begin(), values.end())});
    }
    template <class Whole>
    void whole(const char* name, const Whole& value, std::uint64_t, std::uint64_t) {
        facts_.push_back({group_, name, std::vector<std::uint64_t>{static_cast<std::uint64_t>(value)}});
    }
    template <class Enum>
    void choice(const char* name, const Enum& value, Names names) {
        text(name, std::string(names[static_cast<std::size_t>(value)]));
    }
    template <class T>
    bool optional(const char*, const std::optional<T>& value) {
        return value.has_value();
    }
    void kind_of_planes(const LayerPlan& plan) { choice("spacing", plan.spacing.index(), spacings); }

    std::vector<Fact> take() && { return std::move(facts_); }

private:
    std::string group_;
    std::vector<Fact> facts_;
};

/// Reads and checks what visit() shows it.
class FactTaker {
public:
    static constexpr bool reads = true;

    explicit FactTaker(FactReader& reader) : reader_(reader) {}

    void begin(const char* group) { group_ = group; }
    void text(const char* name, std::string& value) { value = std::get<std::string>(read(name, std::string(), 1)); }
    void file_name(const char* name, std::string& value) {
        text(name, value);
        value = name_of_text(value);
    }
    void numbers(const char* name, std::span<double> values) {
        const FactValue read_values = read(name, std::vector<double>(), values.size());
        const auto& found = std::get<std::vector<double>>(read_values);
        if (!std::all_of(found.begin(), found.end(), [](double value) { return std::isfinite(value); })) {
            reader_.refuse(group_, name);
        }
        std::copy(found.begin(), found.end(), values.begin());
    }
    template <class Whole>
    void whole(const char* name, Whole& value, std::uint64_t least, std::uint64_t largest) {
        const std::uint64_t found =
            std::get<std::vector<std::uint64_t>>(read(name, std::vector<std::uint64_t>(), 1)).front();
        if (found < least || found > largest) {
            reader_.refuse(group_, name);
        }
        value = static_cast<Whole>(found);
    }
    template <class Enum>
    void choice(const char* name, Enum& value, Names names) {
        std::string found;
        text(name, found);
        const auto place = std::find(names.begin(), names.end(), found);
        if (place == names.end()) {
            reader_.refuse(group_, name);
        }
        value = static_cast<Enum>(place - names.begin());
    }
    /// By the name of one of its members.
    template <class T>
    bool optional(const char* name, std::optional<T>& value) {
        if (reader_.has(group_, name)) {
            value.emplace();
        }
        return value.has_value();
    }
    void kind_of_planes(LayerPlan& plan) {
        std::size_t kind = 0;
        choice("spacing", kind, spacings);
        if (kind == 1) {
            plan.spacing = ExplicitPlanes{};
        } else if (kind == 2) {
            plan.spacing = RandomLayers{};
        }
    }
    void require(bool holds, const char* name) {
        if (!holds) {
            reader_.refuse(group_, name);
        }
    }

private:
    FactValue read(const char* name, FactValue value, std::size_t count) {
        reader_.read(group_, name, count, value);
        return value;
    }

    FactReader& reader_;
    std::string group_;
};

template <class Visitor, class Double>
void visit_number(Visitor& visitor, const char* name, Double& value) {
    visitor.numbers(name, std::span<Double>(&value, 1));
}

template <class Visitor, class Result, class Info>
void visit_mesh(Visitor& visitor, Result& result, Info& info) {
    visitor.begin("/mesh");
    visitor.file_name("name", info.name);
    visitor.text("sha256", info.mesh_sha256);
    visitor.choice("patient_frame", info.frame, frames);
    visitor.numbers("to_layers", result.frame.m);
    visitor.choice("arithmetic", result.frame.arithmetic, arithmetics);
    visitor.whole("triangles", result.summary.triangles, 0, most);
    visitor.whole("degenerate", result.summary.degenerate, 0, most);
    visitor.numbers("min_mm", result.summary.min_mm);
    visitor.numbers("max_mm", result.summary.max_mm);
    visitor.whole("meshes", result.part_count, 1, several_parts - 1);
    if (visitor.optional("weld_tolerance_mm", info.weld)) {
        visit_number(visitor, "weld_tolerance_mm", info.weld->tolerance_mm);
        visitor.whole("weld_joined", info.weld->joined, 0, most);
    }
}

template <class Visitor, class Plan>
void visit_plan(Visitor& visitor, Plan& plan) {
    visitor.begin("/plan");
    visitor.kind_of_planes(plan);
    visitor.choice("side", plan.side, sides);
    if (auto* const uniform = std::get_if<UniformLayers>(&plan.spacing)) {
        visit_number(visitor, "layer_height_mm", uniform->layer_height_mm);
        visitor.choice("datum", uniform->datum, datums);
        if (visitor.optional("first_height_mm", uniform->first_height_mm)) {
            visit_number(visitor, "first_height_mm", *uniform->first_height_mm);
        }
    } else if (auto* const random = std::get_if<RandomLayers>(&plan.spacing)) {
        visit_number(visitor, "min_height_mm", random->min_height_mm);
        visit_number(visitor, "max_height_mm", random->max_height_mm);
        visitor.whole("seed", random->seed, 0, most);
    }
}

template <class Visitor, class Result>
void visit_region(Visitor& visitor, Result& result) {
    auto& region = result.region;
    visitor.begin("/region");
    visitor.choice("fill_rule", region.fill_rule, rules);
    visitor.whole("largest_only", region.largest_only, 0, 1);
    visit_number(visitor, "close_mm", region.close_mm);
    visit_number(visitor, "offset_mm", region.offset_mm);
    visit_number(visitor, "miter_limit", region.miter_limit);
    visit_number(visitor, "mark_near_mm", region.mark_near_mm);
    visitor.whole("drop_collinear", region.drop_collinear, 0, 1);
    visit_number(visitor, "simplify_mm", region.simplify_mm);
    visitor.choice("parts", result.part_regions, part_regions);
    visit_number(visitor, "close_gaps_mm", result.close_gaps_mm);
    visitor.choice("gap_sense", result.gap_sense, senses);
}

template <class Visitor, class Info>
void visit_image(Visitor& visitor, Info& info) {
    visitor.begin("/image");
    if (!visitor.optional("origin_mm", info.geometry)) {
        return;
    }
    auto& image = *info.geometry;
    static constexpr std::array<const char*, 3> size_names = {"size_i", "size_j", "size_k"};
    static constexpr std::array<const char*, 3> axis_names = {"axis_i", "axis_j", "axis_k"};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        visitor.whole(size_names[axis], image.size[axis], 1, largest_image_side);
        visitor.numbers(axis_names[axis], image.axes[axis]);
        if constexpr (Visitor::reads) {
            visitor.require(std::abs(length(image.axes[axis]) - 1) < 1e-3, axis_names[axis]);
        }
    }
    visitor.numbers("origin_mm", image.origin_mm);
    visitor.numbers("spacing_mm", image.spacing_mm);
    if constexpr (Visitor::reads) {
        const auto& sides = image.spacing_mm;
        visitor.require(std::all_of(sides.begin(), sides.end(), [](double side) { return side > 0; }), "spacing_mm");
    }
    visitor.whole("subslices", info.subslices, 1, 1000);
    std::uint64_t uneven = image.uneven_slices_mm.size();
    visitor.whole("uneven_slices", uneven, 0, most_uneven_slices);
    if (uneven > 0) {
        if constexpr (Visitor::reads) {
            visitor.require(uneven == image.size[2], "uneven_slices");
            image.uneven_slices_mm.resize(uneven);
        }
        visitor.numbers("uneven_slices_mm", std::span(image.uneven_slices_mm));
    }
}

template <class Visitor, class Result, class Info>
void visit(Visitor& visitor, Result& result, Info& info) {
    visitor.begin("/");
    visit_number(visitor, "unit_mm", result.unit_mm);
    if constexpr (Visitor::reads) {
        visitor.require(result.unit_mm > 0, "unit_mm");
    }
    visitor.whole("unit_doublings", result.summary.unit_doublings, 0, 1000);

    visit_mesh(visitor, result, info);
    visit_plan(visitor, result.plan);
    visit_region(visitor, result);
    visit_image(visitor, info);
    visitor.begin("/");
    visitor.whole("all_layers", result.all_layers, 0, most);  // last: where plans differ, that is what is said
}

}  // namespace

std::vector<Fact> facts_of(const SliceResult& result, const ArchiveInfo& info) {
    FactWriter writer;
    visit(writer, result, info);
    return std::move(writer).take();
}

void read_facts(FactReader& reader, SliceResult& result, ArchiveInfo& info) {
    FactTaker taker(reader);
    visit(taker, result, info);
}

}  // namespace lamella
