// Every call that takes a Control and has a mesh, by name, and hosts that are asked for a stop.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/host_arrays.hpp"
#include "engine/slicing.hpp"
#include "lamella/io.hpp"
#include "temp_folder.hpp"

/// A check that calls `ask`, which says whether to stop.
template <class Ask>
lamella::StopCheck asking(Ask& ask) {
    return {[](void* context) noexcept { return static_cast<bool>((*static_cast<Ask*>(context))()); }, &ask};
}

struct ControlledCall {
    std::string name;
    /// What it fails with, or nothing.
    std::function<std::optional<lamella::ErrorCode>(const lamella::Control&)> run;
};

/// Calls on one mesh, which must outlive them, at layers of this height; audits are of a result at 0.1 mm.
class ControlledCalls {
public:
    ControlledCalls(const lamella::MeshView& mesh, std::filesystem::path file, double layer_mm)
        : mesh_(mesh), file_(std::move(file)), layer_mm_(layer_mm), result_(sliced(mesh, uniform(0.1))) {
        prepared_.emplace(value_of(prepare(mesh)));
        const lamella::OutputBounds bounds = value_of(bound_output(mesh, uniform(layer_mm)));
        host_.emplace(bounds.points, bounds.contours, bounds.layers, lamella::PointType::f64);
    }

    std::vector<ControlledCall> all() {
        using namespace lamella;
        const auto nothing = [](const LayerView&) noexcept {};
        const auto to_sink = [=, this](SinkOrder order) {
            return
                [=, this](const Control& c) { return code_of(slice_to(LayerSink::to(nothing, order), mesh_, slicing(c))); };
        };
        return {
            {"slice", [this](const Control& c) { return code_of(slice(mesh_, slicing(c))); }},
            {"prepare", [this](const Control& c) { return code_of(prepare(mesh_, {.control = c})); }},
            {"slice of a prepared mesh", [this](const Control& c) { return code_of(slice(*prepared_, slicing(c))); }},
            {"slice_to, in plane order", to_sink(SinkOrder::ascending)},
            {"slice_to, in any order", to_sink(SinkOrder::any)},
            {"slice_into", [this](const Control& c) { return code_of(slice_into(host_->output, mesh_, slicing(c))); }},
            {"slice_slabs",
             [this](const Control& c) {
                 SlabOptions options;
                 options.plan = slicing(c).plan;
                 options.control = c;
                 return code_of(slice_slabs(mesh_, options));
             }},
            {"inspect", [this](const Control& c) { return code_of(inspect(mesh_, {.control = c})); }},
            {"check",
             [this](const Control& c) {
                 CheckOptions options;
                 options.control = c;
                 return code_of(check(mesh_, options));
             }},
            {"weld", [this](const Control& c) { return code_of(weld(mesh_, {.control = c})); }},
            {"make_ledger", [this](const Control& c) { return code_of(make_ledger(mesh_, result_, c)); }},
            {"certify_volume", [this](const Control& c) { return code_of(certify_volume(mesh_, result_, c)); }},
            {"find_crossings", [this](const Control& c) { return code_of(find_crossings(result_, c)); }},
            {"read_mesh", [this](const Control& c) { return code_of(read_mesh(file_, {.control = c})); }},
            {"write_svg",
             [this](const Control& c) { return code_of(write_svg(result_, folder_ / "a.svg", {.control = c})); }},
        };
    }

private:
    lamella::SliceOptions slicing(const lamella::Control& control) const {
        lamella::SliceOptions options = uniform(layer_mm_);
        options.control = control;
        return options;
    }
    TempFolder folder_;
    lamella::MeshView mesh_;
    std::filesystem::path file_;
    double layer_mm_;
    lamella::SliceResult result_;
    std::optional<lamella::PreparedMesh> prepared_;
    std::optional<HostArrays> host_;
};
