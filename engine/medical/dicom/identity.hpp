// Who a structure set says that it is: UIDs by what it holds, and texts in one character set.
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lamella/medical/structure_set.hpp"

namespace lamella {

struct StructureSetIdentity {
    std::string instance_uid;
    std::string series_uid;
    std::string study_uid;
    std::string frame_of_reference_uid;
    std::string date;  ///< empty where none was asked for
    std::string time;
    std::string character_set;  ///< Specific Character Set, or nothing for ASCII
    std::string label;
    std::vector<std::string> roi_names;  ///< at most 64 characters; none repeats
};

/// Patient, study and frame of reference are the CT's where there is one, and so is the character set. Names are UTF-8:
/// where the CT has texts in another set, characters beyond ASCII become _. Throws Refused, Stopped, std::bad_alloc.
StructureSetIdentity identity_of(std::span<const Roi> rois, const ImageGeometry& image, const StructureSetOptions& options,
                                 const Context& context);

/// 2.25. and the UUID (version 8, RFC 9562) that the content's SHA-256 and the purpose give, in decimals: at most 44
/// characters.
std::string uid_of(const std::array<unsigned char, 32>& content, std::string_view purpose);

/// A text of the CT without control characters but those that switch character sets.
std::string plain_text(std::string text);

}  // namespace lamella
