#include "io/read/vtk/vtp_document.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <charconv>
#include <string>
#include <utility>
#include <vector>

#include "io/text/text.hpp"
#include "io/xml/xml.hpp"

namespace lamella {

namespace {

struct VtpTypeName {
    std::string_view name;
    NumberType type;
};

constexpr std::array vtp_type_names = {
    VtpTypeName{"Int8", NumberType::int8},       VtpTypeName{"UInt8", NumberType::uint8},
    VtpTypeName{"Int16", NumberType::int16},     VtpTypeName{"UInt16", NumberType::uint16},
    VtpTypeName{"Int32", NumberType::int32},     VtpTypeName{"UInt32", NumberType::uint32},
    VtpTypeName{"Int64", NumberType::int64},     VtpTypeName{"UInt64", NumberType::uint64},
    VtpTypeName{"Float32", NumberType::float32}, VtpTypeName{"Float64", NumberType::float64},
};

/// Elements that matter, and where.
enum class Element : std::uint8_t { document, file, poly_data, field_data, piece, points, polys, strips, array, other };

struct Nesting {
    Element parent;
    std::string_view name;
    Element element;
};

constexpr std::array nestings = {
    Nesting{Element::document, "VTKFile", Element::file},
    Nesting{Element::file, "PolyData", Element::poly_data},
    Nesting{Element::poly_data, "FieldData", Element::field_data},
    Nesting{Element::poly_data, "Piece", Element::piece},
    Nesting{Element::piece, "Points", Element::points},
    Nesting{Element::piece, "Polys", Element::polys},
    Nesting{Element::piece, "Strips", Element::strips},
    Nesting{Element::points, "DataArray", Element::array},
    Nesting{Element::polys, "DataArray", Element::array},
    Nesting{Element::strips, "DataArray", Element::array},
    Nesting{Element::field_data, "Array", Element::array},
};

Element element_in(Element parent, std::string_view name) {
    const auto* const found = std::find_if(nestings.begin(), nestings.end(), [&](const Nesting& nesting) {
        return nesting.parent == parent && nesting.name == name;
    });
    return found == nestings.end() ? Element::other : found->element;
}

/// For messages.
std::string_view name_in(Element parent, bool connectivity) {
    switch (parent) {
        case Element::points:
            return "Points";
        case Element::polys:
            return connectivity ? "connectivity of Polys" : "offsets of Polys";
        case Element::strips:
            return connectivity ? "connectivity of Strips" : "offsets of Strips";
        default:
            return "SPACE";
    }
}

std::string quoted(std::string_view value) {
    return "'" + printable(value.substr(0, 32)) + (value.size() > 32 ? "...'" : "'");
}

class Parser : public XmlReader {
public:
    explicit Parser(VtkFile& file) : file_(file) {}

    Result<VtpDocument> read();

private:
    void begin_element(const XmlName& name, const XmlAttributes& attributes) override;
    void end_element(const XmlName& name) override;
    void text(std::string_view /*piece*/) override {}  // that of arrays is found by its place

    bool feed_all();
    std::size_t skippable(std::string_view rest) const;

    void begin_file(const XmlAttributes& attributes);
    void begin_piece(const XmlAttributes& attributes);
    void begin_array(Element parent, const XmlAttributes& attributes);
    void begin_appended(const XmlAttributes& attributes);
    std::optional<VtpArray>* wanted_array(Element parent, const XmlAttributes& attributes);
    bool read_count(const XmlAttributes& attributes, std::string_view name, std::uint64_t& count);
    bool read_type(Element parent, const XmlAttributes& attributes, VtpArray& array);
    bool read_format(const XmlAttributes& attributes, VtpArray& array);
    void end_content();

    /// The value of an attribute that must be one of two; the first if it is absent. False: it is neither.
    bool choose(const XmlAttributes& attributes, std::string_view name, std::string_view first, std::string_view second,
                bool& is_second);

    VtkFile& file_;
    VtpDocument document_;
    std::vector<Element> open_{Element::document};
    std::uint64_t tag_end_ = 0;     ///< of the last element that began
    VtpArray* array_ = nullptr;     ///< whose content has not ended
    std::uint64_t content_ = 0;     ///< where it began
    std::optional<Error> refusal_;  ///< an error that does not concern the XML
};

Result<VtpDocument> Parser::read() {
    if (feed_all()) {
        finish();
    }
    if (failure()) {
        return file_.error_at(file_.text.data() + failure()->offset, failure()->what);
    }
    if (refusal_) {
        return *refusal_;
    }
    document_.unbound_name = unbound_name();
    return std::move(document_);
}

/// Feeds everything but the numbers of arrays: expat would take longer to pass over them than they take to be read.
bool Parser::feed_all() {
    constexpr std::size_t window = std::size_t{64} << 10;  // appended data, which end parsing, are not searched for tags
    std::string_view rest = file_.text;
    while (!rest.empty()) {
        file_.source.parallel().stop_if_asked();
        const std::string_view ahead = rest.substr(0, window);
        const std::size_t tag_end = ahead.find('>', ahead.find("<DataArray"));
        const std::string_view head = ahead.substr(0, tag_end == std::string_view::npos ? tag_end : tag_end + 1);
        if (!feed(head)) {
            return false;
        }
        rest.remove_prefix(head.size());
        const std::string_view numbers = rest.substr(0, skippable(rest));
        skip(numbers);
        rest.remove_prefix(numbers.size());
    }
    return true;
}

/// How much of `rest` is text of the element that has just begun, if it holds no markup or entities.
std::size_t Parser::skippable(std::string_view rest) const {
    constexpr std::size_t grain = std::size_t{256} << 10;
    if (file_.offset_of(rest.data()) != tag_end_) {
        return 0;
    }
    const std::size_t length = rest.find('<');
    if (length == std::string_view::npos) {
        return 0;
    }
    std::atomic<bool> plain{true};
    file_.source.parallel().run_ranges(length, grain, [&](std::size_t begin, std::size_t end, int) {
        if (!is_plain_xml_text(rest.substr(begin, end - begin))) {
            plain.store(false, std::memory_order_relaxed);
        }
    });
    return plain ? length : 0;
}

void Parser::begin_element(const XmlName& name, const XmlAttributes& attributes) {
    end_content();
    tag_end_ = event_end();
    const Element parent = open_.back();
    const Element element = element_in(parent, name.space.empty() ? name.local : std::string_view());
    open_.push_back(element);
    switch (element) {
        case Element::file:
            return begin_file(attributes);
        case Element::piece:
            return begin_piece(attributes);
        case Element::array:
            return begin_array(parent, attributes);
        default:
            break;
    }
    if (parent == Element::document) {
        fail("expected the element VTKFile, found " + quoted(name.local));
    } else if (parent == Element::file && name.local == "AppendedData") {
        begin_appended(attributes);
    }
}

void Parser::end_element(const XmlName& /*name*/) {
    end_content();
    open_.pop_back();
}

/// The content of an array ends with its element or where another one begins in it.
void Parser::end_content() {
    if (VtpArray* const array = std::exchange(array_, nullptr); array != nullptr && event_offset() > content_) {
        array->content = file_.text.substr(content_, event_offset() - content_);
    }
}

bool Parser::choose(const XmlAttributes& attributes, std::string_view name, std::string_view first, std::string_view second,
                    bool& is_second) {
    const std::string_view value = attributes.find(name).value_or(first);
    is_second = value == second;
    if (value == first || is_second) {
        return true;
    }
    fail("expected " + std::string(name) + " " + std::string(first) + " or " + std::string(second) + ", found " +
         quoted(value));
    return false;
}

void Parser::begin_file(const XmlAttributes& attributes) {
    const std::string_view type = attributes.find("type").value_or("");
    if (type != "PolyData") {
        return fail("expected a file of type PolyData, the only one that is read, found " + quoted(type));
    }
    bool wide_headers = false;
    if (choose(attributes, "byte_order", "LittleEndian", "BigEndian", document_.form.big_endian) &&
        choose(attributes, "header_type", "UInt32", "UInt64", wide_headers)) {
        document_.form.header_bytes = wide_headers ? 8 : 4;
        document_.form.compressor = attributes.find("compressor").value_or("");
    }
}

bool Parser::read_count(const XmlAttributes& attributes, std::string_view name, std::uint64_t& count) {
    const std::string_view digits = attributes.find(name).value_or("0");
    const char* const end = digits.data() + digits.size();
    const auto [number_end, failure] = std::from_chars(digits.data(), end, count);
    if (failure != std::errc() || number_end != end) {
        fail("expected a number as " + std::string(name) + ", found " + quoted(digits));
        return false;
    }
    return true;
}

void Parser::begin_piece(const XmlAttributes& attributes) {
    if (Status room = file_.budget.take(1, sizeof(VtpPiece)); !room) {
        refusal_ = room.error();
        return stop();
    }
    VtpPiece& piece = document_.pieces.emplace_back();
    piece.element = event_offset();
    if (!attributes.find("NumberOfPoints")) {
        return fail("expected a Piece with NumberOfPoints");
    }
    if (read_count(attributes, "NumberOfPoints", piece.point_count) &&
        read_count(attributes, "NumberOfPolys", piece.polygons.count)) {
        read_count(attributes, "NumberOfStrips", piece.strips.count);
    }
}

/// Where the array that begins is stored; null if it is not needed.
std::optional<VtpArray>* Parser::wanted_array(Element parent, const XmlAttributes& attributes) {
    const std::string_view name = attributes.find("Name").value_or("");
    if (parent == Element::field_data) {
        return name == "SPACE" ? &document_.space : nullptr;
    }
    VtpPiece& piece = document_.pieces.back();
    if (parent == Element::points) {
        return &piece.points;
    }
    VtpCells& cells = parent == Element::polys ? piece.polygons : piece.strips;
    if (name == "connectivity") {
        return &cells.connectivity;
    }
    return name == "offsets" ? &cells.offsets : nullptr;
}

void Parser::begin_array(Element parent, const XmlAttributes& attributes) {
    std::optional<VtpArray>* const place = wanted_array(parent, attributes);
    if (place == nullptr) {
        return;
    }
    if (place->has_value()) {
        return fail("expected one such DataArray, found a second");
    }
    VtpArray& array = place->emplace();
    array.name = name_in(parent, attributes.find("Name") == "connectivity");
    array.element = event_offset();
    if (parent == Element::points && attributes.find("NumberOfComponents").value_or("3") != "3") {
        return fail("expected Points of 3 components");
    }
    if (!read_type(parent, attributes, array) || !read_format(attributes, array)) {
        return;
    }
    if (is_integer(array.type) || parent == Element::points) {
        array_ = &array;
        content_ = event_end();
        array_->content = file_.text.substr(content_, 0);
    } else {
        fail("expected integers, found numbers of type " + quoted(attributes.find("type").value_or("")));
    }
}

bool Parser::read_type(Element parent, const XmlAttributes& attributes, VtpArray& array) {
    const std::string_view name = attributes.find("type").value_or("");
    const auto* const found = std::find_if(vtp_type_names.begin(), vtp_type_names.end(),
                                           [name](const VtpTypeName& known) { return known.name == name; });
    if (name == "String" && parent == Element::field_data) {
        array.type = NumberType::uint8;  // characters, and a 0 after each string
        return true;
    }
    if (found == vtp_type_names.end()) {
        fail("expected a DataArray of a type from Int8 to Float64, found " + quoted(name));
        return false;
    }
    array.type = found->type;
    return true;
}

bool Parser::read_format(const XmlAttributes& attributes, VtpArray& array) {
    const std::string_view format = attributes.find("format").value_or("ascii");
    if (format == "appended") {
        array.format = VtpArray::Format::appended;
        return read_count(attributes, "offset", array.appended_offset);
    }
    bool binary = false;
    if (!choose(attributes, "format", "ascii", "binary", binary)) {
        return false;
    }
    array.format = binary ? VtpArray::Format::binary : VtpArray::Format::ascii;
    return true;
}

/// Appended data are not XML, so parsing ends here.
void Parser::begin_appended(const XmlAttributes& attributes) {
    if (!choose(attributes, "encoding", "raw", "base64", document_.form.appended_as_base64)) {
        return;
    }
    const std::string_view after = file_.text.substr(event_end());
    const char* const begin = skip_space(after.data(), after.data() + after.size());
    const auto before_data = static_cast<std::size_t>(begin - after.data()) + 1;
    const std::size_t end = after.rfind("</AppendedData");
    if (end == std::string_view::npos) {
        return fail("is truncated: AppendedData does not end");
    }
    if (end < before_data || *begin != '_') {
        return fail("expected '_' at the beginning of AppendedData");
    }
    document_.form.appended = after.substr(before_data, end - before_data);
    stop();
}

}  // namespace

Result<VtpDocument> read_vtp_document(VtkFile& file) {
    return Parser(file).read();
}

}  // namespace lamella
