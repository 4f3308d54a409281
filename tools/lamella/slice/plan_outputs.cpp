#include "slice/plan_outputs.hpp"

#include <cstddef>
#include <string>
#include <utility>

#include "files/output_path.hpp"
#include "outputs/write_outputs.hpp"
#include "terminal/failure.hpp"

namespace lamella::cli {

namespace {

/// No mesh, and no file that another option names.
void require_no_input(const std::string& file, const SliceArguments& arguments, const std::string& option) {
    for (const std::string& mesh : arguments.meshes) {
        require_different(file, mesh, option, "the mesh");
    }
    for (const auto& [name, path] : {std::pair{"--like", &arguments.image.like},
                                     {"--transform", &arguments.transform},
                                     {"--planes", &arguments.planes}}) {
        if (!path->empty()) {
            require_different(file, *path, option, std::string("the file of ") + name);
        }
    }
}

void require_report_possible(const SliceArguments& arguments, const std::vector<std::filesystem::path>& outputs) {
    if (arguments.report.empty()) {
        return;
    }
    if (!arguments.layers.empty()) {
        throw Failure(bad_usage, "--report: not with --layers, as it judges the whole mesh");
    }
    if (arguments.mesh_count() > 1) {
        throw Failure(bad_usage, "--report: one mesh a report, not several");
    }
    require_writable(arguments.report);
    require_no_input(arguments.report, arguments, "--report");
    for (const std::filesystem::path& output : outputs) {
        require_different_output(arguments.report, output.string(), "--report", "--output");
    }
}

std::vector<std::filesystem::path> files_of(const SliceArguments& arguments, const std::vector<PlannedOutput>& outputs) {
    std::vector<std::filesystem::path> files;
    for (const PlannedOutput& output : outputs) {
        for (const std::string& file : output.files(arguments.mesh_count() > 1)) {
            files.emplace_back(file);
        }
    }
    return files;
}

}  // namespace

std::vector<PlannedOutput> planned_outputs_of(const SliceArguments& arguments) {
    const OutputArguments& wanted = arguments.outputs;
    for (const std::string& output : wanted.outputs) {
        require_writable(output);
        require_no_input(output, arguments, "--output");
    }
    std::vector<PlannedOutput> outputs;
    if (!wanted.outputs.empty() || !wanted.to.empty()) {
        outputs = planned_outputs(wanted.outputs, wanted.to);
    }
    require_possible(outputs, wanted, arguments.mesh_count(), arguments.image.given(), arguments.image.subslices);
    const std::vector<std::filesystem::path> files = files_of(arguments, outputs);
    for (const std::filesystem::path& file : files) {
        require_no_input(file.string(), arguments, "--output");
    }
    require_report_possible(arguments, files);
    return outputs;
}

std::vector<std::filesystem::path> files_to_write(const SliceArguments& arguments,
                                                  const std::vector<PlannedOutput>& outputs) {
    std::vector<std::filesystem::path> files = files_of(arguments, outputs);
    files.emplace_back(arguments.report);
    return files;
}

}  // namespace lamella::cli
