#include "slice/image_around.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "lamella/io.hpp"
#include "lamella/lamella.hpp"
#include "slice/range_slicing.hpp"
#include "terminal/failure.hpp"
#include "terminal/numbers.hpp"

namespace lamella::cli {

namespace {

struct Box {
    std::array<double, 3> min_mm{};
    std::array<double, 3> max_mm{};
};

SliceSummary summary_of(const MeshFile& file, const std::string& name, const SliceArguments& arguments,
                        const SliceOptions& options) {
    if (!arguments.memory.empty()) {
        return outline_within_memory(name, arguments, options).facts.summary;
    }
    return done_or_thrown(slice(file, options)).summary;
}

/// In LPS.
Box box_of(const MeshFile& file, const std::string& name, const SliceArguments& arguments) {
    SliceOptions options = options_of(arguments);
    options.plan.spacing = ExplicitPlanes{{0}};
    options.layers = {};
    options.transform = ImageGeometry{}.slicing_frame(patient_frame_of(file, arguments.image, name));
    const SliceSummary summary = summary_of(file, name, arguments, options);
    Box box;
    std::copy_n(summary.min_mm, 3, box.min_mm.begin());
    std::copy_n(summary.max_mm, 3, box.max_mm.begin());
    return box;
}

}  // namespace

ImageGeometry image_around(const std::vector<MeshFile>& files, const SliceArguments& arguments) {
    const std::vector<double> spacing = parse_triple(arguments.image.spacing, "--spacing");
    Box all;
    for (std::size_t i = 0; i < files.size(); ++i) {
        const Box box = box_of(files[i], arguments.meshes[i], arguments);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            all.min_mm[axis] = i == 0 ? box.min_mm[axis] : std::min(all.min_mm[axis], box.min_mm[axis]);
            all.max_mm[axis] = i == 0 ? box.max_mm[axis] : std::max(all.max_mm[axis], box.max_mm[axis]);
        }
    }
    return done_or_thrown(geometry_around(all.min_mm, all.max_mm, {spacing[0], spacing[1], spacing[2]}));
}

}  // namespace lamella::cli
