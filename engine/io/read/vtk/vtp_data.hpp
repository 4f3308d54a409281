// The arrays of a VTP file: decimals, or bytes that are raw, in base64 or compressed, where their element is or appended to
// the document.
#pragma once

#include "io/read/arrays/array_file.hpp"

namespace lamella {

/// An element DataArray.
struct VtpArray {
    enum class Format : std::uint8_t { ascii, binary, appended };
    std::string name;  ///< for messages
    NumberType type = NumberType::float32;
    Format format = Format::ascii;
    const char* element = nullptr;      ///< where in the file it begins
    std::uint64_t appended_offset = 0;  ///< where in the appended data it lies
    std::string_view content;           ///< the text in the element, up to the next tag
};

/// The form of the file's data, as it states it.
struct VtpForm {
    bool big_endian = false;
    std::size_t header_bytes = 4;    ///< of each of the numbers before the data of an array
    std::string compressor;          ///< empty: none
    bool appended_as_base64 = true;  ///< else raw
    std::string_view appended;       ///< the appended data, after their underscore
};

/// The numbers of `array`, which must be `count`. Decimals are read as `as`: see read_words(). Throws errors.
NumberArray load_array(ArrayFile& file, const VtpForm& form, const VtpArray& array, std::uint64_t count, NumberType as);

}  // namespace lamella
