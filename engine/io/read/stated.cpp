#include "io/read/stated.hpp"

#include <array>
#include <iterator>
#include <unordered_map>
#include <unordered_set>

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

/// The first `most` characters of UTF-8.
std::string first_characters(const std::string& text, std::size_t most) {
    std::size_t characters = 0;
    const auto end = std::find_if(text.begin(), text.end(), [&](char c) {
        return (static_cast<unsigned char>(c) & 0xc0U) != 0x80 && characters++ == most;
    });
    return {text.begin(), end};
}

constexpr std::size_t most_parts = 65'536;

PartMarks of_kind(const PartMarks& all, bool group, bool go_on) {
    PartMarks marks;
    std::copy_if(all.begin(), all.end(), std::back_inserter(marks), [&](const PartMark& mark) {
        return mark.group == group && (!go_on || marks.empty() || marks.back().name != mark.name);
    });
    if (!marks.empty() && marks.front().triangle > 0) {
        marks.insert(marks.begin(), PartMark{0, group, ""});
    }
    return marks;
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

// --- Parts

std::string_view name_of(PartRole role) noexcept {
    constexpr std::array<std::string_view, 6> names = {"solid",           "negative volume",  "modifier",
                                                       "support blocker", "support enforcer", "support"};
    return names[static_cast<std::size_t>(role)];
}

std::vector<Part> parts_of(const MeshFile& file) {
    std::vector<Part> parts;
    for (const MeshPart& part : file.parts) {
        MeshView view = file.view();
        if (part.role != PartRole::solid && part.first_triangle == 0) {
            continue;  // left out
        }
        const auto first = static_cast<std::size_t>(part.first_triangle);
        (view.indices != nullptr ? view.indices : view.vertices) =
            view.indices != nullptr ? view.indices_at(first) : view.vertex_at(first);
        view.triangle_count = static_cast<std::size_t>(part.triangle_count);
        parts.push_back({.mesh = view, .role = part.role, .object = part.object});
    }
    if (parts.empty()) {
        parts.push_back({.mesh = file.view()});
    }
    return parts;
}

std::vector<std::string> distinct_names(std::span<const std::string> names, std::size_t most_characters) {
    std::unordered_set<std::string> taken;
    std::unordered_map<std::string, std::size_t> uses;
    std::vector<std::string> distinct;
    for (const std::string& name : names) {
        const std::string cut = first_characters(name, most_characters);
        std::string own = cut;
        for (std::size_t& use = uses[cut]; !taken.insert(own).second;) {
            use = std::max<std::size_t>(use + 1, 2);
            const std::string number = " (" + std::to_string(use) + ")";
            own = first_characters(cut, most_characters - number.size()) + number;
        }
        distinct.push_back(own);
    }
    return distinct;
}

void add_mark(PartMarks& marks, std::uint64_t triangle, bool group, const char* begin, const char* end) {
    begin = skip_space(begin, end);
    while (end != begin && is_space(end[-1])) {
        --end;
    }
    if (marks.size() <= most_parts) {
        marks.push_back({triangle, group, {begin, static_cast<std::size_t>(end - begin)}});
    }
}

void add_marks(PartMarks& marks, const PartMarks& next, std::uint64_t first) {
    for (const PartMark& mark : next) {
        add_mark(marks, first + mark.triangle, mark.group, mark.name.data(), mark.name.data() + mark.name.size());
    }
}

void give_parts(const PartMarks& all, bool go_on, const std::string& file, MeshFile& mesh) {
    if (all.size() > most_parts) {
        mesh.warnings.push_back(file + ": names more than " + std::to_string(most_parts) +
                                " parts, which are not told apart");
        return;
    }
    PartMarks marks = of_kind(all, false, go_on);
    if (PartMarks groups = of_kind(all, true, go_on); marks.size() < 2 && groups.size() > marks.size()) {
        marks = std::move(groups);
    }
    std::uint64_t begin = 0;
    for (std::size_t i = 0; i < marks.size(); ++i) {
        const std::uint64_t end = i + 1 < marks.size() ? marks[i + 1].triangle : mesh.triangle_count;
        if (end > begin) {
            const std::string number = "part " + std::to_string(mesh.parts.size() + 1);
            mesh.parts.push_back(
                {marks[i].name.empty() ? number : std::string(marks[i].name), PartRole::solid, begin, end - begin});
            begin = end;
        }
    }
}

}  // namespace lamella
