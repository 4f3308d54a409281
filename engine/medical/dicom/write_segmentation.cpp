#include "lamella/medical/segmentation.hpp"

#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "io/write/output_file.hpp"
#include "lamella/version.hpp"
#include "medical/dicom/cielab.hpp"
#include "medical/dicom/data_set.hpp"
#include "medical/dicom/identity.hpp"
#include "medical/dicom/segment_raster.hpp"
#include "medical/geometry/common.hpp"

namespace lamella {

namespace {

constexpr std::string_view segmentation_storage = "1.2.840.10008.5.1.4.1.1.66.4";
constexpr std::uint64_t most_columns = 65535;
constexpr std::uint64_t most_pixel_bytes = 0xfffffffe;
constexpr dicom::Tag segment_identification = 0x0062000a;
constexpr dicom::Tag referenced_segment_number = 0x0062000b;

// --- the data set

/// SHA-256 over all that decides the bytes.
Sha256::Digest segmentation_content(std::span<const MaskPart> parts, const ImageGeometry& image,
                                    const SegmentationOptions& options, const Context& context) {
    ContentHash hash;
    hash.add(std::string_view(version), std::string_view("segmentation"), std::uint64_t{options.coverage},
             static_cast<std::uint64_t>(options.subslices), std::uint64_t{options.seconds_since_1970.has_value()},
             static_cast<std::uint64_t>(options.seconds_since_1970.value_or(0)));
    hash.add_image(image);
    hash.add(image.shear_mm);
    const PacedStop stop(context.stop);
    for (std::size_t i = 0; i < parts.size(); ++i) {
        stop.stop_if_asked();
        const SegmentTerms& terms = parts[i].terms;
        hash.add(parts[i].name, terms.colour_of(i));
        for (const Code& code : {terms.category, terms.type, terms.region}) {
            hash.add(code.scheme, code.value, code.meaning);
        }
        hash.add_contours(*parts[i].result);
    }
    return hash.digest();
}

bool names_are_ascii(std::span<const MaskPart> parts) {
    return std::all_of(parts.begin(), parts.end(), [](const MaskPart& part) {
        const SegmentTerms& terms = part.terms;
        return is_ascii(part.name + terms.category.meaning + terms.type.meaning + terms.region.meaning);
    });
}

/// What a segmentation says beside its pixels.
class SegmentationHeader {
public:
    /// Throws Refused (invalid_argument).
    SegmentationHeader(std::span<const MaskPart> parts, const ImageGeometry& image, const SegmentationOptions& options,
                       std::span<const SegmentFrame> frames, const Sha256::Digest& content)
        : parts_(parts),
          image_(image),
          frames_(frames),
          content_(content),
          identity_(image, content, segmentation_storage, "SEG", names_are_ascii(parts), options.seconds_since_1970),
          heights_(image.slice_heights_mm()),
          place_(image.size[2]) {
        for (const SegmentFrame& frame : frames) {
            place_[frame.slice] = 1;
        }
        std::uint32_t used = 0;
        for (std::uint32_t& place : place_) {
            place = place == 0 ? 0 : ++used;
        }
        std::vector<std::string> names;
        for (const MaskPart& part : parts) {
            names.push_back(part.name);
        }
        names_ = identity_.distinct(names);
        set_values();
    }

    const Identity& identity() const noexcept { return identity_; }
    const std::vector<std::string>& segment_names() const noexcept { return names_; }

    void write(OutputFile& file, bool shares) {
        put_values(0, 0x00081115);
        if (image_.series) {
            data_.put_items(0x00081115, 1, [&](std::size_t) { put_series(); });  // ReferencedSeriesSequence
        }
        put_values(0x00081115, 0x00209221);
        const std::string organization = uid_of(content_, "dimensions");
        data_.put_items(0x00209221, 1, [&](std::size_t) { data_.put_uid(0x00209164, organization); });
        put_dimensions(organization);
        put_pixel_format(shares);
        data_.put(0x00620001, shares ? "FRACTIONAL" : "BINARY");                             // SegmentationType
        data_.put_items(0x00620002, parts_.size(), [&](std::size_t i) { put_segment(i); });  // SegmentSequence
        if (shares) {
            data_.put_short(0x0062000e, 255);    // MaximumFractionalValue
            data_.put(0x00620010, "OCCUPANCY");  // SegmentationFractionalType
        }
        data_.put(0x00700080, "SEGMENTATION");  // ContentLabel
        data_.put(0x00700081, "");              // ContentDescription
        data_.put(0x00700084, "");              // ContentCreatorName
        data_.put_items(dicom::shared_groups, 1, [&](std::size_t) { put_shared(); });
        data_.put_items(dicom::per_frame_groups, frames_.size(), [&](std::size_t i) {
            file.append(data_.take());
            put_frame(frames_[i]);
        });
        const std::uint64_t voxels = image_.size[0] * image_.size[1] * frames_.size();
        const std::uint64_t bytes = shares ? voxels : (voxels + 7) / 8;
        data_.begin_value(0x7fe00010, static_cast<std::uint32_t>(bytes + bytes % 2));  // PixelData
        file.append(data_.take());
    }

private:
    void set_values() {
        std::map<dicom::Tag, std::string>& values = identity_.values;
        auto [date, time] = identity_.date_and_time;
        if (date.empty()) {
            const auto digits = [](std::string_view text) { return text.find_first_not_of("0123456789.") == text.npos; };
            const std::string& study_time = values[0x00080030];
            const bool is_date = values[0x00080020].size() == 8 && digits(values[0x00080020]);
            date = is_date ? values[0x00080020] : "19700101";
            time = is_date && study_time.size() >= 6 && digits(study_time) ? study_time.substr(0, 6) : "000000";
        }
        values[0x00080008] = "DERIVED\\PRIMARY";  // ImageType
        values[0x00080023] = date;                // ContentDate
        values[0x00080033] = time;                // ContentTime
        values[dicom::series_description] = "Segmentation";
        values[0x00181000] = "1";  // DeviceSerialNumber
        values[0x00200011] = "1";  // SeriesNumber
        values[0x00200013] = "1";  // InstanceNumber
    }

    /// Texts whose tags are in [begin, end).
    void put_values(dicom::Tag begin, dicom::Tag end) {
        const auto& values = identity_.values;
        for (auto value = values.lower_bound(begin); value != values.lower_bound(end); ++value) {
            data_.put(value->first, value->second);
        }
    }

    /// The series, and its files that frames name.
    void put_series() {
        std::map<std::string, std::string> classes;  // by instances, of which one may hold all slices
        for (std::size_t slice = 0; slice < place_.size(); ++slice) {
            if (const DicomSeries::Instance& of = image_.series->slices[slice]; place_[slice] != 0) {
                classes.emplace(of.sop_instance_uid, of.sop_class_uid);
            }
        }
        data_.put_sequence(0x0008114a, [&] {  // ReferencedInstanceSequence
            for (const auto& [instance_uid, class_uid] : classes) {
                data_.put_item([&, &instance = instance_uid, &of = class_uid] { put_reference(data_, of, instance); });
            }
        });
        data_.put_uid(dicom::series_instance_uid, image_.series->series_uid);
    }

    /// Frames are in the order of their segments, and within of their places.
    void put_dimensions(const std::string& organization) {
        static constexpr std::array<std::array<dicom::Tag, 2>, 2> dimensions = {
            {{referenced_segment_number, segment_identification}, {dicom::image_position_patient, dicom::plane_position}}};
        data_.put_items(0x00209222, dimensions.size(), [&](std::size_t i) {  // DimensionIndexSequence
            data_.put_uid(0x00209164, organization);                         // DimensionOrganizationUID
            data_.put_tag(0x00209165, dimensions[i][0]);                     // DimensionIndexPointer
            data_.put_tag(0x00209167, dimensions[i][1]);                     // FunctionalGroupPointer
        });
    }

    void put_pixel_format(bool shares) {
        data_.put_short(0x00280002, 1);        // SamplesPerPixel
        data_.put(0x00280004, "MONOCHROME2");  // PhotometricInterpretation
        data_.put_number(dicom::number_of_frames, frames_.size());
        data_.put_short(dicom::rows, image_.size[1]);
        data_.put_short(dicom::columns, image_.size[0]);
        data_.put_short(0x00280100, shares ? 8 : 1);  // BitsAllocated
        data_.put_short(0x00280101, shares ? 8 : 1);  // BitsStored
        data_.put_short(0x00280102, shares ? 7 : 0);  // HighBit
        data_.put_short(0x00280103, 0);               // PixelRepresentation
        data_.put(0x00282110, "00");                  // LossyImageCompression
    }

    void put_code(dicom::Tag sequence, const Code& code) {
        data_.put_items(sequence, 1, [&](std::size_t) {
            data_.put(0x00080100, identity_.name_text(code.value, 16));    // CodeValue
            data_.put(0x00080102, identity_.name_text(code.scheme, 16));   // CodingSchemeDesignator
            data_.put(0x00080104, identity_.name_text(code.meaning, 64));  // CodeMeaning
        });
    }

    void put_segment(std::size_t i) {
        const SegmentTerms& terms = parts_[i].terms;
        if (!terms.region.value.empty()) {
            put_code(0x00082218, terms.region);  // AnatomicRegionSequence
        }
        put_code(0x00620003, terms.category);                           // SegmentedPropertyCategoryCodeSequence
        data_.put_short(0x00620004, i + 1);                             // SegmentNumber
        data_.put(0x00620005, names_[i]);                               // SegmentLabel
        data_.put(0x00620008, "SEMIAUTOMATIC");                         // SegmentAlgorithmType
        data_.put(0x00620009, "lamella");                               // SegmentAlgorithmName
        data_.put_integers(0x0062000d, cielab_of(terms.colour_of(i)));  // RecommendedDisplayCIELabValue
        put_code(0x0062000f, terms.type);                               // SegmentedPropertyTypeCodeSequence
    }

    /// Numbers separated by backslashes.
    template <class Numbers>
    static std::string decimals(int most, const Numbers& numbers) {
        std::string text;
        for (const double number : numbers) {
            put_decimal(text, number, most);
            text += '\\';
        }
        text.pop_back();
        return text;
    }

    void put_shared() {
        const std::array<double, 3>& spacing = image_.spacing_mm;
        data_.put_items(dicom::plane_orientation, 1, [&](std::size_t) {
            data_.put(dicom::image_orientation_patient, decimals(13, image_.axes[0]) + "\\" + decimals(13, image_.axes[1]));
        });
        data_.put_items(dicom::pixel_measures, 1, [&](std::size_t) {
            data_.put(dicom::slice_thickness, decimals(12, std::array{spacing[2]}));
            if (image_.uneven_slices_mm.empty()) {
                data_.put(0x00180088, decimals(12, std::array{spacing[2]}));  // SpacingBetweenSlices
            }
            data_.put(dicom::pixel_spacing, decimals(12, std::array{spacing[1], spacing[0]}));
        });
    }

    Direction first_voxel(std::uint64_t slice) const noexcept {
        const auto steps = static_cast<double>(slice);
        return image_.to_lps({steps * image_.shear_mm[0], steps * image_.shear_mm[1], heights_[slice]});
    }

    void put_frame(const SegmentFrame& frame) {
        if (image_.series) {
            data_.put_items(0x00089124, 1, [&](std::size_t) {      // DerivationImageSequence
                data_.put_items(0x00082112, 1, [&](std::size_t) {  // SourceImageSequence
                    put_reference(data_, image_.series->slices[frame.slice]);
                    put_code(0x0040a170, {"DCM", "121322", "Source image for image processing operation"});
                });
                put_code(0x00089215, {"DCM", "113076", "Segmentation"});  // DerivationCodeSequence
            });
        }
        data_.put_items(dicom::frame_content, 1, [&](std::size_t) {
            data_.put_integers(0x00209157, std::array{static_cast<std::uint32_t>(frame.segment + 1),
                                                      place_[frame.slice]});  // DimensionIndexValues
        });
        data_.put_items(dicom::plane_position, 1, [&](std::size_t) {
            data_.put(dicom::image_position_patient, decimals(10, first_voxel(frame.slice)));
        });
        data_.put_items(segment_identification, 1,
                        [&](std::size_t) { data_.put_short(referenced_segment_number, frame.segment + 1); });
    }

    std::span<const MaskPart> parts_;
    const ImageGeometry& image_;
    std::span<const SegmentFrame> frames_;
    Sha256::Digest content_;
    Identity identity_;
    std::vector<double> heights_;
    std::vector<std::uint32_t> place_;  ///< of each slice among those with frames, from 1; 0: no frame
    std::vector<std::string> names_;
    DataSet data_;
};

}  // namespace

Result<SegmentationSummary> write_segmentation(std::span<const MaskPart> parts, const ImageGeometry& image,
                                               const std::filesystem::path& path, const SegmentationOptions& options,
                                               const Context& context) noexcept {
    return guarded(context, [&]() -> Result<SegmentationSummary> {
        require_series(image, path, options.without_ct, "a segmentation");
        if (parts.empty() || parts.size() > most_mask_labels) {
            refuse_output(path, std::to_string(parts.size()) + " meshes in a segmentation that holds 1 to 65,535");
        }
        if (image.size[0] > most_columns || image.size[1] > most_columns) {
            refuse_output(path, "more than 65,535 voxels along a side, which DICOM does not hold");
        }
        require_cut_for(parts, image, {.coverage = options.coverage, .subslices = options.subslices});
        const Parallel parallel(context);
        SegmentRaster raster(parts, image, options, parallel);
        const std::vector<SegmentFrame> frames = raster.frames();
        if (frames.size() > most_pixel_bytes * 8 / raster.frame_bits()) {
            refuse_output(path, std::to_string(frames.size()) + " frames, which are more than the 4 GiB of DICOM's pixels");
        }
        SegmentationHeader header(parts, image, options, frames,
                                  segmentation_content(parts, image, options, parallel.within(context)));
        OutputFile file = require(OutputFile::create(path));
        file.append(DataSet::file_meta(segmentation_storage, header.identity().values.at(dicom::sop_instance_uid)));
        header.write(file, raster.shares());
        parallel.begin_stage(1, parts.size());
        MaskCounts counts(parts.size());
        raster.write_pixels(frames, file, counts);
        SegmentationSummary summary{summary_of(counts, parts, parallel.within(context)), frames.size(),
                                    header.segment_names()};
        require(file.commit());
        parallel.finish();
        return summary;
    });
}

}  // namespace lamella
