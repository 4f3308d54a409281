#include "medical/dicom/data_set.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdio>
#include <ctime>

#include "base/guard.hpp"
#include "base/utf8.hpp"
#include "lamella/io/mesh_file.hpp"
#include "lamella/version.hpp"
#include "medical/provenance/sha256.hpp"

namespace lamella {

namespace {

constexpr const char* utf_8 = "ISO_IR 192";

/// Values as bytes that do not depend on the platform but for points, the bulk, which are little-endian on all that count.
class ContentHash {
public:
    template <class... Values>
    void add(const Values&... values) noexcept {
        (add_one(values), ...);
    }
    Sha256::Digest digest() noexcept { return hash_.digest(); }

private:
    void add_one(std::uint64_t value) noexcept {
        std::array<unsigned char, 8> bytes{};
        for (std::size_t i = 0; i < bytes.size(); ++i) {
            bytes[i] = static_cast<unsigned char>(value >> 8 * i & 0xff);
        }
        hash_.add(bytes.data(), bytes.size());
    }
    void add_one(double value) noexcept { add_one(std::bit_cast<std::uint64_t>(value)); }
    void add_one(std::string_view text) noexcept {
        add_one(std::uint64_t{text.size()});
        hash_.add(text.data(), text.size());
    }
    void add_one(const std::string& text) noexcept { add_one(std::string_view(text)); }
    void add_one(std::span<const Point> points) noexcept {
        static_assert(sizeof(Point) == 8, "nothing lies between its members");
        add_one(std::uint64_t{points.size()});
        hash_.add(points.data(), points.size_bytes());
    }

    Sha256 hash_;
};

void add_image(ContentHash& hash, const ImageGeometry& image) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto& [x, y, z] = image.axes[axis];
        hash.add(image.size[axis], image.spacing_mm[axis], image.origin_mm[axis], x, y, z);
    }
    for (const double height : image.slice_heights_mm()) {
        hash.add(height);
    }
    hash.add(std::uint64_t{image.series.has_value()});
    if (image.series) {
        for (const dicom::SeriesText& text : dicom::series_texts) {
            hash.add(*image.series.*text.text);
        }
        for (const DicomSeries::Instance& slice : image.series->slices) {
            hash.add(slice.sop_class_uid, slice.sop_instance_uid);
        }
    }
}

void add_roi(ContentHash& hash, const Roi& roi) {
    const auto [red, green, blue] = roi.colour;
    hash.add(roi.name, std::uint64_t{red}, std::uint64_t{green}, std::uint64_t{blue}, roi.result->info.grid_mm);
    for (const std::uint64_t index : roi.result->info.layer_of) {
        const Layer& layer = roi.result->layers[index];
        hash.add(layer.contour_count);
        for (const Contour& contour : roi.result->contours_of(layer)) {
            hash.add(static_cast<std::uint64_t>(contour.role), roi.result->points_of(contour));
        }
    }
}

/// SHA-256 over all that decides the bytes of a structure set.
Sha256::Digest content_of(std::span<const Roi> rois, const ImageGeometry& image, const StructureSetOptions& options,
                          const Context& context) {
    ContentHash hash;
    hash.add(std::string_view(version), static_cast<std::uint64_t>(options.holes), options.label,
             std::uint64_t{options.seconds_since_1970.has_value()},
             static_cast<std::uint64_t>(options.seconds_since_1970.value_or(0)));
    add_image(hash, image);
    const PacedStop stop(context.stop);
    for (const Roi& roi : rois) {
        stop.stop_if_asked();
        add_roi(hash, roi);
    }
    return hash.digest();
}

bool is_ascii(const std::string& text) {
    return std::all_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x80; });
}

/// At most `most` characters; what a text of DICOM must not hold becomes _.
std::string name_text(const std::string& name, std::size_t most, bool beyond_ascii) {
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

void set_texts(std::span<const Roi> rois, const DicomSeries* series, const std::string& label,
               StructureSetIdentity& identity) {
    if (series != nullptr) {
        identity.character_set = plain_text(series->specific_character_set);
    }
    const bool names_in_ascii =
        is_ascii(label) && std::all_of(rois.begin(), rois.end(), [](const Roi& roi) { return is_ascii(roi.name); });
    const bool ct_in_ascii =
        series == nullptr || std::all_of(dicom::series_texts.begin(), dicom::series_texts.end(),
                                         [&](const dicom::SeriesText& text) { return is_ascii(series->*text.text); });
    // Texts that switch sets are ASCII by their bytes.
    const bool switches = identity.character_set.find("2022") != std::string::npos;
    if (!names_in_ascii && ct_in_ascii && !switches) {
        identity.character_set = utf_8;
    }
    const bool beyond_ascii = identity.character_set == utf_8;
    constexpr std::size_t most_of_label = 16;
    constexpr std::size_t most_of_name = 64;
    identity.label = name_text(label, most_of_label, beyond_ascii);
    for (const Roi& roi : rois) {
        identity.roi_names.push_back(name_text(roi.name, most_of_name, beyond_ascii));
    }
    identity.roi_names = distinct_names(identity.roi_names, most_of_name);
}

void set_date(std::int64_t seconds_since_1970, StructureSetIdentity& identity) {
    const auto seconds = static_cast<std::time_t>(seconds_since_1970);
    std::tm utc{};
    if (::gmtime_r(&seconds, &utc) == nullptr || utc.tm_year < -1900 || utc.tm_year > 9999 - 1900) {
        throw Refused{{ErrorCode::invalid_argument, "the time of the structure set lies beyond the year 9999"}};
    }
    std::array<char, 64> text{};
    (void)std::snprintf(text.data(), text.size(), "%04d%02d%02d", utc.tm_year + 1900, utc.tm_mon + 1, utc.tm_mday);
    identity.date = text.data();
    (void)std::snprintf(text.data(), text.size(), "%02d%02d%02d", utc.tm_hour, utc.tm_min, utc.tm_sec);
    identity.time = text.data();
}

}  // namespace

std::string plain_text(std::string text) {
    constexpr char escape = 0x1b;
    std::replace_if(
        text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < ' ' && c != escape; }, ' ');
    return text;
}

StructureSetIdentity identity_of(std::span<const Roi> rois, const ImageGeometry& image, const StructureSetOptions& options,
                                 const Context& context) {
    const Sha256::Digest content = content_of(rois, image, options, context);
    StructureSetIdentity identity;
    identity.instance_uid = uid_of(content, "instance");
    identity.series_uid = uid_of(content, "series");
    identity.study_uid = image.series ? image.series->study_uid : uid_of(content, "study");
    identity.frame_of_reference_uid =
        image.series ? image.series->frame_of_reference_uid : uid_of(content, "frame of reference");
    if (options.seconds_since_1970) {
        set_date(*options.seconds_since_1970, identity);
    }
    set_texts(rois, image.series ? &*image.series : nullptr, options.label, identity);
    return identity;
}

std::string uid_of(const std::array<unsigned char, 32>& content, std::string_view purpose) {
    Sha256 hash;
    hash.add(content.data(), content.size());
    hash.add(purpose.data(), purpose.size());
    Sha256::Digest uuid = hash.digest();  // its first 16 bytes, the most significant one first
    uuid[6] = static_cast<unsigned char>((uuid[6] & 0x0f) | 0x80);
    uuid[8] = static_cast<unsigned char>((uuid[8] & 0x3f) | 0x80);
    std::string decimals;
    while (std::any_of(uuid.begin(), uuid.begin() + 16, [](unsigned char byte) { return byte != 0; })) {
        unsigned rest = 0;
        for (std::size_t i = 0; i < 16; ++i) {
            const unsigned value = rest << 8 | uuid[i];
            uuid[i] = static_cast<unsigned char>(value / 10);
            rest = value % 10;
        }
        decimals += static_cast<char>('0' + rest);
    }
    std::reverse(decimals.begin(), decimals.end());
    return "2.25." + decimals;
}

}  // namespace lamella
