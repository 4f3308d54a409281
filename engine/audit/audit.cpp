#include "lamella/audit.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "audit/questions.hpp"
#include "base/guard.hpp"
#include "base/sort.hpp"
#include "base/words.hpp"
#include "slicing/repair/polylines.hpp"

namespace lamella {

namespace {

Error invalid(const char* why) {
    return {ErrorCode::invalid_argument, why};
}

/// The box of what was sliced as `part`. Throws Refused where it cannot have been.
Bounds bounds_of(const Part& part, const SliceResult& result, const Parallel& parallel) {
    BlockTable blocks(nullptr);
    const Bounds bounds =
        require(measure_bounds(part.mesh, placing_of(part, result), result.info.grid_mm, parallel, blocks));
    if (bounds.farthest() > result.info.grid_mm * grid_limit) {
        throw Refused{invalid("the mesh does not fit the result's grid")};
    }
    return bounds;
}

/// The parts that were sliced, as far as they were given.
std::span<const Part> parts_of(const Source& source, const Part& whole) {
    if (source.prepared() != nullptr || source.other() != nullptr) {
        throw Refused{invalid("a result is compared with a MeshView or with parts")};
    }
    if (source.is_parts()) {
        return {source.parts(), source.part_count()};
    }
    const bool given = whole.mesh.vertices != nullptr || whole.mesh.triangle_count > 0;
    return {&whole, given ? std::size_t{1} : std::size_t{0}};
}

/// Throws Refused where the result is not of the parts.
void compare_counts(std::span<const Part> parts, const SliceInfo& info) {
    std::uint64_t triangles = 0;
    for (const Part& part : parts) {
        triangles += part.mesh.triangle_count;
    }
    if (!parts.empty() && parts.size() != info.part_count) {
        throw Refused{invalid("the result is not of so many parts")};
    }
    if (!parts.empty() && triangles != info.triangles) {
        throw Refused{invalid("the result is not of this mesh")};
    }
}

/// Throws Refused where the other questions cannot be answered; a broken promise is an answer.
Status answer_structure(const SliceResult& result, std::span<const Part> parts, const Parallel& parallel) {
    try {
        check_structure(result, parts, parallel);
    } catch (Refused& broken) {
        return std::move(broken.error);
    }
    return {};
}

Audit answer(const SliceResult& result, std::span<const Part> parts, const AuditOptions& questions,
             const Parallel& parallel) {
    parallel.stop_if_asked();
    compare_counts(parts, result.info);
    const bool has_triangles = !parts.empty() && parts.front().mesh.triangle_count > 0;
    const bool volume = questions.volume && has_triangles;
    const bool ledger = questions.ledger && has_triangles;
    const bool by_mesh = volume || ledger || (questions.structure && !parts.empty() && !result.origins.empty());
    const int shares = int{by_mesh} + int{volume} + int{ledger} + int{questions.crossings};
    int begun = 0;
    const auto next_progress = [&] { return 0.99 * ++begun / shares; };
    Bounds bounds{};
    if (by_mesh) {
        parallel.begin_stage(next_progress(), parts.size());
        for (const Part& part : parts) {
            bounds = part.mesh.triangle_count > 0 ? bounds_of(part, result, parallel) : bounds;
        }
    }
    Audit answers;
    if (questions.structure) {
        answers.structure = answer_structure(result, parts, parallel);
    }
    if (questions.open || volume || ledger || questions.crossings) {
        check_offsets(result);
    }
    if (questions.open) {
        answers.open = find_open_layers(result, parallel);
    }
    if (volume || ledger) {
        SlicedMesh sliced{result, parts.front().mesh, placing_of(parts.front(), result), bounds};
        sliced.planes.build(result.layers);
        if (volume) {
            answers.volume = certify_volume(sliced, parallel, next_progress());
            answers.volume->open = questions.open ? *answers.open : find_open_layers(result, parallel);
        }
        if (ledger) {
            answers.ledger = make_ledger(sliced, parallel, next_progress());
        }
    }
    if (questions.crossings) {
        answers.crossings = find_crossings(result, parallel, next_progress());
    }
    return answers;
}

constexpr double beyond = 1 + 1e-12;            ///< makes up for what squares of lengths and their units lose
constexpr double any_reach = 4.0 * grid_limit;  ///< beyond the diagonal of the grid

/// The least number of two digits that is not below `value`, which is positive.
std::string rounded_up(double value) {
    double step = 1;
    while (value >= 100 * step) {
        step *= 10;
    }
    double scale = 1;
    while (value * scale < 10) {
        scale *= 10;
    }
    return exact_text(std::ceil(value / step * scale) * step / scale);  // one of step and scale is 1
}

std::string percent_text(double share) {
    const double tenths = std::round(1000 * share);
    return tenths < 1 ? "less than 0.1 %" : exact_text(tenths / 10) + " %";
}

/// How far apart ends of one part's polylines are that have to be joined, in grid units. Sets `stuck` where some have
/// nothing to be joined to.
double reach_of(std::span<const PolylineEnds> ends, StitchDirection direction, GapCloser& closer, bool& stuck) {
    const std::span<const Gap> gaps = closer.close(ends, {any_reach, any_reach, direction});
    double longest = 1;  // ends at one point have to be joined too
    for (const Gap& gap : gaps) {
        const auto at = [&](PolylineEnd end) { return ends[end.polyline()].at(end.last()); };
        longest = std::max(longest, std::sqrt(squared_distance(at(gap.from), at(gap.to))));
    }
    stuck = stuck || gaps.size() < ends.size();
    return longest * beyond;
}

OpenLayers open_layer(const LayerView& view, StitchDirection direction, const StopCheck& stop) {
    OpenLayers found;
    if (view.segments == 0) {
        return found;
    }
    found.crossed = 1;
    found.crossed_mm = view.top_mm - view.bottom_mm;
    for (const Stitch& gap : view.stitches) {
        found.reach_mm = std::max(found.reach_mm, std::sqrt(squared_distance(gap.from, gap.to)) * view.grid_mm * beyond);
    }
    Worker worker(nullptr, stop);
    worker.spend(view.stitches.size() + view.contours.size());
    std::vector<const Contour*> open;
    for (const Contour& contour : view.contours) {
        if (contour.role == Role::open && contour.point_count > 0) {
            open.push_back(&contour);
        }
    }
    if (open.empty()) {
        return found;
    }
    found.layers = 1;
    found.height_mm = found.crossed_mm;
    sort_briefly(open.begin(), open.end(),
                 [](const Contour* a, const Contour* b) { return a->part != b->part ? a->part < b->part : a < b; });
    GapCloser closer(worker);
    bool stuck = false;
    std::vector<PolylineEnds> ends;
    for (std::size_t i = 0; i < open.size(); ++i) {
        const std::span<const Point> points = view.points_of(*open[i]);
        ends.push_back({points.front(), points.back()});
        if (i + 1 == open.size() || open[i + 1]->part != open[i]->part) {
            found.reach_mm = std::max(found.reach_mm, reach_of(ends, direction, closer, stuck) * view.grid_mm);
            ends.clear();
        }
    }
    found.stuck = stuck ? 1 : 0;
    return found;
}

}  // namespace

Result<Audit> audit(const SliceResult& result, const Source& mesh, const AuditOptions& questions,
                    const Context& context) noexcept {
    return guarded(context, [&]() -> Result<Audit> {
        const Part whole{.mesh = mesh.mesh()};
        const std::span<const Part> parts = parts_of(mesh, whole);
        if (mesh.is_parts() && (questions.volume || questions.ledger)) {
            return invalid("volume and ledger are of one mesh");
        }
        Context own = context;
        own.memory = nullptr;  // the host's is for what calls return
        const Parallel parallel(own);
        Audit answers = answer(result, parts, questions, parallel);
        parallel.finish();
        return answers;
    });
}

double OpenLayers::share() const noexcept {
    return crossed_mm > 0 ? height_mm / crossed_mm
                          : static_cast<double>(layers) / static_cast<double>(std::max<std::uint64_t>(crossed, 1));
}

void OpenLayers::add(const OpenLayers& other) noexcept {
    layers += other.layers;
    crossed += other.crossed;
    stuck += other.stuck;
    height_mm += other.height_mm;
    crossed_mm += other.crossed_mm;
    reach_mm = std::max(reach_mm, other.reach_mm);
}

Result<OpenLayers> find_open_layer(const LayerView& layer, StitchDirection direction, const Context& context) noexcept {
    return guarded(context, [&]() -> Result<OpenLayers> { return open_layer(layer, direction, context.stop); });
}

OpenLayers find_open_layers(const SliceResult& result, const Parallel& parallel) {
    std::vector<OpenLayers> layers(result.size());
    parallel.run(layers.size(), [&](std::size_t i, int) {
        layers[i] = open_layer(result[i], result.info.options.stitch_direction, parallel.stop());
    });
    OpenLayers all;
    for (const OpenLayers& layer : layers) {
        all.add(layer);
    }
    return all;
}

std::string describe(const OpenLayers& open, std::string_view option) {
    const bool one = open.layers == 1;
    std::string text = std::to_string(open.layers) + " of " + std::to_string(open.crossed) +
                       (open.crossed == 1 ? " layer (" : " layers (") + percent_text(open.share()) + " of the height) " +
                       (one ? "has open contours: its" : "have open contours: their") + " area is not known; ";
    if (open.stuck == open.layers) {
        return text + "no length of " + std::string(option) + "would close " + (one ? "it" : "them");
    }
    text += std::string(option) + rounded_up(open.reach_mm / (beyond * beyond)) + " would close ";
    return text + (open.stuck > 0 ? "all but " + std::to_string(open.stuck) : (one ? "it" : "them"));
}

}  // namespace lamella
