#include "medical/dicom/texts.hpp"

#include <algorithm>
#include <cstddef>

#include "base/utf8.hpp"
#include "lamella/io/mesh_file.hpp"

namespace lamella {

namespace {

constexpr const char* utf_8 = "ISO_IR 192";

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
    texts.roi_names = distinct_names(texts.roi_names, most_of_name);
    return texts;
}

}  // namespace lamella
