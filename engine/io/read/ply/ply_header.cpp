#include <initializer_list>

#include "base/words.hpp"
#include "io/read/ply/ply.hpp"

namespace lamella {

namespace {

/// Limits what is kept of a header, which may be of any length.
constexpr std::size_t most_declarations = 4096;

constexpr std::string_view magic = "ply";

std::optional<NumberType> type_named(std::string_view name) {
    constexpr std::string_view none = " ";  // is no word
    constexpr std::array names = {
        std::array<std::string_view, 10>{"char", "uchar", "short", "ushort", "int", "uint", none, none, "float", "double"},
        std::array<std::string_view, 10>{"int8", "uint8", "int16", "uint16", "int32", "uint32", none, none, "float32",
                                         "float64"}};
    for (const auto& each : names) {
        if (const auto* const found = std::find(each.begin(), each.end(), name); found != each.end()) {
            return static_cast<NumberType>(found - each.begin());
        }
    }
    return std::nullopt;
}

/// Header lines, word by word.
class HeaderParser {
public:
    explicit HeaderParser(std::string_view text) : text_(text) {}

    PlyHeader parse() {
        // The first line tells how lines end: after CR alone, an LF after "end_header" is data.
        const std::size_t first = text_.find_first_of("\r\n");
        if (first != std::string_view::npos && text_[first] == '\r' && text_.substr(first + 1, 1) != "\n") {
            line_end_ = '\r';
        }
        next_ = text_.size() - without_byte_order_mark(text_).size();
        next_line();
        if (word() != magic || !word().empty()) {
            throw expected("'ply' alone on the first line");
        }
        do {
            next_line();
        } while (line());
        header_.body = next_;
        return std::move(header_);
    }

    /// The first line skipped that declares a property, if it had the keyword.
    const std::optional<TextError>& lost_property() const { return lost_property_; }

private:
    void next_line() {
        if (next_ == text_.size()) {
            throw TextError{text_.data() + next_, "expected 'end_header', found the end of the file"};
        }
        const std::size_t end = std::min(text_.find(line_end_, next_), text_.size());
        p_ = text_.data() + next_;
        end_ = text_.data() + end;
        next_ = std::min(end + 1, text_.size());
    }

    /// False: the header ends.
    bool line() {
        const std::string_view keyword = word();
        if (keyword == "comment" || keyword == "obj_info") {
            header_.patient_frame.read_header({p_, static_cast<std::size_t>(end_ - p_)});
            return true;
        }
        if (keyword == "end_header" && !has_format_) {
            throw expected("a line 'format' before it");
        }
        if (keyword == "format") {
            format();
        } else if (keyword == "element") {
            element();
        } else if (keyword == "property") {
            property();
        } else if (keyword != "end_header") {
            other_line(keyword);
            return true;
        }
        if (!word().empty()) {
            throw expected("the end of the line");
        }
        return keyword != "end_header";
    }

    /// Skips a line without a keyword, as a comment is that goes on in the next line. Not numbers, with which the body
    /// begins, and not what may be a keyword in capitals.
    void other_line(std::string_view first) {
        if (first.empty()) {
            return;
        }
        const std::string_view line(word_, static_cast<std::size_t>(end_ - word_));
        const bool is_keyword = begins_in_any_case(first, "element") || begins_in_any_case(first, "propert") ||
                                begins_in_any_case(first, "end_head") || lower_case(first.substr(0, 16)) == "format";
        const bool begins_body = is_digit(first[0]) || first[0] == '-' || first[0] == '+' || first[0] == '.';
        const TextError error = expected("'element', 'property', 'comment' or 'end_header'");
        if (is_keyword || begins_body || !is_text(line)) {
            throw error;
        }
        if (!lost_property_ && (first == "list" || type_named(first))) {
            lost_property_ = error;
        }
        header_.skipped.add(word_);
    }

    void format() {
        constexpr std::array<std::string_view, 3> names = {"ascii", "binary_little_endian", "binary_big_endian"};
        if (std::exchange(has_format_, true)) {
            throw expected("one format only");
        }
        const auto* const found = std::find(names.begin(), names.end(), word());
        if (found == names.end()) {
            throw expected("'ascii', 'binary_little_endian' or 'binary_big_endian'");
        }
        header_.encoding = static_cast<PlyEncoding>(found - names.begin());
        if (word() != "1.0") {
            throw expected("version '1.0'");
        }
    }

    void element() {
        PlyElement element;
        element.at = word_;
        element.name = name();
        if (!read_integer(word(), element.count)) {
            throw expected("the number of elements " + in_quotes(element.name));
        }
        header_.elements.push_back(std::move(element));
    }

    void property() {
        PlyProperty property;
        if (header_.elements.empty()) {
            throw expected("an element before its properties");
        }
        const char* const before = p_;
        property.is_list = word() == "list";
        if (property.is_list) {
            property.count_type = type();
        } else {
            p_ = before;
        }
        property.type = type();
        property.name = name();
        header_.elements.back().properties.push_back(property);
    }

    NumberType type() {
        if (const std::optional<NumberType> found = type_named(word())) {
            return *found;
        }
        throw expected("a type of number");
    }

    /// Of an element or a property.
    std::string_view name() {
        if (++declarations_ > most_declarations) {
            throw expected("at most " + std::to_string(most_declarations) + " elements and properties");
        }
        if (const std::string_view name = word(); !name.empty()) {
            return name;
        }
        throw expected("a name");
    }

    std::string_view word() {
        word_ = skip_space(p_, end_);
        p_ = skip_word(word_, end_);
        return {word_, static_cast<std::size_t>(p_ - word_)};
    }

    /// At the last word read.
    TextError expected(const std::string& what) const {
        const bool at_line_end = word_ == end_ && word_ != text_.data() + text_.size();
        return {word_, "expected " + what + ", found " + (at_line_end ? "the end of the line" : word_at(word_, end_))};
    }

    std::string_view text_;
    PlyHeader header_;
    std::size_t next_ = 0;        // where the next line begins
    char line_end_ = '\n';        // a CR before it is white space
    const char* p_ = nullptr;     // within the line
    const char* end_ = nullptr;   // of the line
    const char* word_ = nullptr;  // the last one read
    std::size_t declarations_ = 0;
    bool has_format_ = false;
    std::optional<TextError> lost_property_;
};

// --- which elements make up the mesh

/// The property of any of these names gets the use.
void find_property(PlyElement& element, std::initializer_list<std::string_view> names, PlyUse use) {
    const std::string place = " of element " + in_quotes(element.name) + " ";
    const bool is_list = use == PlyUse::indices;
    for (const std::string_view name : names) {
        const auto named = [name](const PlyProperty& p) { return p.name == name; };
        const auto found = std::find_if(element.properties.begin(), element.properties.end(), named);
        if (found == element.properties.end()) {
            continue;
        }
        if (found->is_list != is_list) {
            throw TextError{element.at, "property " + in_quotes(name) + place + (is_list ? "is no list" : "is a list")};
        }
        if (std::any_of(found + 1, element.properties.end(), named)) {
            throw TextError{element.at, "property " + in_quotes(name) + place + "is declared twice"};
        }
        found->use = use;
        return;
    }
    throw TextError{element.at, "element " + in_quotes(element.name) + " has no property " + in_quotes(*names.begin())};
}

void find_roles(PlyHeader& header, bool scalars) {
    constexpr std::array<std::string_view, 3> names = {"vertex", "face", "tristrips"};  // in the order of PlyRole
    for (PlyElement& element : header.elements) {
        const auto* const found = std::find(names.begin(), names.end(), element.name);
        const auto role = static_cast<PlyRole>(found - names.begin());
        if (role == PlyRole::nothing || element.count == 0) {
            continue;
        }
        if (header.element_of(role) != nullptr) {
            throw TextError{element.at, "element " + in_quotes(element.name) + " is declared twice"};
        }
        element.role = role;
        if (role == PlyRole::vertices) {
            find_property(element, {"x"}, PlyUse::x);
            find_property(element, {"y"}, PlyUse::y);
            find_property(element, {"z"}, PlyUse::z);
            for (PlyProperty& property : element.properties) {
                const bool is_free = property.use == PlyUse::nothing && !property.is_list;
                property.use = scalars && is_free ? PlyUse::scalar : property.use;
            }
        } else {
            find_property(element, {"vertex_indices", "vertex_index"}, PlyUse::indices);
        }
    }
}

}  // namespace

std::size_t PlyElement::row_bytes(std::optional<PlyUse> before) const noexcept {
    std::size_t bytes = 0;
    for (const PlyProperty& property : properties) {
        if (property.use == before) {
            break;
        }
        bytes += size_of(property.is_list ? property.count_type : property.type);
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

std::string PlyHeader::why_too_many(const PlyElement& element, std::uint64_t left) const {
    const bool text = encoding == PlyEncoding::ascii;  // a digit and a space for each, but for the last in the file
    const std::uint64_t row = text ? 2 * element.properties.size() : element.row_bytes();
    return row == 0 || element.count <= (left + (text ? 1 : 0)) / row
               ? ""
               : "the header counts " + std::to_string(element.count) + " of element " + in_quotes(element.name) + ", but " +
                     std::to_string(left) + " bytes are left";
}

void PlyHeader::describe(const FileSource& file, std::string_view contents, MeshFile& mesh) const {
    if (skipped.count > 0) {
        mesh.warnings.push_back(file.name() + ": ignored " + counted(skipped.count, "line") +
                                " of the header without a keyword" + first_word_words(skipped, contents));
    }
    patient_frame.give(file, mesh);
}

void warn_of_rest(const FileSource& file, std::uint64_t bytes, MeshFile& mesh) {
    if (bytes > 0) {
        mesh.warnings.push_back(file.name() + ": ignored " + counted(bytes, "byte") + " after the last element");
    }
}

bool looks_like_ply(const FileSource& source) {
    const std::string_view text = without_byte_order_mark(source.sample());
    return text.starts_with(magic) && text.size() > magic.size() && is_space(text[magic.size()]);
}

PlyHeader parse_ply_header(const FileSource& file, std::string_view text) {
    HeaderParser parser(text);
    PlyHeader header = parser.parse();
    // Without it, binary rows would have other sizes, and what is missing may be the mesh.
    const std::optional<TextError>& lost = parser.lost_property();
    if (lost && header.encoding != PlyEncoding::ascii) {
        throw *lost;
    }
    try {
        find_roles(header, file.scalars());
    } catch (const TextError& error) {
        throw lost.value_or(error);
    }
    if (header.element_of(PlyRole::faces) == nullptr && header.element_of(PlyRole::strips) == nullptr) {
        file.refuse(ErrorCode::empty_mesh, "holds no faces");
    }
    if (header.element_of(PlyRole::vertices) == nullptr) {
        file.refuse(ErrorCode::malformed_mesh, "holds faces but no vertices");
    }
    return header;
}

Number number_for(const PlyElement& vertices) noexcept {
    const bool wide = std::any_of(vertices.properties.begin(), vertices.properties.end(), [](const PlyProperty& p) {
        return p.use <= PlyUse::z &&
               (p.type == NumberType::float64 || p.type == NumberType::int32 || p.type == NumberType::uint32);
    });
    return wide ? Number::f64 : Number::f32;
}

}  // namespace lamella
