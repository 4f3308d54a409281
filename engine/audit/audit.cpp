#include "lamella/audit.hpp"

#include <utility>

#include "audit/questions.hpp"
#include "base/guard.hpp"

namespace lamella {

namespace {

Error invalid(const char* why) {
    return {ErrorCode::invalid_argument, why};
}

template <class T>
bool within(std::uint64_t first, std::uint64_t count, const Array<T>& array) noexcept {
    return first <= array.size() && count <= array.size() - first;
}

/// Throws Refused unless planes ascend, and the contours of layers and the points of contours lie within their arrays: less
/// than check_structure(), but what the other questions rely on.
void examine(const SliceResult& result) {
    for (std::size_t l = 0; l < result.layers.size(); ++l) {
        if (l > 0 && result.layers[l].plane <= result.layers[l - 1].plane) {
            throw Refused{invalid("the result's planes do not ascend")};
        }
        if (!within(result.layers[l].first_contour, result.layers[l].contour_count, result.contours)) {
            throw Refused{invalid("a layer of the result reaches past its contours")};
        }
    }
    for (const Contour& contour : result.contours) {
        if (!within(contour.first_point, contour.point_count, result.points)) {
            throw Refused{invalid("a contour of the result reaches past its points")};
        }
    }
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
    const auto next_share = [&] {
        constexpr double all = 0.99;
        const double from = all * begun / shares;
        return ProgressShare{parallel, from, all * ++begun / shares};
    };
    Bounds bounds{};
    if (by_mesh) {
        next_share().begin(1, parts.size());
        for (const Part& part : parts) {
            bounds = part.mesh.triangle_count > 0 ? bounds_of(part, result, parallel) : bounds;
        }
    }
    Audit answers;
    if (questions.structure) {
        answers.structure = answer_structure(result, parts, parallel);
    }
    if (questions.open || volume || ledger || questions.crossings) {
        examine(result);
    }
    if (questions.open) {
        answers.open = find_open_layers(result, parallel);
    }
    if (volume || ledger) {
        SlicedMesh sliced{result, parts.front().mesh, placing_of(parts.front(), result), bounds};
        sliced.planes.build(result.layers);
        if (volume) {
            answers.volume = certify_volume(sliced, next_share());
            answers.volume->open = questions.open ? *answers.open : find_open_layers(result, parallel);
        }
        if (ledger) {
            answers.ledger = make_ledger(sliced, next_share());
        }
    }
    if (questions.crossings) {
        check_offsets(result);  // paths are told apart by where their points lie
        answers.crossings = find_crossings(result, next_share());
    }
    return answers;
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
        const Parallel parallel(context);
        Audit answers = answer(result, parts, questions, parallel);
        parallel.finish();
        return answers;
    });
}

}  // namespace lamella
