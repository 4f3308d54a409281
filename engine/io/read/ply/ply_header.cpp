#include "io/read/ply/ply_header.hpp"

#include <algorithm>
#include <charconv>
#include <optional>

#include "io/read/reader.hpp"
#include "io/text/text.hpp"

namespace lamella {

namespace {

/// Limits what is kept of a header, which may be of any length.
constexpr std::size_t most_declarations = 4096;

constexpr std::string_view magic = "ply";

std::optional<PlyType> type_named(std::string_view name) {
    struct Named {
        std::string_view name;
        PlyType type;
    };
    constexpr std::array names = {
        Named{"char", PlyType::int8},      Named{"int8", PlyType::int8},       Named{"uchar", PlyType::uint8},
        Named{"uint8", PlyType::uint8},    Named{"short", PlyType::int16},     Named{"int16", PlyType::int16},
        Named{"ushort", PlyType::uint16},  Named{"uint16", PlyType::uint16},   Named{"int", PlyType::int32},
        Named{"int32", PlyType::int32},    Named{"uint", PlyType::uint32},     Named{"uint32", PlyType::uint32},
        Named{"float", PlyType::float32},  Named{"float32", PlyType::float32}, Named{"double", PlyType::float64},
        Named{"float64", PlyType::float64}};
    const auto* const found = std::find_if(names.begin(), names.end(), [name](const Named& n) { return n.name == name; });
    return found == names.end() ? std::nullopt : std::optional(found->type);
}

/// Header lines, word by word.
class HeaderParser {
public:
    HeaderParser(std::string_view text, PlyHeader& header, PlyProblem& problem)
        : text_(text), header_(header), problem_(problem) {}

    bool parse();

    /// The first line skipped that declares a property, if it had the keyword.
    const std::optional<PlyProblem>& lost_property() const { return lost_property_; }

private:
    bool next_line();
    bool line(bool& ended);
    bool other_line(std::string_view first);
    bool format();
    bool element();
    bool property();
    bool type(PlyType& type);
    bool name(std::string_view& name);
    bool declare();
    bool end_of_line();
    std::string_view word();
    bool fail(const std::string& expected);

    std::string_view text_;
    PlyHeader& header_;
    PlyProblem& problem_;
    std::size_t next_ = 0;        // where the next line begins
    char line_end_ = '\n';        // a CR before it is white space
    const char* p_ = nullptr;     // within the line
    const char* end_ = nullptr;   // of the line
    const char* word_ = nullptr;  // the last one read
    std::size_t declarations_ = 0;
    bool has_format_ = false;
    std::optional<PlyProblem> lost_property_;
};

bool HeaderParser::parse() {
    // The first line tells how lines end: after CR alone, an LF after "end_header" is data.
    const std::size_t first = text_.find_first_of("\r\n");
    if (first != std::string_view::npos && text_[first] == '\r' && text_.substr(first + 1, 1) != "\n") {
        line_end_ = '\r';
    }
    next_ = text_.size() - without_byte_order_mark(text_).size();
    next_line();
    if (word() != magic || !end_of_line()) {
        return fail("'ply' alone on the first line");
    }
    for (bool ended = false; !ended;) {
        if (!next_line()) {
            problem_ = {text_.size(), "expected 'end_header', found the end of the file", ErrorCode::malformed_mesh};
            return false;
        }
        if (!line(ended)) {
            return false;
        }
    }
    header_.body = next_;
    return true;
}

bool HeaderParser::next_line() {
    if (next_ == text_.size()) {
        return false;
    }
    const std::size_t end = std::min(text_.find(line_end_, next_), text_.size());
    p_ = text_.data() + next_;
    end_ = text_.data() + end;
    next_ = std::min(end + 1, text_.size());
    return true;
}

bool HeaderParser::line(bool& ended) {
    const std::string_view keyword = word();
    if (keyword == "comment" || keyword == "obj_info") {
        header_.patient_frame.read_header({p_, static_cast<std::size_t>(end_ - p_)});
        return true;
    }
    if (keyword == "format") {
        return format();
    }
    if (keyword == "element") {
        return element();
    }
    if (keyword == "property") {
        return property();
    }
    ended = keyword == "end_header";
    if (ended && !has_format_) {
        return fail("a line 'format' before it");
    }
    return ended ? end_of_line() : keyword.empty() || other_line(keyword);
}

/// Skips a line without a keyword, as a comment is that goes on in the next line. Not numbers, with which the body begins,
/// and not what may be a keyword in capitals.
bool HeaderParser::other_line(std::string_view first) {
    const std::string_view line(word_, static_cast<std::size_t>(end_ - word_));
    const bool is_keyword = begins_in_any_case(first, "element") || begins_in_any_case(first, "propert") ||
                            begins_in_any_case(first, "end_head") || lower_case(first.substr(0, 16)) == "format";
    const bool begins_body = is_digit(first.front()) || first.front() == '-' || first.front() == '+' || first.front() == '.';
    (void)fail("'element', 'property', 'comment' or 'end_header'");
    if (is_keyword || begins_body || !is_text(line)) {
        return false;
    }
    if (!lost_property_ && (first == "list" || type_named(first))) {
        lost_property_ = problem_;
    }
    header_.skipped.add(word_);
    return true;
}

bool HeaderParser::format() {
    constexpr std::array<std::string_view, 3> names = {"ascii", "binary_little_endian", "binary_big_endian"};
    if (has_format_) {
        return fail("one format only");
    }
    has_format_ = true;
    const auto* const found = std::find(names.begin(), names.end(), word());
    if (found == names.end()) {
        return fail("'ascii', 'binary_little_endian' or 'binary_big_endian'");
    }
    header_.encoding = static_cast<PlyEncoding>(found - names.begin());
    return word() == "1.0" ? end_of_line() : fail("version '1.0'");
}

bool HeaderParser::element() {
    PlyElement element;
    element.offset = static_cast<std::size_t>(word_ - text_.data());
    if (!declare() || !name(element.name)) {
        return false;
    }
    const std::string_view digits = word();
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), element.count);
    if (digits.empty() || error != std::errc() || end != digits.data() + digits.size()) {
        return fail("the number of elements " + short_name(element.name));
    }
    header_.elements.push_back(std::move(element));
    return end_of_line();
}

bool HeaderParser::property() {
    PlyProperty property;
    if (header_.elements.empty()) {
        return fail("an element before its properties");
    }
    if (!declare()) {
        return false;
    }
    const char* const before = p_;
    property.is_list = word() == "list";
    if (!property.is_list) {
        p_ = before;
    } else if (!type(property.count_type)) {
        return false;
    }
    if (!type(property.type) || !name(property.name)) {
        return false;
    }
    header_.elements.back().properties.push_back(property);
    return end_of_line();
}

bool HeaderParser::type(PlyType& type) {
    const std::optional<PlyType> found = type_named(word());
    type = found.value_or(PlyType::int8);
    return found || fail("a type of number");
}

bool HeaderParser::name(std::string_view& name) {
    name = word();
    return !name.empty() || fail("a name");
}

bool HeaderParser::declare() {
    return ++declarations_ <= most_declarations ||
           fail("at most " + std::to_string(most_declarations) + " elements and properties");
}

bool HeaderParser::end_of_line() {
    return word().empty() || fail("the end of the line");
}

std::string_view HeaderParser::word() {
    word_ = skip_space(p_, end_);
    p_ = skip_word(word_, end_);
    return {word_, static_cast<std::size_t>(p_ - word_)};
}

/// At the last word read.
bool HeaderParser::fail(const std::string& expected) {
    const bool at_end = word_ == text_.data() + text_.size();
    problem_ = {static_cast<std::size_t>(word_ - text_.data()),
                "expected " + expected + ", found " +
                    (word_ == end_ && !at_end ? std::string("the end of the line") : word_at(word_, end_)),
                ErrorCode::malformed_mesh};
    return false;
}

// --- which elements make up the mesh

/// The property of any of these names; null, and `what` says so, where there is none or more than one.
PlyProperty* find_property(PlyElement& element, std::initializer_list<std::string_view> names, bool is_list,
                           std::string& what) {
    const std::string place = " of element " + short_name(element.name) + " ";
    for (const std::string_view name : names) {
        const auto named = [name](const PlyProperty& p) { return p.name == name; };
        const auto found = std::find_if(element.properties.begin(), element.properties.end(), named);
        if (found == element.properties.end()) {
            continue;
        }
        if (found->is_list != is_list) {
            what = "property " + short_name(name) + place + (is_list ? "is no list" : "is a list");
            return nullptr;
        }
        if (std::any_of(found + 1, element.properties.end(), named)) {
            what = "property " + short_name(name) + place + "is declared twice";
            return nullptr;
        }
        return &*found;
    }
    what = "element " + short_name(element.name) + " has no property " + short_name(*names.begin());
    return nullptr;
}

bool find_uses(PlyElement& element, std::string& what) {
    if (element.role == PlyRole::vertices) {
        constexpr std::array<std::string_view, 3> axes = {"x", "y", "z"};
        for (std::size_t axis = 0; axis < axes.size(); ++axis) {
            PlyProperty* const property = find_property(element, {axes[axis]}, false, what);
            if (property == nullptr) {
                return false;
            }
            property->use = static_cast<PlyUse>(axis);
        }
        return true;
    }
    PlyProperty* const property = find_property(element, {"vertex_indices", "vertex_index"}, true, what);
    if (property != nullptr) {
        property->use = PlyUse::indices;
    }
    return property != nullptr;
}

bool find_roles(PlyHeader& header, PlyProblem& problem) {
    constexpr std::array<std::string_view, 3> names = {"vertex", "face", "tristrips"};  // in the order of PlyRole
    for (PlyElement& element : header.elements) {
        const auto* const found = std::find(names.begin(), names.end(), element.name);
        const auto role = static_cast<PlyRole>(found - names.begin());
        if (role == PlyRole::nothing || element.count == 0) {
            continue;
        }
        problem.offset = element.offset;
        if (header.element_of(role) != nullptr) {
            problem.what = "element " + short_name(element.name) + " is declared twice";
            return false;
        }
        element.role = role;
        if (!find_uses(element, problem.what)) {
            return false;
        }
    }
    return true;
}

}  // namespace

std::string short_name(std::string_view name) {
    constexpr std::size_t longest = 32;
    return "'" + printable(name.substr(0, longest)) + (name.size() > longest ? "...'" : "'");
}

std::uint64_t PlyElement::least_row_bytes(PlyEncoding encoding) const noexcept {
    std::uint64_t bytes = 0;
    for (const PlyProperty& property : properties) {
        bytes += encoding == PlyEncoding::ascii ? 2 : size_of(property.is_list ? property.count_type : property.type);
    }
    return bytes;
}

bool PlyElement::has_lists() const noexcept {
    return std::any_of(properties.begin(), properties.end(), [](const PlyProperty& p) { return p.is_list; });
}

const PlyProperty& PlyElement::used(PlyUse use) const noexcept {
    return *std::find_if(properties.begin(), properties.end(), [use](const PlyProperty& p) { return p.use == use; });
}

const PlyElement* PlyHeader::element_of(PlyRole role) const noexcept {
    const auto found =
        std::find_if(elements.begin(), elements.end(), [role](const PlyElement& e) { return e.role == role; });
    return found == elements.end() ? nullptr : &*found;
}

bool begins_as_ply(std::string_view text) noexcept {
    text = without_byte_order_mark(text);
    return text.starts_with(magic) && text.size() > magic.size() && is_space(text[magic.size()]);
}

bool parse_ply_header(std::string_view text, PlyHeader& header, PlyProblem& problem) {
    HeaderParser parser(text, header, problem);
    if (!parser.parse()) {
        return false;
    }
    // Without it, binary rows would have other sizes, and what is missing may be the mesh.
    const bool found = find_roles(header, problem);
    if (parser.lost_property() && (!found || header.encoding != PlyEncoding::ascii)) {
        problem = *parser.lost_property();
        return false;
    }
    return found;
}

}  // namespace lamella
