#include "outputs/outputs.hpp"

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <set>

#include "files/flags.hpp"
#include "files/mesh_input.hpp"
#include "lamella/io/layer_file.hpp"
#include "lamella/medical.hpp"
#include "terminal/console.hpp"

namespace lamella::cli {

namespace {

struct NamedFormat {
    std::string_view name;  ///< for --to
    std::string_view end;   ///< of a file's name
    OutputFormat format;
};

/// Beside files of layers. Longer ends before those that they end in.
constexpr std::array<NamedFormat, 11> own_formats = {{
    {"nii.gz", ".nii.gz", OutputFormat::mask},
    {"nii", ".nii", OutputFormat::mask},
    {"seg.nrrd", ".seg.nrrd", OutputFormat::mask},
    {"nrrd", ".nrrd", OutputFormat::mask},
    {"mha", ".mha", OutputFormat::mask},
    {"seg.dcm", ".seg.dcm", OutputFormat::segmentation},
    {"rtstruct", ".dcm", OutputFormat::structure_set},
    {"csv", ".csv", OutputFormat::table},
    {"jsonl", ".jsonl", OutputFormat::table},
    {"png", ".png", OutputFormat::png},
    {"h5", ".h5", OutputFormat::hdf5},
}};

const std::vector<NamedFormat>& formats() {
    static const std::vector<NamedFormat> all = [] {
        std::vector<NamedFormat> named;
        for (const LayerFormat& format : layer_formats()) {
            named.push_back({format.name, format.ending, OutputFormat::layers});
        }
        named.insert(named.end(), own_formats.begin(), own_formats.end());
        return named;
    }();
    return all;
}

std::string all_formats(std::string_view NamedFormat::*member) {
    std::vector<std::string_view> all;
    for (const NamedFormat& format : formats()) {
        if (std::find(all.begin(), all.end(), format.*member) == all.end()) {  // two formats may share an end
            all.push_back(format.*member);
        }
    }
    return joined(all);
}

/// Null where the name ends as none does.
const NamedFormat* format_by_end(const std::string& path) {
    const std::string name = lower_case(path);
    for (const NamedFormat& format : formats()) {
        if (name.ends_with(format.end)) {
            return &format;
        }
    }
    return nullptr;
}

PlannedOutput planned_as(const std::string& path, const NamedFormat& format) {
    return {path, format.format, format.format == OutputFormat::layers ? format.name : std::string_view()};
}

/// The name without the end that tells its format.
std::string without_format_end(const std::string& path) {
    const NamedFormat* const format = format_by_end(path);
    return path.substr(0, path.size() - (format == nullptr ? 0 : format->end.size()));
}

constexpr const char* labels_end = ".labels.csv";
constexpr std::int64_t end_of_9999 = 253'402'300'799;  ///< DICOM writes four digits

}  // namespace

void declare_outputs(CLI::App& command, OutputArguments& arguments) {
    static constexpr std::array<std::string_view, 2> holes = {"keyhole", "xor"};
    add_text(command, "-o,--output", arguments.outputs, "FILE|-",
             "File to write, by the end of its name: " + all_formats(&NamedFormat::end) +
                 "; repeatable; - for SVG on standard output");
    add_text(command, "--to", arguments.to, "FORMAT,...",
             "Write these formats, each as --output with the end of its name exchanged: " + all_formats(&NamedFormat::name));
    command.add_flag("--coverage", arguments.coverage, "Masks hold the share of each voxel's area that is inside");
    command.add_flag("--islands", arguments.islands, "Tables have a row an island, not a row a layer");
    add_count(command, "--picture-layer", "PNG shows this layer, counted from 0, not a contact sheet",
              [&arguments](std::uint64_t layer) { arguments.picture_layer = layer; });
    add_choice(command, "--holes", holes,
               "Holes in a structure set: joined to their contour, or contours that exclude one another (keyhole)",
               [&arguments](std::size_t i) { arguments.holes = static_cast<HoleForm>(i); });
    command.add_flag("--without-ct", arguments.without_ct, "Write a structure set or a segmentation that refers to no CT");
    command.add_flag("--leave-out", arguments.leave_out,
                     "Leave open contours out, with their count, where a file of layers cannot hold them");
    add_text(command, "--label-table", arguments.label_table, "FILE",
             "Names, colours and codes of the meshes' labels: CSV with label, name, color, category, type, region");
    declare_screen(command, arguments.screen);
    command.add_flag("--strict", arguments.strict, "Fail where a slice has open contours, of which no area is known");
}

void declare_like(CLI::App& command, ImageArguments& arguments, const std::string& help) {
    add_text(command, "--like", arguments.like, "IMAGE", help);
    add_text(command, "--series", arguments.of_like.series_uid, "UID",
             "Of the DICOM series in the folder of --like take this one, by its SeriesInstanceUID")
        ->needs("--like");
}

void declare_image(CLI::App& command, ImageArguments& arguments) {
    static constexpr std::array<std::string_view, 2> frames = {"lps", "ras"};
    declare_like(command, arguments,
                 "Cut at the slices of this image: NIfTI, NRRD, MetaImage, or a folder with a DICOM series");
    const auto take_spacing = [&arguments](const std::array<double, 3>& mm) {
        arguments.spacing = mm;
        const Result<ImageGeometry> voxels = geometry_around(Box{}, mm);
        return voxels ? std::string() : ": " + voxels.error().message;
    };
    add_triple(command, "--spacing", "Cut for voxels of this size in mm around the mesh, along left, posterior, superior",
               take_spacing)
        ->excludes("--like");
    add_choice(command, "--frame", frames, "Patient frame of meshes that do not state one",
               [&arguments](std::size_t i) { arguments.frame = i == 0 ? PatientFrame::lps : PatientFrame::ras; });
    add(command, "--subslices", arguments.subslices, "N", "Masks hold the mean share over N planes a slice (1: off)")
        ->check(CLI::Range(1, 1000));
}

bool PlannedOutput::on_screen() const noexcept {
    const auto known = layer_formats();
    const auto is_own = [this](const LayerFormat& one) { return one.name == layer_format && one.on_screen; };
    return format == OutputFormat::layers && std::any_of(known.begin(), known.end(), is_own);
}

std::vector<std::string> PlannedOutput::files(bool several_meshes) const {
    std::vector<std::string> all = {path};
    if (lower_case(path).ends_with(".csv")) {
        all.push_back(without_format_end(path) + ".meshes.csv");
    }
    if (format == OutputFormat::mask && several_meshes && !lower_case(path).ends_with(".seg.nrrd")) {
        all.push_back(without_format_end(path) + labels_end);
    }
    if (has_record()) {
        all.push_back(record_path());
    }
    return all;
}

std::vector<PlannedOutput> planned_outputs(const OutputArguments& arguments) {
    const std::vector<std::string>& outputs = arguments.outputs;
    std::vector<PlannedOutput> planned;
    if (arguments.to.empty()) {
        for (const std::string& path : outputs) {
            const NamedFormat* const format = format_by_end(path);
            if (format == nullptr) {
                require_extension(path, "--output", all_formats(&NamedFormat::end) + arguments.besides);
            }
            planned.push_back(format == nullptr ? PlannedOutput{path} : planned_as(path, *format));
        }
        return planned;
    }
    refuse_if(outputs.size() != 1 || is_standard(outputs.front()), bad_usage,
              "--to: needs one --output, a file, whose name the formats share");
    for (const std::string_view word : split(arguments.to, ',')) {
        const std::string name = lower_case(word);
        const auto format =
            std::find_if(formats().begin(), formats().end(), [&](const NamedFormat& known) { return known.name == name; });
        refuse_if(format == formats().end(), bad_usage,
                  "--to: '" + name + "' is not one of " + all_formats(&NamedFormat::name));
        const std::string path = without_format_end(outputs.front()) + std::string(format->end);
        for (const PlannedOutput& other : planned) {
            refuse_if(other.path == path, bad_usage, "--to: '" + name + "' stands there twice");
        }
        planned.push_back(planned_as(path, *format));
    }
    return planned;
}

bool has_format(const std::vector<PlannedOutput>& outputs, OutputFormat format) {
    return std::any_of(outputs.begin(), outputs.end(), [&](const PlannedOutput& output) { return output.format == format; });
}

std::optional<std::int64_t> source_date() {
    const char* const text = std::getenv("SOURCE_DATE_EPOCH");  // NOLINT(concurrency-mt-unsafe): nothing sets it
    if (text == nullptr || *text == '\0') {
        return std::nullopt;
    }
    std::int64_t seconds = 0;
    refuse_if(!read_integer(std::string_view(text), seconds) || seconds < 0 || seconds > end_of_9999, bad_usage,
              "SOURCE_DATE_EPOCH: '" + std::string(text) + "' is not a number of seconds since 1970, before the year 10000");
    return seconds;
}

void require_together(const std::vector<PlannedOutput>& outputs, const OutputArguments& arguments, std::size_t meshes,
                      const ImageArguments& image) {
    const std::optional<Screen> screen = arguments.screen.screen();
    refuse_if(screen && std::none_of(outputs.begin(), outputs.end(), std::mem_fn(&PlannedOutput::on_screen)), bad_usage,
              "--screen: no output is of SL1 or a zip of PNGs");
    refuse_if(arguments.leave_out && !has_format(outputs, OutputFormat::layers), bad_usage,
              "--leave-out: no output is a file of layers");
    bool mask = false;
    bool dicom = false;
    for (const PlannedOutput& output : outputs) {
        const auto refuse = [&](bool wrong, const std::string& what) {
            refuse_if(wrong, bad_usage, "--output: '" + output.path + "'" + what);
        };
        const bool set = output.format == OutputFormat::structure_set;
        mask = mask || output.is_mask();
        dicom = dicom || output.is_dicom();
        refuse(output.format == OutputFormat::png && !can_write_pictures(), ": this build is without PNG (libpng-dev)");
        refuse(output.format == OutputFormat::hdf5 && !has_archives(), ": this build has no HDF5");
        refuse(output.is_dicom() && !image.given(),
               " needs --like FOLDER, the CT" + when(arguments.without_ct, ", or --spacing X,Y,Z"));
        refuse(set && image.subslices > 1, ": its contours lie on the slices themselves, not with --subslices");
        refuse(output.one_mesh() && meshes > 1 && !(arguments.objects && output.format == OutputFormat::layers),
               " takes one mesh, not several");
        refuse(output.on_screen() && !screen, " needs --screen, a printer (see lamella screens) or WxH with --pixel");
        refuse(output.is_mask() && !image.given(), " needs --like IMAGE or --spacing X,Y,Z");
    }
    refuse_if(arguments.picture_layer && !has_format(outputs, OutputFormat::png), bad_usage,
              "--picture-layer: no output is a PNG");
    const bool any_set = has_format(outputs, OutputFormat::structure_set);
    refuse_if((!dicom && arguments.without_ct) || (!any_set && arguments.holes), bad_usage,
              "--holes and --without-ct: no output is a structure set");
    if (dicom) {
        (void)source_date();
    }
    refuse_if((arguments.coverage || image.subslices > 1) && has_format(outputs, OutputFormat::mask) && meshes > 1,
              bad_usage, "--coverage and --subslices: one mesh a mask, not several");
    refuse_if(image.subslices > 1 && !image.given(), bad_usage, "--subslices: needs --like IMAGE or --spacing X,Y,Z");
    refuse_if(arguments.coverage && !mask, bad_usage, "--coverage: no output is a mask");
    refuse_if(arguments.islands && !has_format(outputs, OutputFormat::table), bad_usage, "--islands: no output is a table");
}

std::vector<PlannedOutput> plan_outputs(const OutputArguments& arguments, std::size_t meshes, const ImageArguments& image,
                                        FilePlan& files) {
    for (const std::string& output : arguments.outputs) {  // as they were typed, before what their ends say
        require_writable(output);
        files.require_free(output, "--output");
    }
    std::vector<PlannedOutput> outputs = planned_outputs(arguments);
    require_together(outputs, arguments, meshes, image);
    (void)label_rows(arguments, std::numeric_limits<std::size_t>::max());  // parts of a mesh are counted later
    std::set<std::string> tables;                                          // of labels: masks of one name share one
    for (const PlannedOutput& output : outputs) {
        require_writable(output.path);
        for (const std::string& file : output.files(meshes > 1)) {
            if (!file.ends_with(labels_end) || tables.insert(file).second) {
                files.writes(file, "--output", "another output");
            }
        }
    }
    return outputs;
}

std::vector<std::string> files_of(const std::vector<PlannedOutput>& outputs, bool several_meshes) {
    std::vector<std::string> all;
    for (const PlannedOutput& output : outputs) {
        const std::vector<std::string> files = output.files(several_meshes);
        all.insert(all.end(), files.begin(), files.end());
    }
    return all;
}

std::vector<LabelRow> label_rows(const OutputArguments& arguments, std::size_t meshes) {
    if (arguments.label_table.empty()) {
        return {};
    }
    std::vector<LabelRow> rows = done_or_thrown(read_label_table(path_of(arguments.label_table)));
    for (const LabelRow& row : rows) {
        refuse_if(row.label > meshes, bad_input,
                  arguments.label_table + ": has a row for label " + std::to_string(row.label) + " of " +
                      counted(meshes, "mesh", "meshes"));
    }
    return rows;
}

void require_image_serves(const ImageGeometry& image, const std::vector<PlannedOutput>& outputs,
                          const OutputArguments& arguments) {
    for (const PlannedOutput& output : outputs) {
        refuse_if(output.format == OutputFormat::mask && !image.uneven_slices_mm.empty(), bad_input,
                  "'" + output.path + "': the slices of the image are not evenly spaced (" + image.uneven_words() +
                      "), and a mask holds even ones only");
        refuse_if(output.is_dicom() && !image.series && !arguments.without_ct, bad_input,
                  "'" + output.path + "': " + (output.is_mask() ? "a segmentation" : "a structure set") +
                      " is drawn on the slices of a CT: --like FOLDER "
                      "with a DICOM series, or --without-ct");
    }
}

void add_series(const ImageGeometry& image, FilePlan& files) {
    for (const DicomSeries::Instance& slice : image.series ? image.series->slices : std::vector<DicomSeries::Instance>()) {
        files.reads(slice.file, "a slice of --like");
    }
}

void require_overlap(const ImageGeometry& image, const std::string& name, const Box& mesh) {
    static constexpr std::array<const char*, 3> names = {"its rows", "its columns", "its slices' normal"};
    const auto range_text = [](double from, double to) { return rounded(from, 3) + " to " + rounded(to, 3) + " mm"; };
    const std::vector<double> heights = image.slice_heights_mm();
    const auto [lowest, highest] = std::minmax_element(heights.begin(), heights.end());
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double side = image.spacing_mm[axis];
        const double shear = axis == 2 ? 0 : image.shear_mm[axis] * static_cast<double>(image.size[2] - 1);
        const double low = (axis == 2 ? *lowest : std::min(shear, 0.0)) - side / 2;
        const double high =
            (axis == 2 ? *highest : static_cast<double>(image.size[axis] - 1) * side + std::max(shear, 0.0)) + side / 2;
        refuse_if(mesh.max_mm[axis] < low || mesh.min_mm[axis] > high, bad_input,
                  name + ": lies outside of the image: along " + names[axis] + " the mesh reaches from " +
                      range_text(mesh.min_mm[axis], mesh.max_mm[axis]) + ", the image from " + range_text(low, high) +
                      "; is the patient frame right?");
    }
}

}  // namespace lamella::cli
