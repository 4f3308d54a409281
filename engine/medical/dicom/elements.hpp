// The elements of a DICOM data set, one after the other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "medical/dicom/header.hpp"

namespace lamella {

struct DicomEncoding {
    bool is_explicit = false;  ///< each element names the type of its value
    bool is_big_endian = false;
};

class DicomElements {
public:
    /// `file_offset`: of the first byte, for messages.
    DicomElements(std::string_view bytes, DicomEncoding encoding, std::size_t file_offset)
        : bytes_(bytes), encoding_(encoding), file_offset_(file_offset) {}

    enum class End : std::uint8_t {
        passed,  ///< the next element is beyond the last wanted
        bytes_end,
    };

    /// Puts what is wanted of the elements up to `last` into `header`. Throws Refused where there is no element.
    End collect(dicom::Tag last, DicomHeader& header);

    /// Where the next element begins.
    std::size_t position() const noexcept { return at_; }

private:
    struct Element {
        dicom::Tag tag = 0;
        std::uint32_t length = 0;
        bool unknown = false;  ///< of type UN: within, all is implicit and little-endian
    };

    std::uint64_t number(std::size_t at, std::size_t bytes, bool big_endian) const noexcept;
    dicom::Tag tag_at(std::size_t at, bool big_endian) const noexcept;
    bool read_element(DicomEncoding encoding, Element& element, const DicomHeader& header);
    bool skip_value(const Element& element, const DicomHeader& header);
    bool skip_bytes(std::uint64_t count) noexcept;

    std::string_view bytes_;
    DicomEncoding encoding_;
    std::size_t file_offset_;
    std::size_t at_ = 0;
};

}  // namespace lamella
