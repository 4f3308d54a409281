// Slices soups with corners on small integers, which often coincide. Both forms, other bands and threads, and shuffled
// triangles must all give the same valid result.
#include "bytes.hpp"
#include "lamella/io.hpp"
#include "lamella/lamella.hpp"
#include "slicing/tuning.hpp"

using namespace lamella;

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
    Tuning tuning;
    int threads = 1;
    std::uint32_t seed = 0;
    bool floats = false;
};

/// Heights on integers, where corners lie, and between them.
void choose_planes(fuzz::Bytes& bytes, double step_mm, Case& drawn) {
    SliceOptions& options = drawn.options;
    const unsigned kind = bytes.next();
    options.planes.side = kind % 2 == 0 ? PlaneSide::below : PlaneSide::above;
    if (kind / 2 % 4 == 0) {
        options.layer_height_mm = step_mm * (1 + kind / 8 % 8) / 4;
    } else if (kind / 2 % 4 == 1) {
        options.layer_height_mm = step_mm / 2;
        options.planes.first_height_mm = step_mm * (kind / 8 % 4) / 2;
        options.planes.datum = Datum::zero;
    } else if (kind / 2 % 4 == 2) {
        drawn.tuning.random_heights = {step_mm / 2, step_mm, kind};
    } else {
        std::vector<double>& heights_mm = options.heights_mm.emplace();
        for (int quarter = -18; quarter <= 18; quarter += 1 + static_cast<int>(kind / 8 % 8)) {
            heights_mm.push_back(step_mm * quarter / 4);
        }
    }
}

Case drawn(fuzz::Bytes& bytes) {
    Case drawn;
    const unsigned form = bytes.next();
    const unsigned mending = bytes.next();
    const Scale scale = scales[form / 4 % 4];
    drawn.seed = form;
    drawn.floats = form % 2 != 0;
    drawn.options.frame.grid_mm = scale.unit_mm;
    drawn.threads = 1 + static_cast<int>(form / 16 % 3);
    drawn.tuning.band_planes = form / 64;
    drawn.options.region.fill_rule = static_cast<FillRule>(mending % 4);
    drawn.options.stitch_mm = scale.step_mm * (mending / 4 % 4);
    drawn.options.stitch_direction = mending / 64 % 2 != 0 ? StitchDirection::any : StitchDirection::oriented;
    if (mending / 16 % 4 == 3) {
        drawn.options.frame.transform = Transform::from_normal(1, mending / 64, 2);
    }
    choose_planes(bytes, scale.step_mm, drawn);
    while (!bytes.empty() && drawn.triangles.size() < most_triangles) {
        fuzz::add_shape(bytes, form / 2 % 2 != 0, scale.step_mm, drawn.triangles);
    }
    return drawn;
}

template <class Number>
Result<SliceResult> sliced_as(const Case& drawn) {
    const std::vector<Number> soup = fuzz::soup_of<Number>(drawn.triangles);
    Slicer slicer;
    SliceResult result;
    const auto info = slice_tuned(slicer, result, MeshView::soup(std::span<const Number>(soup)), drawn.options, drawn.tuning,
                                  {.threads = drawn.threads});
    return info ? Result<SliceResult>(std::move(result)) : info.error();
}

/// The hash of a valid result, or the code of an error.
std::uint64_t outcome(const Case& drawn) {
    const Result<SliceResult> result = drawn.floats ? sliced_as<float>(drawn) : sliced_as<double>(drawn);
    if (!result) {
        // An exception inside the engine would become this code.
        fuzz::require(result.error().code != ErrorCode::cancelled, result.error().message);
        return static_cast<std::uint64_t>(result.error().code);
    }
    fuzz::require_valid(*result);
    return result->hash();
}

void check_ways(Case drawn) {
    const std::uint64_t expected = outcome(drawn);
    drawn.tuning.form = ContourForm::assembled;
    fuzz::require(outcome(drawn) == expected, "both forms give the same result");
    drawn.tuning.form = ContourForm::swept;
    drawn.tuning.band_planes = 3 - drawn.tuning.band_planes;
    drawn.threads = 4 - drawn.threads;
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
