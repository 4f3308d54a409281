// Vertices and triangles as nearly every program writes them, read without the XML parser, which takes several times as
// long.

#include "io/read/three_mf/three_mf_part.hpp"

namespace lamella::three_mf {

namespace {

/// Without a prefix or attributes, so that names in them that have none either are of the same namespace.
constexpr std::array<std::string_view, 2> list_tags = {"<vertices>", "<triangles>"};

/// An element without content whose three attributes come in this order: what stands before each of their values.
using PlainForm = std::array<std::string_view, 3>;
constexpr PlainForm plain_vertex = {"<vertex x=\"", "\" y=\"", "\" z=\""};
constexpr PlainForm plain_triangle = {"<triangle v1=\"", "\" v2=\"", "\" v3=\""};

/// Skips white space and counts its line ends. Stops at a CR without LF, which is a line end too.
const char* skip_lines(const char* p, const char* end, std::uint64_t& lines) {
    while (p != end && (*p == ' ' || *p == '\n' || *p == '\t' || (*p == '\r' && p + 1 != end && p[1] == '\n'))) {
        lines += static_cast<std::uint64_t>(*p++ == '\n');
    }
    return p;
}

/// Reads the values of the element at `p` and returns where it ends; null if it has another form or is cut off. It holds no
/// line end: between values the form has none, and a value with one, or with markup, is no number.
const char* read_element(const char* p, const char* end, const PlainForm& form, std::array<std::string_view, 3>& values) {
    const auto left = [&p, end] { return std::string_view(p, static_cast<std::size_t>(end - p)); };
    for (std::size_t i = 0; i < form.size(); ++i) {
        if (!left().starts_with(form[i])) {
            return nullptr;
        }
        p += form[i].size();
        std::string_view& value = values[i];
        value = left().substr(0, left().find('"'));
        if (value.empty() || is_space(value.front()) || is_space(value.back())) {
            return nullptr;
        }
        p += value.size();
    }
    for (const std::string_view last : {"\"/>", "\" />"}) {
        if (left().starts_with(last)) {
            return p + last.size();
        }
    }
    return nullptr;
}

}  // namespace

bool PartReader::feed_part(std::string_view piece) {
    while (!piece.empty()) {
        if (plain_list_ && in_list() && parsed_ == fed_) {
            std::uint64_t lines = 0;
            const std::size_t plain = read_plain_elements(piece, lines);
            skip(piece.substr(0, plain), lines);
            parsed_ = fed_ += plain;
            piece.remove_prefix(plain);
            plain_list_ = piece.find('>') == std::string_view::npos;  // else what follows is whole, and not of that form
        }
        const std::string_view head = piece.substr(0, feed_length(piece));
        if (!feed(head)) {
            return false;
        }
        fed_ += head.size();
        piece.remove_prefix(head.size());
        plain_list_ |= in_list() && parsed_ == fed_ &&
                       std::any_of(list_tags.begin(), list_tags.end(), [&](auto tag) { return head.ends_with(tag); });
    }
    return true;
}

/// How much the parser is given at once: up to where an element of a list may begin.
std::size_t PartReader::feed_length(std::string_view piece) const noexcept {
    if (plain_list_) {
        return std::min(piece.size(), piece.find('>')) + 1;
    }
    for (std::size_t at = piece.find('<'); at != std::string_view::npos; at = piece.find('<', at + 1)) {
        for (const std::string_view tag : list_tags) {
            if (piece.substr(at).starts_with(tag)) {
                return at + tag.size();
            }
        }
    }
    return piece.size();
}

/// Returns the bytes of the elements that were read, and adds their lines. Anything unusual is left to the XML parser, which
/// reports errors.
std::size_t PartReader::read_plain_elements(std::string_view piece, std::uint64_t& lines) {
    const char* const end = piece.data() + piece.size();
    const char* done = piece.data();
    std::array<std::string_view, 3> values;
    for (;;) {
        std::uint64_t line_ends = 0;
        const bool vertices = state_ == State::vertices;
        const char* const p =
            read_element(skip_lines(done, end, line_ends), end, vertices ? plain_vertex : plain_triangle, values);
        if (p == nullptr || !(vertices ? add_plain_vertex(values) : add_plain_triangle(values))) {
            return static_cast<std::size_t>(done - piece.data());
        }
        lines += line_ends;
        done = p;
    }
}

bool PartReader::add_plain_vertex(const std::array<std::string_view, 3>& values) {
    Vertex vertex{};
    ChunkList<Vertex>& vertices = object().vertices;
    if (number_in(values[0], vertex.x) != NumberText::read || number_in(values[1], vertex.y) != NumberText::read ||
        number_in(values[2], vertex.z) != NumberText::read || !budget_.try_take(vertices.next_bytes(), 1)) {
        return false;
    }
    vertices.push_back(vertex);
    return true;
}

bool PartReader::add_plain_triangle(const std::array<std::string_view, 3>& values) {
    Triangle triangle{};
    ChunkList<Triangle>& triangles = object().triangles;
    for (std::size_t corner = 0; corner < 3; ++corner) {
        if (!integer_in(values[corner], triangle[corner]) || triangle[corner] >= object().vertices.size()) {
            return false;
        }
    }
    if (!budget_.try_take(triangles.next_bytes(), 1)) {
        return false;
    }
    triangles.push_back(triangle);
    return true;
}

}  // namespace lamella::three_mf
