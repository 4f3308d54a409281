// audit(), one question at a time, and results made by hand for it.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "lamella/audit.hpp"
#include "rings.hpp"

namespace audits {

inline lamella::Result<lamella::Audit> asked(bool lamella::AuditOptions::*question, const lamella::SliceResult& result,
                                             const lamella::Source& mesh, const lamella::Context& context = {}) {
    lamella::AuditOptions questions{.open = false, .volume = false, .ledger = false, .crossings = false};
    questions.*question = true;
    return audit(result, mesh, questions, context);
}

template <class Answer>
lamella::Result<Answer> answer(bool lamella::AuditOptions::*question, std::optional<Answer> lamella::Audit::*member,
                               const lamella::SliceResult& result, const lamella::Source& mesh,
                               const lamella::Context& context) {
    auto found = asked(question, result, mesh, context);
    return found ? lamella::Result<Answer>(std::move(((*found).*member).value())) : found.error();
}

inline lamella::Status structure_of(const lamella::SliceResult& result, const lamella::Source& mesh = lamella::MeshView{},
                                    const lamella::Context& context = {}) {
    const auto found = asked(&lamella::AuditOptions::structure, result, mesh, context);
    return found ? found->structure.value() : lamella::Status(found.error());
}
inline auto ledger_of(const lamella::SliceResult& result, const lamella::Source& mesh,
                      const lamella::Context& context = {}) {
    return answer(&lamella::AuditOptions::ledger, &lamella::Audit::ledger, result, mesh, context);
}
inline auto volume_of(const lamella::SliceResult& result, const lamella::Source& mesh,
                      const lamella::Context& context = {}) {
    return answer(&lamella::AuditOptions::volume, &lamella::Audit::volume, result, mesh, context);
}
inline auto crossings_of(const lamella::SliceResult& result, const lamella::Context& context = {}) {
    return answer(&lamella::AuditOptions::crossings, &lamella::Audit::crossings, result, lamella::MeshView{}, context);
}
inline auto open_layers_of(const lamella::SliceResult& result, const lamella::Context& context = {}) {
    return answer(&lamella::AuditOptions::open, &lamella::Audit::open, result, lamella::MeshView{}, context);
}

inline bool same(const lamella::Crossings& one, const lamella::Crossings& other) {
    return one.count == other.count && one.at_least == other.at_least &&
           std::equal(one.layers.begin(), one.layers.end(), other.layers.begin(), other.layers.end(),
                      [](const lamella::LayerCrossings& a, const lamella::LayerCrossings& b) {
                          return a.layer == b.layer && a.count == b.count && a.at_least == b.at_least &&
                                 a.first == b.first && a.contours == b.contours;
                      });
}

struct MadeContour {
    std::vector<lamella::Point> points;
    lamella::Role role = lamella::Role::outer;
    int orientation = 1;
    std::int64_t parent = -1;
    unsigned flags = 0;
};
using MadeLayer = std::vector<MadeContour>;

/// Makes an array of these values.
template <class T>
void fill(lamella::Array<T>& array, const std::vector<T>& values) {
    array.resize_discarding(values.size());
    std::copy(values.begin(), values.end(), array.begin());
}

/// Layers at planes 1, 3, 5 and so on. Sums, areas and counts follow from the contours.
inline lamella::SliceResult made_result(const std::vector<MadeLayer>& made) {
    using lamella::Role;
    lamella::SliceResult result;
    std::vector<lamella::Layer> layers;
    std::vector<lamella::Contour> contours;
    std::vector<lamella::Point> points;
    for (const MadeLayer& made_layer : made) {
        const double z = 2.0 * static_cast<double>(layers.size()) + 1;
        lamella::Layer& layer = layers.emplace_back();
        layer.bottom_mm = z - 1;
        layer.plane_mm = z;
        layer.top_mm = z + 1;
        layer.first_contour = contours.size();
        layer.contour_count = made_layer.size();
        layer.plane = lamella::PlaneHeight(static_cast<std::int32_t>(z));
        for (const auto& [path, role, orientation, parent, flags] : made_layer) {
            lamella::Contour& contour = contours.emplace_back();
            contour.first_point = points.size();
            contour.point_count = static_cast<std::uint32_t>(path.size());
            contour.segments = contour.point_count - (role == Role::open ? 1 : 0);
            contour.role = role;
            contour.orientation = static_cast<std::int8_t>(orientation);
            contour.parent = parent;
            contour.flags = static_cast<std::uint16_t>(flags);
            const rings::Int128 area = role == Role::open ? 0 : rings::twice_area(path);
            contour.twice_area = {static_cast<std::uint64_t>(area), static_cast<std::int64_t>(area >> 64)};
            points.insert(points.end(), path.begin(), path.end());
            layer.segments += contour.segments;
            result.info.segments += contour.segments;
            result.info.holes += role == Role::hole;
            result.info.flat_contours += role == Role::flat;
            result.info.open_contours += role == Role::open;
            result.info.overruled_contours += (flags & lamella::orientation_overruled) != 0;
            result.info.would_close_contours += (flags & lamella::would_close) != 0;
        }
    }
    fill(result.layers, layers);
    fill(result.contours, contours);
    fill(result.points, points);
    return result;
}

}  // namespace audits
