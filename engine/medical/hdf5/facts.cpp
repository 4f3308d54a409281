#include "medical/hdf5/facts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>

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

/// Visits each fact: writes down what is const, and reads and checks all else.
class FactVisitor {
public:
    /// `attributes`: to be read; none to write facts down.
    explicit FactVisitor(const Attributes* attributes) : attributes_(attributes) {}

    std::vector<Fact> take() && { return std::move(facts_); }

    void begin(const char* group) { group_ = group; }

    template <class Text>
    void text(const char* name, Text& value) {
        if constexpr (std::is_const_v<Text>) {
            facts_.push_back({group_, name, value});
        } else {
            value = attributes_->text(group_, name);
        }
    }

    /// As text_of_name(), since any bytes are a name.
    template <class Text>
    void file_name(const char* name, Text& value) {
        if constexpr (std::is_const_v<Text>) {
            facts_.push_back({group_, name, text_of_name(value)});
        } else {
            value = name_of_text(attributes_->text(group_, name));
        }
    }

    template <class Doubles>
    void numbers(const char* name, Doubles&& doubles) {
        const std::span values(doubles);
        if constexpr (std::is_const_v<typename decltype(values)::element_type>) {
            facts_.push_back({group_, name, std::vector<double>(values.begin(), values.end())});
        } else {
            const std::vector<double> found = attributes_->doubles(group_, name, values.size());
            require(std::all_of(found.begin(), found.end(), [](double value) { return std::isfinite(value); }), name);
            std::copy(found.begin(), found.end(), values.begin());
        }
    }
    template <class Double>
    void number(const char* name, Double& value) {
        numbers(name, std::span(&value, 1));
    }

    template <class Whole>
    void whole(const char* name, Whole& value, std::uint64_t least, std::uint64_t largest) {
        if constexpr (std::is_const_v<Whole>) {
            facts_.push_back({group_, name, std::vector<std::uint64_t>{static_cast<std::uint64_t>(value)}});
        } else {
            const std::uint64_t found = attributes_->whole(group_, name);
            require(found >= least && found <= largest, name);
            value = static_cast<Whole>(found);
        }
    }

    template <class Enum>
    void choice(const char* name, Enum& value, Names names) {
        if constexpr (std::is_const_v<Enum>) {
            facts_.push_back({group_, name, std::string(names[static_cast<std::size_t>(value)])});
        } else {
            const auto place = std::find(names.begin(), names.end(), attributes_->text(group_, name));
            require(place != names.end(), name);
            value = static_cast<Enum>(place - names.begin());
        }
    }

    /// Returns whether there is a value: in a file, by the name of one of its members.
    template <class Optional>
    bool optional(const char* name, Optional& value) {
        if constexpr (!std::is_const_v<Optional>) {
            if (attributes_->has(group_, name)) {
                value.emplace();
            }
        }
        return value.has_value();
    }

    /// For values that were read.
    void require(bool holds, const char* name) const {
        if (attributes_ != nullptr && !holds) {
            attributes_->refuse(group_, name);
        }
    }

private:
    const Attributes* attributes_;
    std::string group_;
    std::vector<Fact> facts_;
};

template <class Owner, class T>
using AsConstAs = std::conditional_t<std::is_const_v<Owner>, const T, T>;

template <class Result, class Info>
void visit_mesh(FactVisitor& visitor, Result& result, Info& info) {
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
        visitor.number("weld_tolerance_mm", info.weld->tolerance_mm);
        visitor.whole("weld_joined", info.weld->joined, 0, most);
    }
}

template <class Plan>
void visit_plan(FactVisitor& visitor, Plan& plan) {
    visitor.begin("/plan");
    AsConstAs<Plan, std::size_t> kind = plan.spacing.index();
    visitor.choice("spacing", kind, spacings);
    if constexpr (!std::is_const_v<Plan>) {
        if (kind == 1) {
            plan.spacing = ExplicitPlanes{};
        } else if (kind == 2) {
            plan.spacing = RandomLayers{};
        }
    }
    visitor.choice("side", plan.side, sides);
    if (auto* const uniform = std::get_if<UniformLayers>(&plan.spacing)) {
        visitor.number("layer_height_mm", uniform->layer_height_mm);
        visitor.choice("datum", uniform->datum, datums);
        if (visitor.optional("first_height_mm", uniform->first_height_mm)) {
            visitor.number("first_height_mm", *uniform->first_height_mm);
        }
    } else if (auto* const random = std::get_if<RandomLayers>(&plan.spacing)) {
        visitor.number("min_height_mm", random->min_height_mm);
        visitor.number("max_height_mm", random->max_height_mm);
        visitor.whole("seed", random->seed, 0, most);
    }
}

template <class Result>
void visit_region(FactVisitor& visitor, Result& result) {
    auto& region = result.region;
    visitor.begin("/region");
    visitor.choice("fill_rule", region.fill_rule, rules);
    visitor.whole("largest_only", region.largest_only, 0, 1);
    visitor.number("close_mm", region.close_mm);
    visitor.number("offset_mm", region.offset_mm);
    visitor.number("miter_limit", region.miter_limit);
    visitor.number("mark_near_mm", region.mark_near_mm);
    visitor.whole("drop_collinear", region.drop_collinear, 0, 1);
    visitor.number("simplify_mm", region.simplify_mm);
    visitor.choice("parts", result.part_regions, part_regions);
    visitor.number("close_gaps_mm", result.close_gaps_mm);
    visitor.choice("gap_sense", result.gap_sense, senses);
}

template <class Info>
void visit_image(FactVisitor& visitor, Info& info) {
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
        visitor.require(std::abs(length(image.axes[axis]) - 1) < 1e-3, axis_names[axis]);
    }
    visitor.numbers("origin_mm", image.origin_mm);
    visitor.numbers("spacing_mm", image.spacing_mm);
    visitor.require(*std::min_element(image.spacing_mm.begin(), image.spacing_mm.end()) > 0, "spacing_mm");
    visitor.whole("subslices", info.subslices, 1, 1000);
    AsConstAs<Info, std::uint64_t> uneven = image.uneven_slices_mm.size();
    visitor.whole("uneven_slices", uneven, 0, most_uneven_slices);
    if (uneven > 0) {
        visitor.require(uneven == image.size[2], "uneven_slices");
        if constexpr (!std::is_const_v<Info>) {
            image.uneven_slices_mm.resize(uneven);
        }
        visitor.numbers("uneven_slices_mm", image.uneven_slices_mm);
    }
}

template <class Result, class Info>
void visit(FactVisitor& visitor, Result& result, Info& info) {
    visitor.begin("/");
    visitor.number("unit_mm", result.unit_mm);
    visitor.require(result.unit_mm > 0, "unit_mm");
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
    FactVisitor writer(nullptr);
    visit(writer, result, info);
    return std::move(writer).take();
}

void read_facts(const Attributes& attributes, SliceResult& result, ArchiveInfo& info) {
    FactVisitor reader(&attributes);
    visit(reader, result, info);
}

}  // namespace lamella
