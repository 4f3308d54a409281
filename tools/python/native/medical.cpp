// What the lab needs beside slices: geometries of images, masks, structure sets, tables, archives, pictures.
#include <pybind11/stl.h>

#include <filesystem>

#include "lamella/medical.hpp"
#include "native.hpp"

namespace lamella::python {

namespace {

using Path = std::filesystem::path;

/// Results and their names: a list of (Result, name, ...).
template <class Row, class Make>
std::vector<Row> rows_of(const py::list& parts, const Make& make) {
    std::vector<Row> rows;
    for (const py::handle part : parts) {
        const auto pair = part.cast<py::tuple>();
        rows.push_back(make(pair[0].cast<const HeldResult&>().result, pair[1].cast<std::string>(), pair));
    }
    return rows;
}

template <class Numbers>
py::array_t<double> numbers_of(const Numbers& numbers) {
    return py::array_t<double>(static_cast<py::ssize_t>(numbers.size()), numbers.data());
}

ImageGeometry make_geometry(const std::array<std::uint64_t, 3>& size, const std::array<double, 3>& spacing_mm,
                            const std::array<double, 3>& origin_mm, const std::array<std::array<double, 3>, 3>& axes,
                            const std::array<double, 2>& shear_mm) {
    ImageGeometry image;
    image.size = size;
    image.spacing_mm = spacing_mm;
    image.origin_mm = origin_mm;
    image.axes = axes;
    image.shear_mm = shear_mm;
    return image;
}

py::array_t<double> frame_of(const ImageGeometry& image, bool is_ras) {
    return py::array_t<double>({3, 4}, image.slicing_frame(is_ras ? PatientFrame::ras : PatientFrame::lps).m.data());
}

py::dict dict_of(const MaskSummary& summary) {
    py::list open;
    for (const OpenLayers& each : summary.open) {
        open.append(each.layers == 0 ? py::object(py::none()) : py::object(text_of(describe(each, "stitch="))));
    }
    return py::dict("voxels"_a = summary.voxels, "overlaps"_a = summary.overlapped_voxels, "open"_a = open,
                    "cut_off"_a = summary.cut_off_share);
}

std::vector<MaskPart> mask_parts(const py::list& parts) {
    return rows_of<MaskPart>(parts, [](const SliceResult& result, std::string name, const py::tuple& row) {
        return MaskPart{&result, std::move(name), row[2].cast<SegmentTerms>()};
    });
}

py::dict write_segments(const py::list& parts, const ImageGeometry& image, const std::string& path, bool coverage,
                        int subslices, bool without_ct, std::optional<std::int64_t> seconds, const Asked& asked) {
    const std::vector<MaskPart> rows = mask_parts(parts);
    const SegmentationSummary written = run(asked, [&](const Context& context) {
        return write_segmentation(
            rows, image, Path(path),
            {.coverage = coverage, .subslices = subslices, .without_ct = without_ct, .seconds_since_1970 = seconds},
            context);
    });
    return dict_of(written.mask);
}

py::list read_labels(const std::string& path) {
    const std::vector<LabelRow> rows = run([&](const Context& /*lent*/) { return read_label_table(Path(path)); });
    py::list listed;
    for (const LabelRow& row : rows) {
        listed.append(py::make_tuple(row.label, text_of(row.name), row.terms));
    }
    return listed;
}

/// `voxels`: bytes of the image from `first_slice` on, written in place.
py::dict draw(const py::list& parts, const ImageGeometry& image, py::array voxels, bool coverage, int subslices,
              std::uint64_t first_slice, const Asked& asked) {
    const std::vector<MaskPart> rows = mask_parts(parts);
    const std::span<unsigned char> bytes(static_cast<unsigned char*>(voxels.mutable_data()),
                                         static_cast<std::size_t>(voxels.nbytes()));
    return dict_of(run(asked, [&](const Context& context) {
        return draw_mask(rows, image, bytes, {coverage, subslices, first_slice}, context);
    }));
}

py::dict write(const py::list& parts, const ImageGeometry& image, const std::string& path, bool coverage, int subslices,
               const Asked& asked) {
    const std::vector<MaskPart> rows = mask_parts(parts);
    return dict_of(run(asked, [&](const Context& context) {
        return write_mask(rows, image, Path(path), {coverage, subslices}, context);
    }));
}

py::list write_set(const py::list& parts, const ImageGeometry& image, const std::string& path, int holes, bool without_ct,
                   std::optional<std::int64_t> seconds, const Asked& asked) {
    const std::vector<Roi> rois = rows_of<Roi>(parts, [](const SliceResult& result, std::string name, const py::tuple& row) {
        return Roi{&result, std::move(name), row[2].cast<SegmentTerms>().colour_of(row[3].cast<std::size_t>())};
    });
    const StructureSetSummary summary = run(asked, [&](const Context& context) {
        return write_structure_set(
            rois, image, Path(path),
            {.holes = static_cast<HoleForm>(holes), .without_ct = without_ct, .seconds_since_1970 = seconds}, context);
    });
    py::list names;
    for (const std::string& name : summary.roi_names) {
        names.append(text_of(name));
    }
    return names;
}

void write_table(const py::list& parts, const std::string& path, bool islands, const Asked& asked) {
    const auto rows = rows_of<TablePart>(parts, [](const SliceResult& result, std::string name, const py::tuple&) {
        return TablePart{.result = &result, .name = std::move(name)};
    });
    run(asked, [&](const Context& context) { return write_layer_table(rows, Path(path), nullptr, islands, context); });
}

void write_sheet(const py::list& parts, const std::string& path, const Asked& asked) {
    const auto rows = rows_of<PicturePart>(parts, [](const SliceResult& result, std::string name, const py::tuple&) {
        return PicturePart{&result, std::move(name)};
    });
    run(asked, [&](const Context& context) { return write_contact_sheet(rows, Path(path), {}, context); });
}

void write_hdf5(const HeldResult& held, const std::string& name, const std::string& path, bool measures,
                const Asked& asked) {
    const ArchiveInfo info{.name = name, .measures = measures};
    run(asked, [&](const Context& context) { return write_archive(held.result, info, Path(path), context); });
}

HeldResult read_hdf5(const std::string& path, const Asked& asked) {
    return HeldResult(run(asked, [&](const Context& context) { return read_archive(Path(path), context); }).result);
}

}  // namespace

void define_medical(py::module_& module) {
    py::class_<ImageGeometry>(module, "Geometry")
        .def(py::init(&make_geometry))
        .def_readonly("size", &ImageGeometry::size)
        .def_readonly("spacing", &ImageGeometry::spacing_mm)
        .def_readonly("origin", &ImageGeometry::origin_mm)
        .def_property_readonly("steps", &ImageGeometry::steps_mm)
        .def_property_readonly("sheared", &ImageGeometry::is_sheared)
        .def_readonly("warnings", &ImageGeometry::warnings)
        .def_property_readonly("uneven", [](const ImageGeometry& image) { return numbers_of(image.uneven_slices_mm); })
        .def_property_readonly("series",
                               [](const ImageGeometry& image) {
                                   return image.series ? py::object(text_of(image.series->series_uid)) : py::none();
                               })
        .def("slicing_frame", &frame_of)
        .def("slice_heights",
             [](const ImageGeometry& image, int subslices) { return numbers_of(image.slice_heights_mm(subslices)); });
    module.def("read_geometry", [](const std::string& path, const std::string& series) {
        return run([&](const Context& /*lent*/) { return read_image_geometry(Path(path), {.series_uid = series}); });
    });
    module.def("list_series", [](const std::string& folder, const Asked& asked) {
        py::list rows;
        const auto found = run(asked, [&](const Context& context) { return list_series(Path(folder), context); });
        for (const DicomSeriesInfo& series : found) {
            rows.append(py::make_tuple(text_of(series.uid), text_of(series.modality), text_of(series.description),
                                       series.files, text_of(series.refusal)));
        }
        return rows;
    });
    module.def("geometry_around", [](const std::array<double, 3>& low, const std::array<double, 3>& high,
                                     const std::array<double, 3>& spacing_mm) {
        return run([&](const Context& /*lent*/) { return geometry_around(Box{low, high}, spacing_mm); });
    });
    py::class_<SegmentTerms>(module, "Terms").def(py::init<>()).def("color", &SegmentTerms::colour_of);
    module.def("read_labels", &read_labels);
    module.def("write_segmentation", &write_segments);
    module.def("draw_mask", &draw);
    module.def("write_mask", &write);
    module.def("write_structure_set", &write_set);
    module.def("write_table", &write_table);
    module.def("write_contact_sheet", &write_sheet);
    module.def("write_archive", &write_hdf5);
    module.def("read_archive", &read_hdf5);
}

}  // namespace lamella::python
