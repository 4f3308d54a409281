#include "medical/dicom/identity.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "base/guard.hpp"
#include "lamella/version.hpp"
#include "medical/provenance/sha256.hpp"

namespace lamella {

namespace {

/// Values as bytes that do not depend on the platform but for points, the bulk, which are little-endian on all that count.
class ContentHash {
public:
    void add(std::uint64_t value) noexcept {
        std::array<unsigned char, 8> bytes{};
        for (std::size_t i = 0; i < bytes.size(); ++i) {
            bytes[i] = static_cast<unsigned char>(value >> 8 * i & 0xff);
        }
        hash_.add(bytes.data(), bytes.size());
    }
    void add(double value) noexcept { add(std::bit_cast<std::uint64_t>(value)); }
    void add(std::string_view text) noexcept {
        add(std::uint64_t{text.size()});
        hash_.add(text.data(), text.size());
    }
    void add(std::span<const Point> points) noexcept {
        static_assert(sizeof(Point) == 8, "nothing lies between its members");
        add(std::uint64_t{points.size()});
        hash_.add(points.data(), points.size_bytes());
    }
    std::array<unsigned char, 32> digest() noexcept { return hash_.digest(); }

private:
    Sha256 hash_;
};

void add_image(ContentHash& hash, const ImageGeometry& image) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        hash.add(image.size[axis]);
        hash.add(image.spacing_mm[axis]);
        hash.add(image.origin_mm[axis]);
        for (const double part : image.axes[axis]) {
            hash.add(part);
        }
    }
    for (const double height : image.slice_heights_mm()) {
        hash.add(height);
    }
}

void add_series(ContentHash& hash, const DicomSeries& series) {
    for (const std::string* text :
         {&series.study_uid, &series.series_uid, &series.frame_of_reference_uid, &series.specific_character_set,
          &series.patient_name, &series.patient_id, &series.patient_birth_date, &series.patient_sex, &series.study_date,
          &series.study_time, &series.study_id, &series.study_description, &series.accession_number,
          &series.referring_physician_name, &series.position_reference_indicator}) {
        hash.add(std::string_view(*text));
    }
    for (const DicomSeries::Instance& slice : series.slices) {
        hash.add(std::string_view(slice.sop_class_uid));
        hash.add(std::string_view(slice.sop_instance_uid));
    }
}

void add_roi(ContentHash& hash, const Roi& roi) {
    hash.add(std::string_view(roi.name));
    for (const std::uint8_t part : roi.colour) {
        hash.add(std::uint64_t{part});
    }
    hash.add(roi.result->unit_mm);
    for (const std::uint64_t index : roi.result->layer_of) {
        const Layer& layer = roi.result->layers[index];
        hash.add(layer.contour_count);
        for (const Contour& contour : roi.result->contours_of(layer)) {
            hash.add(static_cast<std::uint64_t>(contour.role));
            hash.add(roi.result->points_of(contour));
        }
    }
}

}  // namespace

std::array<unsigned char, 32> content_of(std::span<const Roi> rois, const ImageGeometry& image,
                                         const StructureSetOptions& options) {
    ContentHash hash;
    hash.add(std::string_view(version));
    hash.add(static_cast<std::uint64_t>(options.holes));
    hash.add(std::string_view(options.label));
    hash.add(std::uint64_t{options.seconds_since_1970.has_value()});
    hash.add(static_cast<std::uint64_t>(options.seconds_since_1970.value_or(0)));
    add_image(hash, image);
    hash.add(std::uint64_t{image.series.has_value()});
    if (image.series) {
        add_series(hash, *image.series);
    }
    const PacedStop stop(options.control.stop);
    for (const Roi& roi : rois) {
        stop.stop_if_asked();
        add_roi(hash, roi);
    }
    return hash.digest();
}

std::string uid_of(const std::array<unsigned char, 32>& content, std::string_view purpose) {
    Sha256 hash;
    hash.add(content.data(), content.size());
    hash.add(purpose.data(), purpose.size());
    std::array<unsigned char, 32> uuid = hash.digest();  // its first 16 bytes, the most significant one first
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
