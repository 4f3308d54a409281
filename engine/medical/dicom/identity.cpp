#include "medical/dicom/identity.hpp"

#include <algorithm>
#include <chrono>
#include <span>

#include "base/guard.hpp"
#include "base/utf8.hpp"
#include "lamella/io/mesh_file.hpp"
#include "lamella/version.hpp"
#include "medical/geometry/common.hpp"

namespace lamella {

namespace {

/// A text of the CT without control characters but those that switch character sets.
std::string plain_text(std::string text) {
    constexpr char escape = 0x1b;
    std::replace_if(
        text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < ' ' && c != escape; }, ' ');
    return text;
}

/// The date and the time of day, UTC.
std::array<std::string, 2> date_and_time(std::int64_t seconds_since_1970) {
    constexpr std::int64_t begin_of_year_0 = -62'167'219'200;
    constexpr std::int64_t end_of_year_9999 = 253'402'300'800;
    if (seconds_since_1970 < begin_of_year_0 || seconds_since_1970 >= end_of_year_9999) {
        throw Refused{{ErrorCode::invalid_argument, "the time asked for lies beyond the year 9999"}};
    }
    const std::chrono::sys_seconds at{std::chrono::seconds(seconds_since_1970)};
    const auto midnight = std::chrono::floor<std::chrono::days>(at);
    const std::chrono::year_month_day date(midnight);
    const std::chrono::hh_mm_ss time(at - midnight);
    const auto digits = [](std::int64_t number, std::size_t count) {
        const std::string text = std::to_string(number);
        return std::string(count - text.size(), '0') + text;
    };
    return {digits(int{date.year()}, 4) + digits(unsigned{date.month()}, 2) + digits(unsigned{date.day()}, 2),
            digits(time.hours().count(), 2) + digits(time.minutes().count(), 2) + digits(time.seconds().count(), 2)};
}

}  // namespace

void ContentHash::add_image(const ImageGeometry& image) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto& [x, y, z] = image.axes[axis];
        add(image.size[axis], image.spacing_mm[axis], image.origin_mm[axis], x, y, z);
    }
    for (const double height : image.slice_heights_mm()) {
        add(height);
    }
    add(std::uint64_t{image.series.has_value()});
    if (image.series) {
        for (const dicom::SeriesText& text : dicom::series_texts) {
            add(*image.series.*text.text);
        }
        for (const DicomSeries::Instance& slice : image.series->slices) {
            add(slice.sop_class_uid, slice.sop_instance_uid, slice.frame);
        }
    }
}

void ContentHash::add_contours(const SliceResult& result) {
    add(result.info.grid_mm);
    for (const std::uint64_t index : result.info.layer_of) {
        const Layer& layer = result.layers[index];
        add(std::uint64_t{layer.contour_count});
        for (const Contour& contour : result.contours_of(layer)) {
            add(static_cast<std::uint64_t>(contour.role), result.points_of(contour));
        }
    }
}

bool is_ascii(std::string_view text) {
    return std::all_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x80; });
}

Identity::Identity(const ImageGeometry& image, const Sha256::Digest& content, std::string_view class_uid,
                   const char* modality, bool names_in_ascii, std::optional<std::int64_t> seconds_since_1970) {
    const DicomSeries series = image.series.value_or(DicomSeries{});
    bool ct_in_ascii = true;
    for (const dicom::SeriesText& text : dicom::series_texts) {
        ct_in_ascii = ct_in_ascii && is_ascii(series.*text.text);
        values[text.tag] = plain_text(series.*text.text);
    }
    values[dicom::sop_class_uid] = padded_uid(class_uid);
    values[dicom::sop_instance_uid] = padded_uid(uid_of(content, "instance"));
    values[dicom::series_instance_uid] = padded_uid(uid_of(content, "series"));
    values[dicom::study_instance_uid] = padded_uid(image.series ? series.study_uid : uid_of(content, "study"));
    values[dicom::frame_of_reference_uid] =
        padded_uid(image.series ? series.frame_of_reference_uid : uid_of(content, "frame of reference"));
    values[dicom::modality] = modality;
    values[0x00080070] = "lamella";  // Manufacturer
    values[0x00081090] = "lamella";  // ManufacturerModelName
    values[0x00181020] = version;    // SoftwareVersions
    if (seconds_since_1970) {
        date_and_time = lamella::date_and_time(*seconds_since_1970);
    }
    constexpr const char* utf_8 = "ISO_IR 192";
    std::string& character_set = values[dicom::specific_character_set];
    // Texts that switch sets are ASCII by their bytes.
    if (!names_in_ascii && ct_in_ascii && character_set.find("2022") == std::string::npos) {
        character_set = utf_8;
    }
    beyond_ascii = character_set == utf_8;
    for (const dicom::Tag tag : {dicom::specific_character_set, dicom::study_description}) {
        if (values[tag].empty()) {
            values.erase(tag);
        }
    }
}

std::string Identity::name_text(std::string_view name, std::size_t most) const {
    std::string text;
    std::size_t characters = 0;
    for (std::size_t at = 0; at < name.size() && characters < most; ++characters) {
        const std::size_t bytes = character_bytes(name, at);
        const bool allowed =
            bytes == 1 ? name[at] >= ' ' && name[at] != '\\' && name[at] != 0x7f : bytes > 1 && beyond_ascii;
        text += allowed ? name.substr(at, bytes) : "_";
        at += std::max<std::size_t>(bytes, 1);
    }
    return text;
}

std::vector<std::string> Identity::distinct(const std::vector<std::string>& names) const {
    constexpr std::size_t most_of_name = 64;
    std::vector<std::string> texts(names.size());
    std::transform(names.begin(), names.end(), texts.begin(),
                   [&](const std::string& name) { return name_text(name, most_of_name); });
    return distinct_names(texts, most_of_name);
}

void require_series(const ImageGeometry& image, const std::filesystem::path& path, bool without_ct,
                    const std::string& what) {
    if (!image.series) {
        if (!without_ct) {
            refuse_output(path, what + " is drawn on the slices of a CT, a folder with a DICOM series");
        }
        return;
    }
    const auto require_uid = [&](const std::string& uid, const char* keyword, const std::string& where) {
        if (uid.empty() || uid.size() > 64 || uid.find_first_not_of("0123456789.") != std::string::npos) {
            refuse_output(path, where + " states no usable " + keyword + ", which " + what + " must name");
        }
    };
    const DicomSeries& series = *image.series;
    if (series.slices.size() != image.size[2]) {
        refuse_output(path, "the CT has other slices than its geometry");
    }
    require_uid(series.study_uid, "StudyInstanceUID", "the CT");
    require_uid(series.series_uid, "SeriesInstanceUID", "the CT");
    require_uid(series.frame_of_reference_uid, "FrameOfReferenceUID", "the CT");
    for (const DicomSeries::Instance& slice : series.slices) {
        require_uid(slice.sop_class_uid, "SOPClassUID", slice.file);
        require_uid(slice.sop_instance_uid, "SOPInstanceUID", slice.file);
    }
}

void put_reference(DataSet& out, const DicomSeries::Instance& slice) {
    put_reference(out, slice.sop_class_uid, slice.sop_instance_uid);
    if (slice.frame != 0) {
        out.put_number(dicom::referenced_frame_number, slice.frame);
    }
}

void put_reference(DataSet& out, std::string_view class_uid, std::string_view instance_uid) {
    out.put_uid(0x00081150, class_uid);     // ReferencedSOPClassUID
    out.put_uid(0x00081155, instance_uid);  // ReferencedSOPInstanceUID
}

std::string uid_of(const std::array<unsigned char, 32>& content, std::string_view purpose) {
    Sha256 hash;
    hash.add(content.data(), content.size());
    hash.add(purpose.data(), purpose.size());
    Sha256::Digest uuid = hash.digest();  // its first 16 bytes, the most significant one first
    uuid[6] = static_cast<unsigned char>((uuid[6] & 0x0f) | 0x80);
    uuid[8] = static_cast<unsigned char>((uuid[8] & 0x3f) | 0x80);
    std::string decimals;
    for (bool is_done = false; !is_done;) {  // divides them by 10
        unsigned rest = 0;
        is_done = true;
        for (unsigned char& byte : std::span(uuid).first<16>()) {
            rest = rest << 8 | byte;
            byte = static_cast<unsigned char>(rest / 10);
            rest %= 10;
            is_done = is_done && byte == 0;
        }
        decimals += static_cast<char>('0' + rest);
    }
    std::reverse(decimals.begin(), decimals.end());
    return "2.25." + decimals;
}

}  // namespace lamella
