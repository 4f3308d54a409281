// Slices soups with corners on small integers, which often coincide. Both forms, other bands and threads, and shuffled
// triangles must all give the same valid result.
#include <array>

#include "bytes.hpp"
#include "lamella/io.hpp"
#include "lamella/lamella.hpp"
#include "soup.hpp"

using lamella::ContourForm;
using lamella::MeshView;
using lamella::SliceOptions;
using lamella::SliceResult;

namespace {

constexpr std::size_t most_triangles = 60;

/// The length of an integer step and the grid: a coarse grid, a fine one, and steps up to the limits of the grid.
struct Scale {
    double step_mm;
    double unit_mm;
};
constexpr std::array<Scale, 4> scales = {{{1, 0.5}, {1, 0.125}, {256, 0}, {0.37, 0}}};

struct Case {
    std::vector<fuzz::Triangle> triangles;
    SliceOptions options;
    std::uint32_t seed = 0;
    bool floats = false;
};

/// Heights on integers, where corners lie, and between them.
lamella::LayerPlan plan(fuzz::Bytes& bytes, double step_mm) {
    lamella::LayerPlan plan;
    const unsigned kind = bytes.next();
    plan.side = kind % 2 == 0 ? lamella::PlaneSide::below : lamella::PlaneSide::above;
    if (kind / 2 % 4 == 0) {
        plan.spacing = lamella::UniformLayers{step_mm * (1 + kind / 8 % 8) / 4, {}, lamella::Datum::mesh_min};
    } else if (kind / 2 % 4 == 1) {
        plan.spacing = lamella::UniformLayers{step_mm / 2, step_mm * (kind / 8 % 4) / 2, lamella::Datum::zero};
    } else if (kind / 2 % 4 == 2) {
        plan.spacing = lamella::RandomLayers{step_mm / 2, step_mm, kind};
    } else {
        lamella::ExplicitPlanes planes;
        for (int quarter = -18; quarter <= 18; quarter += 1 + static_cast<int>(kind / 8 % 8)) {
            planes.heights_mm.push_back(step_mm * quarter / 4);
        }
        plan.spacing = planes;
    }
    return plan;
}

Case drawn(fuzz::Bytes& bytes) {
    Case drawn;
    const unsigned form = bytes.next();
    const unsigned mending = bytes.next();
    const Scale scale = scales[form / 4 % 4];
    drawn.seed = form;
    drawn.floats = form % 2 != 0;
    drawn.options.unit_mm = scale.unit_mm;
    drawn.options.control.threads = 1 + static_cast<int>(form / 16 % 3);
    drawn.options.tuning.band_planes = static_cast<int>(form / 64);
    drawn.options.region.fill_rule = static_cast<lamella::FillRule>(mending % 4);
    drawn.options.close_gaps_mm = scale.step_mm * (mending / 4 % 4);
    drawn.options.gap_sense = mending / 64 % 2 != 0 ? lamella::GapSense::any : lamella::GapSense::kept;
    if (mending / 16 % 4 == 3) {
        drawn.options.transform = lamella::Transform::from_normal(1, mending / 64, 2);
    }
    drawn.options.plan = plan(bytes, scale.step_mm);
    while (!bytes.empty() && drawn.triangles.size() < most_triangles) {
        fuzz::add_shape(bytes, form / 2 % 2 != 0, scale.step_mm, drawn.triangles);
    }
    return drawn;
}

template <class Number>
lamella::Result<SliceResult> sliced_as(const Case& drawn) {
    const std::vector<Number> soup = fuzz::soup_of<Number>(drawn.triangles);
    return slice(MeshView::soup(std::span<const Number>(soup)), drawn.options);
}

/// The hash of a valid result, or the code of an error.
std::uint64_t outcome(const Case& drawn) {
    const lamella::Result<SliceResult> result = drawn.floats ? sliced_as<float>(drawn) : sliced_as<double>(drawn);
    if (!result) {
        // An exception inside the engine would become this code.
        fuzz::require(result.error().code != lamella::ErrorCode::cancelled, result.error().message);
        return static_cast<std::uint64_t>(result.error().code);
    }
    const lamella::Status valid = validate(*result);
    fuzz::require(valid.ok(), valid.ok() ? "" : valid.error().message);
    return hash_result(*result);
}

void check_ways(Case drawn) {
    const std::uint64_t expected = outcome(drawn);
    drawn.options.tuning.form = ContourForm::assembled;
    fuzz::require(outcome(drawn) == expected, "both forms give the same result");
    drawn.options.tuning.form = ContourForm::swept;
    drawn.options.tuning.band_planes = 3 - drawn.options.tuning.band_planes;
    drawn.options.control.threads = 4 - drawn.options.control.threads;
    fuzz::require(outcome(drawn) == expected, "bands and threads do not change the result");
    fuzz::shuffle_soup(drawn.triangles, drawn.seed);
    fuzz::require(outcome(drawn) == expected, "the order of triangles and corners does not change the result");
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::Bytes bytes(data, size);
    check_ways(drawn(bytes));
    return 0;
}
