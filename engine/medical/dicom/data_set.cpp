#include "medical/dicom/data_set.hpp"

#include <array>
#include <charconv>
#include <cstddef>

namespace lamella {

namespace {

void put_little(std::string& out, std::uint32_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) {
        out += static_cast<char>(value >> 8 * i & 0xff);
    }
}

void put_explicit(std::string& out, dicom::Tag tag, std::string_view type, std::string value, char padding) {
    value.append(value.size() % 2, padding);
    put_little(out, tag >> 16, 2);
    put_little(out, tag & 0xffff, 2);
    out.append(type);
    if (type == "OB") {
        out.append(2, '\0');
        put_little(out, static_cast<std::uint32_t>(value.size()), 4);
    } else {
        put_little(out, static_cast<std::uint32_t>(value.size()), 2);
    }
    out.append(value);
}

}  // namespace

void DataSet::put_head(dicom::Tag tag, std::uint32_t length) {
    put_little(bytes_, tag >> 16, 2);
    put_little(bytes_, tag & 0xffff, 2);
    put_little(bytes_, length, 4);
}

void DataSet::put(dicom::Tag tag, std::string_view value, char padding) {
    const std::size_t odd = value.size() % 2;
    put_head(tag, static_cast<std::uint32_t>(value.size() + odd));
    bytes_.append(value).append(odd, padding);
}

std::string file_meta(std::string_view class_uid, std::string_view instance_uid) {
    std::string elements;
    put_explicit(elements, 0x00020001, "OB", std::string("\0\1", 2), '\0');
    put_explicit(elements, 0x00020002, "UI", std::string(class_uid), '\0');
    put_explicit(elements, 0x00020003, "UI", std::string(instance_uid), '\0');
    put_explicit(elements, dicom::transfer_syntax_uid, "UI", "1.2.840.10008.1.2", '\0');
    // Lamella's own: a UUID that was drawn once.
    put_explicit(elements, 0x00020012, "UI", "2.25.188650397291203361548463912043171620943", '\0');
    put_explicit(elements, 0x00020013, "SH", "LAMELLA", ' ');
    std::string length;
    put_little(length, static_cast<std::uint32_t>(elements.size()), 4);
    std::string all(128, '\0');
    all += "DICM";
    put_explicit(all, 0x00020000, "UL", length, '\0');
    return all + elements;
}

void put_decimal(std::string& out, double value, int decimals) {
    constexpr std::ptrdiff_t most = 16;
    std::array<char, 64> text{};
    for (;; --decimals) {
        char* end = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed, decimals).ptr;
        if (decimals > 0) {
            while (end[-1] == '0') {
                --end;
            }
            end -= end[-1] == '.' ? 1 : 0;
        }
        if (end - text.data() <= most || decimals == 0) {
            const std::string_view all(text.data(), static_cast<std::size_t>(end - text.data()));
            out.append(all == "-0" ? "0" : all);
            return;
        }
    }
}

}  // namespace lamella
