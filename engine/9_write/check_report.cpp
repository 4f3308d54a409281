// The diagnosis of a mesh as JSON.
#include <algorithm>
#include <new>

#include <nlohmann/json.hpp>

#include "lamella/check_report.hpp"

namespace lamella {

namespace {

using Json = nlohmann::ordered_json;

/// What Place::number and Place::measure are called, or null where the kind has none.
struct Fields {
    const char* number = nullptr;
    const char* measure = nullptr;
};

Fields fields_of(Fault fault) {
    switch (fault) {
        case Fault::boundary_edge:
        case Fault::overfull_balanced:
        case Fault::overfull_unbalanced:
        case Fault::mismatched_edge:
            return {"faces", nullptr};
        case Fault::boundary_loop:
            return {"edges", "length_mm"};
        case Fault::split_vertex:
            return {"fans", nullptr};
        case Fault::needle_face:
        case Fault::cap_face:
            return {nullptr, "ratio"};
        case Fault::wrong_sense_shell:
            return {nullptr, "volume_mm3"};
        case Fault::t_junction:
        case Fault::crack:
            return {nullptr, "width_mm"};
        default:
            return {};
    }
}

Json place_json(Fault fault, const Place& place) {
    Json points = Json::array();
    for (std::size_t i = 0; i < static_cast<std::size_t>(place.point_count); ++i) {
        points.push_back(place.points_mm[i]);
    }
    Json triangles = Json::array();
    for (const std::int64_t triangle : place.triangles) {
        if (triangle >= 0) {
            triangles.push_back(triangle);
        }
    }
    Json json = {{"points_mm", std::move(points)}, {"triangles", std::move(triangles)}};
    const Fields fields = fields_of(fault);
    if (fields.number != nullptr) {
        json[fields.number] = place.number;
    }
    if (fields.measure != nullptr) {
        json[fields.measure] = place.measure;
    }
    if (fault == Fault::boundary_loop) {
        json["closed"] = place.closed;
    }
    return json;
}

Json finding_json(Fault fault, const Finding& finding, std::size_t most_places) {
    Json places = Json::array();
    for (std::size_t i = 0; i < std::min(most_places, finding.places.size()); ++i) {
        places.push_back(place_json(fault, finding.places[i]));
    }
    return {{"count", finding.count}, {"at_least", finding.at_least}, {"places", std::move(places)}};
}

Json shells_json(const MeshCheck& check, std::size_t most_places) {
    Json shells = Json::array();
    for (std::size_t i = 0; i < std::min(most_places, check.shells.size()); ++i) {
        const Shell& shell = check.shells[i];
        shells.push_back({{"first_mm", shell.first_mm},
                          {"triangle", shell.triangle},
                          {"triangles", shell.triangles},
                          {"closed", shell.closed},
                          {"volume_mm3", shell.closed ? Json(shell.volume_mm3) : Json(nullptr)},
                          {"sense", shell.sense},
                          {"depth", shell.depth},
                          {"parent", shell.parent < 0 ? Json(nullptr) : Json(shell.parent)}});
    }
    return {{"count", check.shells.size()}, {"nesting_complete", check.nesting_complete}, {"first", std::move(shells)}};
}

Json report(const MeshCheck& check, const ReportContext& context, std::size_t most_places) {
    const MeshInfo& info = check.info;
    Json json = {{"mesh", context.mesh_file},
                 {"triangles", info.triangles},
                 {"edges", info.edges},
                 {"grid_mm", info.unit_mm},
                 {"tolerance_mm", check.tolerance_mm},
                 {"sliver_ratio", check.sliver_ratio},
                 {"box_mm", {{"min", info.min_mm}, {"max", info.max_mm}}},
                 {"closed", info.closed},
                 {"clean", check.clean()},
                 {"verdict", verdict(check)}};
    for (std::size_t i = 0; i < fault_count; ++i) {
        const Fault fault = static_cast<Fault>(i);
        json["findings"][std::string(key_of(fault))] = finding_json(fault, check.findings[i], most_places);
    }
    json["shells"] = shells_json(check, most_places);
    json["warnings"] = context.warnings;
    return json;
}

bool is_sliver(Fault fault) {
    return fault == Fault::needle_face || fault == Fault::cap_face;
}

}  // namespace

std::string verdict(const MeshCheck& check) {
    const bool clean = check.clean();
    std::string text = clean ? "closed and clean" : "not clean";
    const char* before = clean ? ", with " : ": ";
    for (std::size_t i = 0; i < fault_count; ++i) {
        const Finding& finding = check.findings[i];
        const Fault fault = static_cast<Fault>(i);
        if (finding.count > 0 && (clean || !is_sliver(fault))) {
            text += before + std::string(finding.at_least ? "at least " : "") + std::to_string(finding.count) + " " +
                    std::string(words_for(fault, finding.count));
            before = ", ";
        }
    }
    return text;
}

Result<std::string> check_json(const MeshCheck& check, const ReportContext& context, std::size_t most_places) noexcept {
    try {
        // File names need not be UTF-8 and JSON must be: bytes that are not become U+FFFD.
        return report(check, context, most_places).dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
    } catch (const std::bad_alloc&) {
        return Error{.code = Code::out_of_memory, .message = "out of memory"};
    }
}

}  // namespace lamella
