#include "io/read/vtk/vtp_document.hpp"

namespace lamella {

namespace {

/// In the order of NumberType.
constexpr std::array<std::string_view, 10> type_names = {"Int8",   "UInt8", "Int16",  "UInt16",  "Int32",
                                                         "UInt32", "Int64", "UInt64", "Float32", "Float64"};

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
    const bool polys = parent == Element::polys;
    return parent == Element::points             ? "Points"
           : !polys && parent != Element::strips ? "SPACE"
           : connectivity                        ? (polys ? "connectivity of Polys" : "connectivity of Strips")
                                                 : (polys ? "offsets of Polys" : "offsets of Strips");
}

class Parser : public XmlReader {
public:
    explicit Parser(VtkFile& file) : file_(file) {}

    VtpDocument read() {
        feed_all();
        if (failure()) {
            throw TextError{file_.text.data() + failure()->offset, failure()->what};
        }
        document_.unbound_name = unbound_name();
        return std::move(document_);
    }

private:
    void begin_element(const XmlName& name, const XmlAttributes& attributes) override {
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
            refuse("expected the element VTKFile, found " + in_quotes(name.local));
        } else if (parent == Element::file && name.local == "AppendedData") {
            begin_appended(attributes);
        }
    }

    void end_element(const XmlName& /*name*/) override {
        end_content();
        open_.pop_back();
    }

    void text(std::string_view /*piece*/) override {}  // that of arrays is found by its place

    /// Feeds everything but the numbers of arrays: expat would take longer to pass over them than they take to be read.
    void feed_all() {
        constexpr std::size_t window = std::size_t{64} << 10;  // appended data, which end parsing, are not searched for tags
        std::string_view rest = file_.text;
        while (!rest.empty()) {
            file_.source.parallel().stop_if_asked();
            const std::string_view ahead = rest.substr(0, window);
            const std::size_t tag_end = ahead.find('>', ahead.find("<DataArray"));
            const std::string_view head = ahead.substr(0, tag_end == std::string_view::npos ? tag_end : tag_end + 1);
            if (!feed(head)) {
                return;
            }
            rest.remove_prefix(head.size());
            const std::string_view numbers = rest.substr(0, skippable(rest));
            skip(numbers);
            rest.remove_prefix(numbers.size());
        }
        finish();
    }

    /// How much of `rest` is text of the element that has just begun, if it holds no markup or entities.
    std::size_t skippable(std::string_view rest) const {
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

    void begin_file(const XmlAttributes& attributes) {
        const std::string_view type = attributes.find("type").value_or("");
        if (type != "PolyData") {
            refuse("expected a file of type PolyData, the only one that is read, found " + in_quotes(type));
        }
        document_.form.big_endian = is_second(attributes, "byte_order", "LittleEndian", "BigEndian");
        document_.form.header_bytes = is_second(attributes, "header_type", "UInt32", "UInt64") ? 8 : 4;
        document_.form.compressor = attributes.find("compressor").value_or("");
    }

    void begin_piece(const XmlAttributes& attributes) {
        file_.budget.take(1, sizeof(VtpPiece));
        VtpPiece& piece = document_.pieces.emplace_back();
        piece.element = event();
        if (!attributes.find("NumberOfPoints")) {
            refuse("expected a Piece with NumberOfPoints");
        }
        piece.point_count = count(attributes, "NumberOfPoints");
        piece.polygons.count = count(attributes, "NumberOfPolys");
        piece.strips.count = count(attributes, "NumberOfStrips");
    }

    void begin_array(Element parent, const XmlAttributes& attributes) {
        std::optional<VtpArray>* const place = wanted_array(parent, attributes);
        if (place == nullptr) {
            return;
        }
        if (place->has_value()) {
            refuse("expected one such DataArray, found a second");
        }
        VtpArray& array = place->emplace();
        array.name = name_in(parent, attributes.find("Name") == "connectivity");
        array.element = event();
        if (parent == Element::points && attributes.find("NumberOfComponents").value_or("3") != "3") {
            refuse("expected Points of 3 components");
        }
        array.type = type(parent, attributes);
        array.format = format(attributes);
        if (array.format == VtpArray::Format::appended) {
            array.appended_offset = count(attributes, "offset");
        }
        if (!is_integer(array.type) && parent != Element::points) {
            refuse("expected integers, found numbers of type " + in_quotes(attributes.find("type").value_or("")));
        }
        array_ = &array;
        content_ = event_end();
        array_->content = file_.text.substr(content_, 0);
    }

    /// Appended data are not XML, so parsing ends here.
    void begin_appended(const XmlAttributes& attributes) {
        document_.form.appended_as_base64 = is_second(attributes, "encoding", "raw", "base64");
        const std::string_view after = file_.text.substr(event_end());
        const char* const begin = skip_space(after.data(), after.data() + after.size());
        const auto before_data = static_cast<std::size_t>(begin - after.data()) + 1;
        const std::size_t end = after.rfind("</AppendedData");
        if (end == std::string_view::npos) {
            refuse("is truncated: AppendedData does not end");
        }
        if (end < before_data || *begin != '_') {
            refuse("expected '_' at the beginning of AppendedData");
        }
        document_.form.appended = after.substr(before_data, end - before_data);
        stop();
    }

    /// Where the array that begins is stored; null if it is not needed.
    std::optional<VtpArray>* wanted_array(Element parent, const XmlAttributes& attributes) {
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

    std::uint64_t count(const XmlAttributes& attributes, std::string_view name) const {
        const std::string_view digits = attributes.find(name).value_or("0");
        std::uint64_t count = 0;
        if (!read_integer(digits, count)) {
            refuse("expected a number as " + std::string(name) + ", found " + in_quotes(digits));
        }
        return count;
    }

    NumberType type(Element parent, const XmlAttributes& attributes) const {
        const std::string_view name = attributes.find("type").value_or("");
        if (name == "String" && parent == Element::field_data) {
            return NumberType::uint8;  // characters, and a 0 after each string
        }
        const auto* const found = std::find(type_names.begin(), type_names.end(), name);
        if (found == type_names.end()) {
            refuse("expected a DataArray of a type from Int8 to Float64, found " + in_quotes(name));
        }
        return static_cast<NumberType>(found - type_names.begin());
    }

    VtpArray::Format format(const XmlAttributes& attributes) const {
        if (attributes.find("format") == "appended") {
            return VtpArray::Format::appended;
        }
        return is_second(attributes, "format", "ascii", "binary") ? VtpArray::Format::binary : VtpArray::Format::ascii;
    }

    /// The content of an array ends with its element or where another one begins in it.
    void end_content() {
        if (VtpArray* const array = std::exchange(array_, nullptr); array != nullptr && event_offset() > content_) {
            array->content = file_.text.substr(content_, event_offset() - content_);
        }
    }

    /// True if an attribute is the second of two values, one of which it must be; it is the first if it is absent.
    bool is_second(const XmlAttributes& attributes, std::string_view name, std::string_view first,
                   std::string_view second) const {
        const std::string_view value = attributes.find(name).value_or(first);
        if (value != first && value != second) {
            refuse("expected " + std::string(name) + " " + std::string(first) + " or " + std::string(second) + ", found " +
                   in_quotes(value));
        }
        return value == second;
    }

    /// Throws an error at the tag at hand.
    [[noreturn]] void refuse(const std::string& what) const { throw TextError{event(), what}; }
    const char* event() const { return file_.text.data() + event_offset(); }

    VtkFile& file_;
    VtpDocument document_;
    std::vector<Element> open_{Element::document};
    std::uint64_t tag_end_ = 0;  ///< of the last element that began
    VtpArray* array_ = nullptr;  ///< whose content has not ended
    std::uint64_t content_ = 0;  ///< where it began
};

}  // namespace

VtpDocument read_vtp_document(VtkFile& file) {
    return Parser(file).read();
}

}  // namespace lamella
