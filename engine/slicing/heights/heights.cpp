// adaptive_layers(), as the list of its stages:
//
//     read_lengths    options in steps
//     measure         the box of all parts: from where slabs are counted, and over how many steps
//     read_slopes     the least slope over each step
//     StepHeights     the height that each step allows: smoothed, changing little from slab to slab; ranges
//     walk            slabs, from the lowest vertex up

#include "lamella/heights.hpp"

#include <cmath>
#include <limits>
#include <string>

#include "base/guard.hpp"
#include "base/numbers.hpp"
#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "base/words.hpp"
#include "slicing/buckets/prepared_source.hpp"
#include "slicing/heights/slope_table.hpp"
#include "slicing/heights/step_heights.hpp"
#include "slicing/slice_layers.hpp"

namespace lamella {

namespace {

constexpr std::size_t blocks_a_task = 64;
constexpr double most_table_steps = 1 << 24;
constexpr double most_steps_a_slab = 1 << 20;

[[noreturn]] void refuse_heights(const std::string& message) {
    throw Refused{{ErrorCode::invalid_argument, message}};
}

void require_length(double mm, const char* name) {
    if (!(mm >= 0) || !std::isfinite(mm)) {
        refuse_heights(std::string(name) + " must be finite and at least 0, not " + exact_text(mm));
    }
}

/// In whole steps, rounded down.
std::uint32_t steps_in(double mm, double step_mm, const char* name) {
    require_length(mm, name);
    const double steps = mm / step_mm + StepScale::slack;
    if (!(steps <= most_steps_a_slab)) {
        refuse_heights(std::string(name) + " is more than 2^20 times step_mm: " + exact_text(mm));
    }
    return static_cast<std::uint32_t>(steps);
}

void check_height_ranges(const AdaptiveOptions& options) {
    double before_mm = 0;
    for (std::size_t i = 0; i < options.ranges.size(); ++i) {
        const HeightRange& range = options.ranges[i];
        const std::string name = "ranges[" + std::to_string(i) + "]";
        if (!(range.from_mm >= before_mm) || !(range.to_mm > range.from_mm) || !std::isfinite(range.to_mm)) {
            refuse_heights(name + " must begin at 0 or above, after the one before, and end above that");
        }
        if (steps_in(range.height_mm, options.step_mm, (name + ".height_mm").c_str()) == 0) {
            refuse_heights(name + ".height_mm is less than step_mm");
        }
        before_mm = range.to_mm;
    }
}

HeightLimits read_lengths(const AdaptiveOptions& options) {
    const double step_mm = options.step_mm;
    if (!(step_mm > 0) || !std::isfinite(step_mm) || !std::isfinite(1 / step_mm)) {
        refuse_heights("step_mm must be finite and more than 0, not " + exact_text(step_mm));
    }
    const HeightLimits limits{.least = steps_in(options.least_mm, step_mm, "least_mm"),
                              .most = steps_in(options.most_mm, step_mm, "most_mm"),
                              .most_change = steps_in(options.most_change_mm, step_mm, "most_change_mm"),
                              .smoothing = steps_in(options.smoothing_mm, step_mm, "smoothing_mm")};
    require_length(options.cusp_mm, "cusp_mm");
    require_length(options.deviation_mm, "deviation_mm");
    require_length(options.slope_limit_mm, "slope_limit_mm");
    if (limits.least == 0 || limits.most < limits.least) {
        refuse_heights("least_mm must be at least step_mm and at most most_mm");
    }
    if (options.most_change_mm > 0 && limits.most_change == 0) {
        refuse_heights("most_change_mm must be 0 or at least step_mm");
    }
    check_height_ranges(options);
    return limits;
}

/// What the measures allow at a slope, in mm.
double height_at(double squared_tangent, const AdaptiveOptions& options) noexcept {
    double height = std::numeric_limits<double>::infinity();
    if (options.cusp_mm > 0) {
        height = options.cusp_mm * std::sqrt(1 + squared_tangent);
    }
    const double tangent = std::sqrt(squared_tangent);
    if (options.deviation_mm > 0) {
        height = std::min({height, options.deviation_mm / 0.184, 1.44 * options.deviation_mm * std::sqrt(tangent)});
    }
    if (options.slope_limit_mm > 0) {
        height = std::min(height, options.slope_limit_mm * tangent);
    }
    return height;
}

/// One call.
class AdaptiveHeights {
public:
    AdaptiveHeights(const Source& source, const AdaptiveOptions& options, const Context& context)
        : options_(options), limits_(read_lengths(options)), parallel_(context), context_(context) {
        if (source.other() != nullptr) {
            refuse_heights("a file in pieces has no adaptive layers; read it whole");
        }
        if (source.is_parts()) {
            for (std::size_t p = 0; p < source.part_count(); ++p) {
                const Part& part = source.parts()[p];
                meshes_.push_back(
                    {&part.mesh, placing_of(part.mesh, options.frame, part.placement), BlockTable(context.memory)});
            }
            in_parts_ = true;
        } else {
            const detail::PreparedImpl* const prepared = source.prepared();
            const MeshView& mesh = prepared != nullptr ? prepared->mesh : source.mesh();
            const Frame& frame = prepared != nullptr ? prepared->frame_for(options.frame) : options.frame;
            meshes_.push_back({&mesh, placing_of(mesh, frame), BlockTable(context.memory)});
        }
    }

    Array<Slab> find() {
        parallel_.begin_stage(0.99, 2 * meshes_.size());
        measure();
        SlopeTable table(steps_, flattest(), context_.memory);
        read_slopes(table);
        parallel_.stop_if_asked();
        StepHeights heights(limits_, steps_, context_.memory);
        for (std::uint32_t step = 0; step < steps_; ++step) {
            const auto squared_tangent = static_cast<double>(table.squared_tangent(step));
            heights.allow(step, height_at(squared_tangent, options_) * scale_.per_mm);
        }
        for (const HeightRange& range : options_.ranges) {
            heights.set_range(range.from_mm * scale_.per_mm, range.to_mm * scale_.per_mm,
                              steps_in(range.height_mm, options_.step_mm, "height_mm"));
        }
        parallel_.stop_if_asked();
        heights.settle();
        Array<Slab> slabs = write(heights);
        parallel_.finish();
        return slabs;
    }

private:
    struct PlacedMesh {
        const MeshView* mesh;
        Placing placing;
        BlockTable blocks;
    };

    /// The box, and from it the steps.
    void measure() {
        if (meshes_.empty()) {
            refuse_heights("there are no parts");
        }
        Bounds box = Bounds::empty();
        for (std::size_t p = 0; p < meshes_.size(); ++p) {
            auto& [mesh, placing, blocks] = meshes_[p];
            const Result<Bounds> own = measure_bounds(*mesh, placing, 0, parallel_, blocks);
            if (!own) {
                throw Refused{in_parts_ ? blamed_on_part(own.error(), p) : own.error()};
            }
            box.add(*own);
        }
        scale_ = {box.min_mm[2], 1 / options_.step_mm};
        high_mm_ = box.max_mm[2];
        const double steps = std::max(1.0, std::ceil(scale_.of(high_mm_) - StepScale::slack));
        const std::uint64_t limit = detail::memory_limit(context_.memory_limit_bytes);
        if (!(steps < most_table_steps) || bytes_for(static_cast<std::uint32_t>(steps)) > limit) {
            throw Refused{{ErrorCode::result_too_large,
                           exact_text(high_mm_ - scale_.low_mm) + " mm in steps of " + exact_text(options_.step_mm) +
                               " mm need more than the memory limit of " + std::to_string(limit) + " bytes"}};
        }
        steps_ = static_cast<std::uint32_t>(steps);
    }

    static std::uint64_t bytes_for(std::uint32_t steps) noexcept {
        return SlopeTable::bytes_for(steps) + StepHeights::bytes_for(steps);
    }

    void read_slopes(SlopeTable& table) const {
        for (const PlacedMesh& placed : meshes_) {
            const std::size_t blocks = placed.blocks.blocks.size();
            parallel_.run_ranges(blocks, blocks_a_task, [&](std::size_t begin, std::size_t end, int) {
                table.add(*placed.mesh, placed.placing, placed.blocks, begin, end, scale_);
            });
        }
        table.settle();
    }

    /// The greatest squared tangent by which a slab is no higher than by the least.
    float flattest() const noexcept {
        const auto height_of = [this](std::uint32_t bits) {
            return limits_.within(height_at(static_cast<double>(bits_as<float>(bits)), options_) * scale_.per_mm);
        };
        const std::uint32_t least = height_of(0);
        std::uint32_t same = 0;  // invariant: it has the least height, and `other` has more
        std::uint32_t other = bits_as<std::uint32_t>(SlopeTable::upright) + 1;
        while (other - same > 1) {
            const std::uint32_t middle = same + (other - same) / 2;
            (height_of(middle) == least ? same : other) = middle;
        }
        return bits_as<float>(same);
    }

    double mm_at(std::uint32_t step) const noexcept { return scale_.low_mm + step * options_.step_mm; }

    /// Calls use(slab, its number) for each; returns how many there are.
    template <class Use>
    std::size_t walk(const StepHeights& heights, Use use) const {
        std::size_t count = 0;
        std::uint32_t below = 0;
        for (std::uint32_t step = 0; step < steps_; step += below, ++count) {
            below = heights.of_slab(step, below);
            const Slab slab{mm_at(step), mm_at(step + below)};
            if (count > 0 && middle_of(slab) >= high_mm_) {
                break;
            }
            use(slab, count);
        }
        return count;
    }

    Array<Slab> write(const StepHeights& heights) const {
        Array<Slab> slabs(context_.memory);
        slabs.resize_discarding(walk(heights, [](const Slab&, std::size_t) {}));
        walk(heights, [&](const Slab& slab, std::size_t i) { slabs[i] = slab; });
        return slabs;
    }

    const AdaptiveOptions& options_;
    const HeightLimits limits_;
    const Parallel parallel_;
    const Context& context_;
    std::vector<PlacedMesh> meshes_;
    bool in_parts_ = false;
    StepScale scale_{};
    double high_mm_ = 0;
    std::uint32_t steps_ = 0;
};

}  // namespace

Result<Array<Slab>> adaptive_layers(const Source& mesh, const AdaptiveOptions& options, const Context& context) noexcept {
    return guarded(context, [&]() -> Result<Array<Slab>> { return AdaptiveHeights(mesh, options, context).find(); });
}

}  // namespace lamella
