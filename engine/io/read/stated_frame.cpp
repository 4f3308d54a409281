#include "io/read/stated_frame.hpp"

#include <algorithm>

#include "io/text/text.hpp"

namespace lamella {

namespace {

/// "SPACE" within "COLORSPACE=..." is not the word.
bool is_name_character(char c) {
    return is_digit(c) || c == '_' || c == '-' || ((c | 0x20) >= 'a' && (c | 0x20) <= 'z');
}

/// Headers of a fixed length are filled up with zeros.
bool ends_word(char c) {
    return c == '\0' || is_space(c);
}

}  // namespace

void StatedFrame::read_header(std::string_view header) {
    constexpr std::string_view word = "SPACE=";
    for (std::size_t at = header.find(word); at != std::string_view::npos; at = header.find(word, at + 1)) {
        if (at == 0 || !is_name_character(header[at - 1])) {
            const std::string_view rest = header.substr(at + word.size());
            const auto* const end = std::find_if(rest.begin(), rest.end(), ends_word);
            read_space(rest.substr(0, static_cast<std::size_t>(end - rest.begin())));
        }
    }
}

void StatedFrame::read_space(std::string_view space) {
    constexpr std::size_t longest = 32;  // no frame is as long; kept for messages
    space = space.substr(0, longest);
    if (first_.empty()) {
        first_ = space;
    } else if (other_.empty() && !space.empty() && space != first_) {
        other_ = space;
    }
}

void StatedFrame::give(const FileSource& source, MeshFile& mesh) const {
    if (!other_.empty()) {
        mesh.warnings.push_back(source.name() + ": states the patient frame '" + printable(first_) + "' and then '" +
                                printable(other_) + "', so that neither is taken");
        return;
    }
    for (const PatientFrame frame : {PatientFrame::lps, PatientFrame::ras}) {
        if (first_ == name_of(frame)) {
            mesh.patient_frame = frame;
        }
    }
}

void give_stated_frame(std::string_view header, const FileSource& source, MeshFile& mesh) {
    StatedFrame frame;
    frame.read_header(header);
    frame.give(source, mesh);
}

}  // namespace lamella
