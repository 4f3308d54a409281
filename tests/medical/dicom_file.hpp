// Small DICOM files for tests.
#pragma once

#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>

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

inline std::string element(Syntax syntax, std::uint32_t at, std::string_view type, std::string value) {
    const bool big = syntax == Syntax::explicit_big;
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
    std::string instance = "1.2.3.1";
    std::string series = "1.2.3";
    std::string description = "Thorax";
    std::string position = "-10\\-20\\30";
    std::string orientation = "1\\0\\0\\0\\1\\0";
    std::string spacing = "2\\0.5";
    std::string frames;
    std::string thickness = "3";
    std::string frame_of_reference = "1.2.3.9";
    std::uint32_t rows = 4;
    std::uint32_t columns = 6;
    std::string extra;  ///< elements before group 0018

    std::string data() const {
        std::string all;
        const auto add = [&](std::uint32_t at, std::string_view type, const std::string& value) {
            all += value.empty() ? std::string() : element(syntax, at, type, value);
        };
        const bool big = syntax == Syntax::explicit_big;
        add(0x00080016, "UI", "1.2.840.10008.5.1.4.1.1.2");
        add(0x00080018, "UI", instance);
        add(0x00080060, "CS", "CT");
        add(0x0008103e, "LO", description);
        add(0x00100010, "PN", "Doe^Jane");
        add(0x00100020, "LO", "17");
        all += extra;
        add(0x00180050, "DS", thickness);
        add(0x0020000d, "UI", "1.2");
        add(0x0020000e, "UI", series);
        add(0x00200032, "DS", position);
        add(0x00200037, "DS", orientation);
        add(0x00200052, "UI", frame_of_reference);
        add(0x00280008, "IS", frames);
        add(0x00280010, "US", number(rows, 2, big));
        add(0x00280011, "US", number(columns, 2, big));
        add(0x00280030, "DS", spacing);
        add(0x00280100, "US", number(16, 2, big));
        return all + element(syntax, 0x7fe00010, "OW", std::string(static_cast<std::size_t>(2) * rows * columns, '\0'));
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
    slice.position = text;
    slice.instance = "1.2.3.1." + std::to_string(index);
    return slice;
}

}  // namespace dicom_file
