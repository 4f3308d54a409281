#include "outputs/output_formats.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <string_view>
#include <system_error>

#include "files/mesh_input.hpp"
#include "files/streams.hpp"
#include "files/text_input.hpp"
#include "terminal/failure.hpp"

namespace lamella::cli {

namespace {

struct NamedFormat {
    std::string_view name;  ///< for --to
    std::string_view end;   ///< of a file's name
    OutputFormat format;
};

/// Longer ends before those that they end in.
constexpr std::array<NamedFormat, 10> formats = {{
    {"svg", ".svg", OutputFormat::svg},
    {"nii.gz", ".nii.gz", OutputFormat::nifti_gz},
    {"nii", ".nii", OutputFormat::nifti},
    {"seg.nrrd", ".seg.nrrd", OutputFormat::segmentation},
    {"nrrd", ".nrrd", OutputFormat::nrrd},
    {"rtstruct", ".dcm", OutputFormat::structure_set},
    {"csv", ".csv", OutputFormat::csv},
    {"jsonl", ".jsonl", OutputFormat::json_lines},
    {"png", ".png", OutputFormat::png},
    {"h5", ".h5", OutputFormat::hdf5},
}};

std::string joined(std::string_view NamedFormat::*member) {
    std::string all;
    for (const NamedFormat& format : formats) {
        all.append(all.empty() ? "" : ", ").append(format.*member);
    }
    return all;
}

const NamedFormat* format_by_end(const std::string& path) {
    const std::string name = lower_case(path);
    const auto* const found =
        std::find_if(formats.begin(), formats.end(), [&](const NamedFormat& format) { return name.ends_with(format.end); });
    return found == formats.end() ? nullptr : found;
}

PlannedOutput by_name(const std::string& path) {
    if (const NamedFormat* format = format_by_end(path)) {
        return {path, format->format};
    }
    const std::string own = lower_case(std::filesystem::path(path).extension().string());
    std::error_code unknown;
    if (own.empty() || is_standard(path) || std::filesystem::is_other(path, unknown)) {
        return {path, OutputFormat::svg};
    }
    throw Failure(bad_usage, "--output: '" + path + "': no format that is written ends in " + own + "; there is " +
                                 output_format_ends());
}

std::vector<const NamedFormat*> parse_formats(const std::string& to) {
    std::vector<const NamedFormat*> found;
    for (const std::string_view word : split(to, ',')) {
        const std::string name = lower_case(std::string(word));
        const auto* const format =
            std::find_if(formats.begin(), formats.end(), [&](const NamedFormat& known) { return known.name == name; });
        if (format == formats.end()) {
            throw Failure(bad_usage, "--to: '" + name + "' is not one of " + output_format_names());
        }
        if (std::find(found.begin(), found.end(), format) != found.end()) {
            throw Failure(bad_usage, "--to: '" + name + "' stands there twice");
        }
        found.push_back(format);
    }
    return found;
}

}  // namespace

bool PlannedOutput::is_mask() const noexcept {
    return format == OutputFormat::nifti || format == OutputFormat::nifti_gz || format == OutputFormat::nrrd ||
           format == OutputFormat::segmentation;
}

std::vector<std::string> PlannedOutput::files(bool several_meshes) const {
    std::vector<std::string> all = {path};
    if (format == OutputFormat::csv) {
        all.push_back(without_format_end(path) + ".meshes.csv");
    }
    if (is_mask() && several_meshes) {
        all.push_back(without_format_end(path) + ".labels.csv");
    }
    if (has_record()) {
        all.push_back(record_path());
    }
    return all;
}

std::string output_format_names() {
    return joined(&NamedFormat::name);
}

std::string output_format_ends() {
    return joined(&NamedFormat::end);
}

std::string without_format_end(const std::string& path) {
    const NamedFormat* const format = format_by_end(path);
    return format == nullptr ? path : path.substr(0, path.size() - format->end.size());
}

std::vector<PlannedOutput> planned_outputs(const std::vector<std::string>& outputs, const std::string& to) {
    std::vector<PlannedOutput> planned;
    if (to.empty()) {
        for (const std::string& path : outputs) {
            planned.push_back(by_name(path));
        }
        return planned;
    }
    if (outputs.size() != 1 || is_standard(outputs.front())) {
        throw Failure(bad_usage, "--to: needs one --output, a file, whose name the formats share");
    }
    for (const NamedFormat* format : parse_formats(to)) {
        planned.push_back({without_format_end(outputs.front()) + std::string(format->end), format->format});
    }
    return planned;
}

}  // namespace lamella::cli
