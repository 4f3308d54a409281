// Texts of a structure set, in one character set.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "lamella/medical/structure_set.hpp"

namespace lamella {

struct DicomTexts {
    std::string character_set;  ///< Specific Character Set, or nothing for ASCII
    std::string label;
    std::vector<std::string> roi_names;  ///< at most 64 characters; none repeats
};

/// The character set is the CT's. Names are UTF-8: where the CT has texts in another set, characters beyond ASCII become _.
DicomTexts dicom_texts(std::span<const Roi> rois, const DicomSeries* series, const std::string& label);

/// A text of the CT without control characters but those that switch character sets.
std::string plain_text(std::string text);

}  // namespace lamella
