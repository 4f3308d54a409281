#include "slice/range_slicing.hpp"

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include "files/standard_streams.hpp"
#include "terminal/failure.hpp"
#include "terminal/numbers.hpp"

namespace lamella::cli {

namespace {

/// Keeps what the summary tells of.
struct KeptLayers {
    std::vector<Layer> layers;
    std::vector<ClosedGap> gaps;
    std::atomic<bool> failed = false;

    void operator()(const LayerView& view) noexcept {
        try {
            layers.push_back(view.layer);
            gaps.insert(gaps.end(), view.closed_gaps.begin(), view.closed_gaps.end());
        } catch (...) {
            failed = true;
        }
    }
};

template <class T>
void copy_to(Array<T>& array, const std::vector<T>& from) {
    array.resize_discarding(from.size());
    std::copy(from.begin(), from.end(), array.begin());
}

/// $TMPDIR, else beside the output: the system's own folder is often held in memory.
std::filesystem::path temporary_folder(const SliceArguments& arguments) {
    const char* const asked = std::getenv("TMPDIR");
    if ((asked != nullptr && *asked != 0) || arguments.outputs.outputs.empty() || arguments.output_to_stdout()) {
        std::error_code none;
        const std::filesystem::path folder = std::filesystem::temp_directory_path(none);
        return none ? std::filesystem::path(".") : folder;
    }
    const std::filesystem::path folder = std::filesystem::path(arguments.outputs.outputs.front()).parent_path();
    return folder.empty() ? "." : folder;
}

FileSliceOptions file_options(const SliceArguments& arguments) {
    FileSliceOptions options;
    options.mm_per_unit = parse_unit(arguments.unit.value_or("mm"), "--unit");
    options.memory_bytes = parse_bytes(arguments.memory, "--memory");
    options.temporary_folder = temporary_folder(arguments);
    options.hash = arguments.hash;
    return options;
}

std::string words_of(const FileSlice& file) {
    std::string text =
        "ranges    " + counted(file.ranges, "range") + " of layers within " + file_size_text(file.memory_bytes);
    if (file.spilled_bytes > 0) {
        text += ", " + file_size_text(file.spilled_bytes) + " by way of a temporary file";
    }
    return text + "\n";
}

Result<SliceResult> keep_layers(const std::filesystem::path& path, const FileSliceOptions& options, ToolRun& run) {
    KeptLayers kept;
    Result<FileSlice> file = slice_file(path, LayerSink::to(kept, SinkOrder::ascending), options);
    if (!file || kept.failed) {
        return file ? Error{ErrorCode::out_of_memory, "out of memory"} : file.error();
    }
    SliceResult result;
    copy_to(result.layers, kept.layers);
    copy_to(result.closed_gaps, kept.gaps);
    result.first_layer = file->totals.first_layer;
    result.all_layers = file->totals.all_layers;
    result.region = options.slice.region;
    result.close_gaps_mm = options.slice.close_gaps_mm;
    result.gap_sense = options.slice.gap_sense;
    result.unit_mm = file->totals.unit_mm;
    result.frame = options.slice.transform;
    result.plan = options.slice.plan;
    result.summary = file->totals.summary;
    run.contours = file->totals.contours;
    run.hash = file->hash;
    run.ranges = words_of(*file);
    return result;
}

}  // namespace

void require_ranges_possible(const SliceArguments& arguments) {
    if (arguments.memory.empty()) {
        return;
    }
    (void)parse_bytes(arguments.memory, "--memory");
    if (!arguments.report.empty()) {
        throw Failure(bad_usage, "--memory: --report looks at the whole mesh, which is not held");
    }
    for (const std::string& mesh : arguments.meshes) {
        if (is_standard(mesh)) {
            throw Failure(bad_usage, "--memory: standard input cannot be read twice; write it to a file first");
        }
    }
}

MeshFile describe_mesh_of(const SliceArguments& arguments) {
    Result<MeshFile> mesh = describe_file(arguments.mesh, file_options(arguments));
    if (!mesh) {
        throw failure_of(mesh.error());
    }
    return std::move(mesh).value();
}

Result<SliceResult> slice_in_ranges(const SliceArguments& arguments, const SliceOptions& options, bool collect,
                                    ToolRun& run) {
    FileSliceOptions in_file = file_options(arguments);
    in_file.slice = options;
    if (!collect) {
        return keep_layers(arguments.mesh, in_file, run);
    }
    Result<CollectedFileSlice> collected = slice_file(arguments.mesh, in_file);
    if (!collected) {
        return collected.error();
    }
    run.hash = collected->file.hash;
    run.ranges = words_of(collected->file);
    return std::move(collected->result);
}

}  // namespace lamella::cli
