// Every call on a mesh in memory that takes a Context, by name, and what a Context promises of each call.
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/counting_memory.hpp"
#include "engine/everywhere.hpp"

/// Says yes from the ask number `from` on.
struct LateStop {
    std::uint64_t from = std::numeric_limits<std::uint64_t>::max();
    std::atomic<std::uint64_t> asked{0};

    bool operator()() noexcept { return ++asked >= from; }
};

struct ContextCall {
    std::string name;
    /// Returns the code that it fails with, or nothing.
    std::function<std::optional<lamella::ErrorCode>(const lamella::Context&)> run;
    bool shows_progress = true;
};

/// It refuses negative threads, ends when asked to, and shows rising progress up to 1, one thread at a time.
inline void require_obedient(const ContextCall& call) {
    using lamella::ErrorCode;
    INFO(call.name);
    CHECK(call.run({.threads = -1}) == ErrorCode::invalid_argument);
    double last = 0;
    std::atomic<int> inside = 0;
    const auto note = [&](double fraction) noexcept {
        const bool alone = ++inside == 1;
        last = alone && fraction > last ? fraction : -1;
        std::this_thread::yield();
        --inside;
    };
    for (const int threads : {1, 3}) {
        last = 0;
        CHECK(call.run({.threads = threads, .progress = note}) == std::nullopt);
        CHECK(last == (call.shows_progress ? 1 : 0));
    }
    LateStop at_once{1};
    last = 0;
    CHECK(call.run({.threads = 2, .stop = at_once, .progress = note}) == ErrorCode::cancelled);
    CHECK(last < 1);
    CHECK(at_once.asked <= 2);
}

/// Runs `call` until it succeeds. In each run, the first failing allocation is `step` later: each failure is an error, and
/// no memory stays allocated. Returns how often it failed.
inline std::uint64_t fail_everywhere(const std::function<std::optional<lamella::ErrorCode>(const lamella::Context&)>& call,
                                     lamella::Context context = {}, std::uint64_t step = 1) {
    using lamella::ErrorCode;
    std::optional<ErrorCode> code = ErrorCode::out_of_memory;
    std::uint64_t at = 1;
    for (; code; at += step) {
        const CountingMemory memory(~std::size_t{0}, at);
        context.memory = &memory;
        code = call(context);
        INFO("allocation " << at);
        REQUIRE(memory.held() == 0);
        REQUIRE(code.value_or(ErrorCode::out_of_memory) == ErrorCode::out_of_memory);
    }
    return at / step - 1;
}

/// Nested and overlapping shells, one inverted, one with a hole in its surface: contours of every role.
inline shapes::Soup everything() {
    return shapes::joined({shapes::box({0, 0, 0}, {9, 9, 9}), shapes::flipped(shapes::box({1, 1, 1}, {4, 4, 8})),
                           shapes::box({6, 6, 0}, {12, 12, 9}),
                           shapes::without(shapes::octasphere({20, 0, 5}, 5, 2), 108, 6)});
}

/// Calls on one mesh, which must outlive them, at layers of this height; audits are of a result at 0.1 mm.
class ContextCalls {
public:
    ContextCalls(const lamella::MeshView& mesh, double layer_mm)
        : mesh_(mesh),
          options_(uniform(layer_mm)),
          result_(sliced(mesh, uniform(0.1))),
          closed_(sliced(shapes::octasphere({0, 0, 5}, 5, 2), uniform(0.1))),
          prepared_(value_of(prepare(mesh))),
          parts_{{.mesh = mesh}, {.mesh = mesh, .at_mm = places_}},
          roles_{{.mesh = mesh},
                 {.mesh = mesh, .placement = lamella::Transform::scale(0.5), .role = lamella::PartRole::negative}},
          above_{{.layers = result_}, {.layers = result_, .from = 1, .to = 2, .grow_mm = 0.1}} {
        lamella::Slicer slicer;
        const lamella::SliceInfo outline = value_of(slicer.outline(mesh, options_));
        host_.emplace(ArraySizes{2 * outline.segments, outline.segments, outline.layers},
                      PointForm{.type = lamella::Number::f64});
    }

    std::vector<ContextCall> all() {
        using namespace lamella;
        const auto slices_of = [this](const Source& from, LayerContent content = LayerContent::section) {
            SliceOptions options = options_;
            options.content = content;
            return [from, options](const Context& c) { return code_of(slice(from, options, c)); };
        };
        const auto slices_to = [this](const Destination& to) {
            return [this, to](const Context& c) { return code_of(Slicer().slice_to(to, mesh_, options_, c)); };
        };
        const auto audits_of = [this](bool AuditOptions::*question) {
            return [this, question](const Context& c) { return code_of(audits::asked(question, result_, mesh_, c)); };
        };
        return {
            {"slice", slices_of(mesh_)},
            {"slice of a prepared mesh", slices_of(prepared_)},
            {"slice of parts", slices_of(parts_)},
            {"slice of parts with roles", slices_of(roles_)},
            {"slice to a sink in plane order", slices_to(ascending_)},
            {"slice to a sink in any order", slices_to(any_order_)},
            {"slice to arrays", slices_to(host_->arrays)},
            {"slice of upward faces", slices_of(mesh_, LayerContent::upward_faces)},
            {"outline", [this](const Context& c) { return code_of(Slicer().outline(mesh_, options_, c)); }, false},
            {"make_ready", [](const Context& c) { return code_of(Slicer().make_ready(1000, c)); }, false},
            {"prepare", [this](const Context& c) { return code_of(prepare(mesh_, {}, c)); }},
            {"check, counts only", [this](const Context& c) { return code_of(check(mesh_, {.counts_only = true}, c)); }},
            {"check", [this](const Context& c) { return code_of(check(mesh_, {}, c)); }},
            {"weld", [this](const Context& c) { return code_of(weld(mesh_, 0.01, c)); }},
            {"orient_shells", [this](const Context& c) { return code_of(orient_shells(mesh_, 0, c)); }},
            {"audit of the ledger", audits_of(&AuditOptions::ledger)},
            {"audit of the volume", audits_of(&AuditOptions::volume)},
            {"audit of crossings", audits_of(&AuditOptions::crossings)},
            {"adaptive_layers",
             [this](const Context& c) { return code_of(adaptive_layers(mesh_, {.cusp_mm = 0.1, .smoothing_mm = 1}, c)); }},
            {"combine",
             [this](const Context& c) {
                 SliceResult tops;
                 return code_of(Overlay().combine(tops, above_, subtract, {}, c));
             }},
            {"clip",
             [this](const Context& c) {
                 SliceResult pieces;
                 return code_of(Overlay().clip(pieces, result_, above_[1], {}, c));
             }},
            {"slice_sections", [this](const Context& c) { return code_of(slice_sections(mesh_, frames_, options_, c)); }},
            {"measure", [this](const Context& c) { return code_of(measure(result_, {.islands = true, .feret = true}, c)); }},
            {"find_tracks", [this](const Context& c) { return code_of(find_tracks(closed_, {.pockets = true}, c)); }},
        };
    }

    /// And those of small input, which come to no report of progress on the way.
    std::vector<ContextCall> all_and_small() {
        using namespace lamella;
        std::vector<ContextCall> calls = all();
        calls.push_back({"assemble", [this](const Context& c) { return code_of(assemble(segments_, c)); }, false});
        calls.push_back(
            {"region_of", [this](const Context& c) { return code_of(region_of(contours_, rules_, 1, c)); }, false});
        return calls;
    }

private:
    static std::vector<lamella::Segment> segments() {
        std::vector<lamella::Segment> all;
        for (std::uint64_t i = 0; i < 5000; ++i) {
            const auto at = static_cast<std::int32_t>(i);
            all.push_back({{i, 0, 0}, {i % 3 == 2 ? i - 2 : i + 1, 0, 0}, {at, at % 7}, {at + 1, at % 5}, 0, 0});
        }
        return all;
    }

    static constexpr auto nothing = [](const lamella::LayerView&) noexcept {};

    lamella::MeshView mesh_;
    lamella::SliceOptions options_;
    lamella::SliceResult result_;
    lamella::SliceResult closed_;
    lamella::PreparedMesh prepared_;
    std::vector<std::array<double, 3>> places_{{0, 0, 0}, {1, 2, 0.5}};
    std::vector<lamella::Transform> frames_ =
        std::vector<lamella::Transform>(40, lamella::Transform{{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, -5}});
    std::vector<lamella::Part> parts_;
    std::vector<lamella::Part> roles_;
    std::vector<lamella::LayerSet> above_;
    std::optional<GuardedArrays> host_;
    std::vector<lamella::Segment> segments_ = segments();
    std::vector<std::vector<lamella::Point>> squares_ = {{{0, 0}, {4000, 0}, {4000, 4000}, {0, 4000}},
                                                         {{2000, 2000}, {6000, 2000}, {6000, 6000}, {2000, 6000}},
                                                         {{6100, 0}, {9000, 0}, {9000, 5000}, {6100, 5000}}};
    std::vector<std::span<const lamella::Point>> contours_{squares_.begin(), squares_.end()};
    lamella::RegionRules rules_{
        .fill_rule = lamella::FillRule::non_zero, .closing_mm = 60, .offset_mm = -20, .drop_collinear = true};
    lamella::LayerSink ascending_{.take = nothing};
    lamella::LayerSink any_order_{.take = nothing, .order = lamella::SinkOrder::any};
};
