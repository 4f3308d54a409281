#include "outputs/write_archive_output.hpp"

#include "terminal/failure.hpp"

namespace lamella::cli {

void require_archive_possible(const std::vector<PlannedOutput>& outputs) {
    for (const PlannedOutput& output : outputs) {
        if (output.format == OutputFormat::hdf5 && !has_archives()) {
            throw Failure(bad_usage, "--output: '" + output.path + "': this build has no HDF5");
        }
    }
}

void write_archive_output(const OutputJob& job, const PlannedOutput& output, const Control& control) {
    const SlicedPart& part = job.parts.front();
    ArchiveInfo info{.name = part.name,
                     .mesh_sha256 = part.mesh_sha256,
                     .frame = part.frame,
                     .geometry = job.image,
                     .subslices = job.subslices};
    if (part.welded) {
        info.weld = ArchiveWeld{part.welded->tolerance_mm, part.welded->joined};
    }
    done_or_thrown(write_archive(part.result, info, output.path, control));
}

}  // namespace lamella::cli
