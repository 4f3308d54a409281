// Who a DICOM object says that it is, and the images that it was made on: what structure sets and segmentations have in
// common.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "base/system/sha256.hpp"
#include "lamella/context.hpp"
#include "lamella/medical/geometry.hpp"
#include "lamella/result.hpp"
#include "medical/dicom/data_set.hpp"

namespace lamella {

/// SHA-256 over all that decides the bytes of an object.
class ContentHash {
public:
    /// Bytes of values, little-endian as the host's; of a text, or of points, after their number.
    template <class... Values>
    void add(const Values&... values) noexcept {
        (add_one(values), ...);
    }
    /// Where the voxels lie, and the texts and slices of a series.
    void add_image(const ImageGeometry& image);
    /// The contours of all heights.
    void add_contours(const SliceResult& result);
    /// Once, at the end.
    Sha256::Digest digest() noexcept { return hash_.digest(); }

private:
    template <class Value>
    void add_one(const Value& value) noexcept {
        if constexpr (std::is_arithmetic_v<Value>) {
            static_assert(sizeof value == 8);
            hash_.add(&value, sizeof value);
        } else {
            add_one(std::uint64_t{std::size(value)});
            hash_.add(std::data(value), std::size(value) * sizeof(*std::data(value)));
        }
    }

    Sha256 hash_;
};

bool is_ascii(std::string_view text);

/// Patient, study and frame of reference are the CT's where there is one, and so is the character set. Names are UTF-8:
/// where the CT has texts in another set, characters beyond ASCII become _.
struct Identity {
    /// Of the modules Patient, General Study, General Series, General Equipment and Frame of Reference, in the order of
    /// tags, as a data set is.
    std::map<dicom::Tag, std::string> values;
    std::array<std::string, 2> date_and_time{};  ///< UTC; empty where none was asked for
    bool beyond_ascii = false;                   ///< names may be

    /// Throws Refused (invalid_argument) where the time has no four digits for its year.
    Identity(const ImageGeometry& image, const Sha256::Digest& content, std::string_view class_uid, const char* modality,
             bool names_in_ascii, std::optional<std::int64_t> seconds_since_1970);

    /// At most `most` characters; what a text of DICOM must not hold becomes _.
    std::string name_text(std::string_view name, std::size_t most) const;
    /// The same of names of at most 64 characters; none repeats.
    std::vector<std::string> distinct(const std::vector<std::string>& names) const;
};

/// Throws Refused (invalid_argument) where the image has no series that `what`, "a structure set", can name, unless it is
/// none and `without_ct`.
void require_series(const ImageGeometry& image, const std::filesystem::path& path, bool without_ct, const std::string& what);

void put_reference(DataSet& out, std::string_view class_uid, std::string_view instance_uid);
/// With the number of its frame, in a file of several.
void put_reference(DataSet& out, const DicomSeries::Instance& slice);

}  // namespace lamella
