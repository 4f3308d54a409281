#include "medical/dicom/texts.hpp"

#include <algorithm>
#include <cstddef>

namespace lamella {

namespace {

constexpr const char* utf_8 = "ISO_IR 192";

bool is_ascii(const std::string& text) {
    return std::all_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x80; });
}

/// Bytes of the character that begins at `at`; 0 where it is no UTF-8.
std::size_t character_bytes(const std::string& text, std::size_t at) {
    const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
    const unsigned first = byte(at);
    if (first < 0x80) {
        return 1;
    }
    const std::size_t bytes = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
    if (first < 0xc2 || first > 0xf4) {
        return 0;
    }
    for (std::size_t i = 1; i < bytes; ++i) {
        if ((byte(at + i) & 0xc0U) != 0x80) {
            return 0;
        }
    }
    const unsigned second = byte(at + 1);
    const bool overlong = (first == 0xe0 && second < 0xa0) || (first == 0xf0 && second < 0x90);
    const bool beyond = (first == 0xed && second >= 0xa0) || (first == 0xf4 && second >= 0x90);
    return overlong || beyond ? 0 : bytes;
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

}  // namespace

std::string plain_text(std::string text) {
    constexpr char escape = 0x1b;
    std::replace_if(
        text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < ' ' && c != escape; }, ' ');
    return text;
}

DicomTexts dicom_texts(std::span<const Roi> rois, const DicomSeries* series, const std::string& label) {
    DicomTexts texts;
    if (series != nullptr) {
        texts.character_set = plain_text(series->specific_character_set);
    }
    const bool names_in_ascii =
        is_ascii(label) && std::all_of(rois.begin(), rois.end(), [](const Roi& roi) { return is_ascii(roi.name); });
    const bool ct_in_ascii =
        series == nullptr || (is_ascii(series->patient_name) && is_ascii(series->patient_id) && is_ascii(series->study_id) &&
                              is_ascii(series->study_description) && is_ascii(series->accession_number) &&
                              is_ascii(series->referring_physician_name));
    // Texts that switch sets are ASCII by their bytes.
    const bool switches = texts.character_set.find("2022") != std::string::npos;
    if (!names_in_ascii && ct_in_ascii && !switches) {
        texts.character_set = utf_8;
    }
    const bool beyond_ascii = texts.character_set == utf_8;
    constexpr std::size_t most_of_label = 16;
    constexpr std::size_t most_of_name = 64;
    texts.label = name_text(label, most_of_label, beyond_ascii);
    for (const Roi& roi : rois) {
        texts.roi_names.push_back(name_text(roi.name, most_of_name, beyond_ascii));
    }
    return texts;
}

}  // namespace lamella
