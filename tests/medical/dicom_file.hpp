// Small DICOM files for tests.
#pragma once

#include <cstdint>
#include <cstdio>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "medical/dicom/tags.hpp"

namespace dicom_file {

enum class Syntax : std::uint8_t { implicit_little, explicit_little, explicit_big };

inline std::string number(std::uint32_t value, int bytes, bool big) {
    std::string text;
    for (int i = 0; i < bytes; ++i) {
        text += static_cast<char>(value >> 8 * (big ? bytes - 1 - i : i) & 0xff);
    }
    return text;
}

inline std::string tag(std::uint32_t value, bool big) {
    return number(value >> 16, 2, big) + number(value & 0xffff, 2, big);
}

/// `value` of type US: in decimals.
inline std::string element(Syntax syntax, std::uint32_t at, std::string_view type, std::string value) {
    const bool big = syntax == Syntax::explicit_big;
    value = type == "US" ? number(static_cast<std::uint32_t>(std::stoul(value)), 2, big) : value;
    value.resize((value.size() + 1) / 2 * 2, type == "UI" ? '\0' : ' ');
    const auto length = static_cast<std::uint32_t>(value.size());
    if (syntax == Syntax::implicit_little) {
        return tag(at, false) + number(length, 4, false) + value;
    }
    const bool is_long = type == "OW" || type == "OB" || type == "SQ" || type == "UN";
    return tag(at, big) + std::string(type) +
           (is_long ? std::string(2, '\0') + number(length, 4, big) : number(length, 2, big)) + value;
}

/// A sequence of undefined length with one item of undefined length around `inner`.
inline std::string sequence(Syntax syntax, std::uint32_t at, const std::string& inner, std::string_view type = "SQ") {
    const bool big = syntax == Syntax::explicit_big;
    const std::string endless = number(0xffffffff, 4, big);
    const std::string head =
        syntax == Syntax::implicit_little ? tag(at, big) : tag(at, big) + std::string(type) + std::string(2, '\0');
    return head + endless + tag(0xfffee000, big) + endless + inner + tag(0xfffee00d, big) + number(0, 4, big) +
           tag(0xfffee0dd, big) + number(0, 4, big);
}

/// The begin of a file: up to its data set.
inline std::string meta(const std::string& syntax_uid) {
    const std::string uid = element(Syntax::explicit_little, 0x00020010, "UI", syntax_uid);
    return std::string(128, '\0') + "DICM" +
           element(Syntax::explicit_little, 0x00020000, "UL", number(static_cast<std::uint32_t>(uid.size()), 4, false)) +
           uid;
}

/// A slice of a CT; an empty text leaves its attribute out.
struct CtSlice {
    Syntax syntax = Syntax::explicit_little;
    std::string extra{};  ///< elements before group 0018
    std::map<std::uint32_t, std::pair<const char*, std::string>> elements = {
        {lamella::dicom::sop_class_uid, {"UI", "1.2.840.10008.5.1.4.1.1.2"}},
        {lamella::dicom::sop_instance_uid, {"UI", "1.2.3.1"}},
        {lamella::dicom::modality, {"CS", "CT"}},
        {lamella::dicom::series_description, {"LO", "Thorax"}},
        {0x00100010, {"PN", "Doe^Jane"}},
        {0x00100020, {"LO", "17"}},
        {lamella::dicom::slice_thickness, {"DS", "3"}},
        {lamella::dicom::study_instance_uid, {"UI", "1.2"}},
        {lamella::dicom::series_instance_uid, {"UI", "1.2.3"}},
        {lamella::dicom::image_position_patient, {"DS", "-10\\-20\\30"}},
        {lamella::dicom::image_orientation_patient, {"DS", "1\\0\\0\\0\\1\\0"}},
        {lamella::dicom::frame_of_reference_uid, {"UI", "1.2.3.9"}},
        {lamella::dicom::number_of_frames, {"IS", ""}},
        {lamella::dicom::rows, {"US", "4"}},
        {lamella::dicom::columns, {"US", "6"}},
        {lamella::dicom::pixel_spacing, {"DS", "2\\0.5"}},
        {0x00280100, {"US", "16"}},
        {0x7fe00010, {"OW", std::string(2 * 4 * 6, '\0')}},
    };

    std::string& operator[](std::uint32_t at) { return elements[at].second; }

    std::string data() const {
        std::string all;
        for (const auto& [at, value] : elements) {
            all += at == lamella::dicom::slice_thickness ? extra : "";
            all += value.second.empty() ? "" : element(syntax, at, value.first, value.second);
        }
        return all;
    }

    std::string bytes() const {
        static constexpr const char* syntaxes[] = {"1.2.840.10008.1.2", "1.2.840.10008.1.2.1", "1.2.840.10008.1.2.2"};
        return meta(syntaxes[static_cast<int>(syntax)]) + data();
    }
};

inline CtSlice at_height(double z, int index) {
    CtSlice slice;
    char text[64];
    (void)std::snprintf(text, sizeof text, "-10\\-20\\%.6g", z);
    slice[lamella::dicom::image_position_patient] = text;
    slice[lamella::dicom::sop_instance_uid] = "1.2.3.1." + std::to_string(index);
    return slice;
}

}  // namespace dicom_file
