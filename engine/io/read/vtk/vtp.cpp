// VTP, the XML files of VTK for polygonal data: all pieces are joined. Data at points and cells are skipped.
#include <deque>
#include <limits>

#include "io/read/stated.hpp"
#include "io/read/vtk/vtp_data.hpp"
#include "io/xml/xml.hpp"

namespace lamella {

namespace {

/// Polygons or strips.
struct VtpCells {
    std::uint64_t count = 0;
    std::optional<VtpArray> connectivity;
    std::optional<VtpArray> offsets;
};

struct VtpPiece {
    const char* element = nullptr;  ///< where in the file it begins
    std::uint64_t point_count = 0;
    std::optional<VtpArray> points;
    VtpCells polygons;
    VtpCells strips;
};

struct VtpDocument {
    VtpForm form;
    std::deque<VtpPiece> pieces;
    std::optional<XmlUnboundName> unbound_name;
    std::optional<VtpArray> space;  ///< the string of that name among the field data, as 3D Slicer writes it
};

constexpr std::string_view piece_path = "/VTKFile/PolyData/Piece";

/// Reads the document up to the appended data, which are no XML. Throws errors.
class VtpParser : public XmlReader {
public:
    explicit VtpParser(VtkFile& file) : file_(file) {}

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
        path_.append(1, '/').append(name.space.empty() ? name.local : "other");
        if (path_ == "/VTKFile") {
            begin_file(attributes);
        } else if (path_.rfind('/') == 0) {
            refuse("expected the element VTKFile, found " + in_quotes(name.local));
        } else if (path_ == piece_path) {
            begin_piece(attributes);
        } else if (path_ == "/VTKFile/AppendedData") {
            begin_appended(attributes);
        } else if (path_ == "/VTKFile/PolyData/FieldData/Array") {
            if (attributes.find("Name") == "SPACE") {
                begin_array(document_.space, "SPACE", attributes);
            }
        } else if (path_.starts_with(piece_path)) {
            begin_in_piece(std::string_view(path_).substr(piece_path.size()), attributes);
        }
    }

    void end_element(const XmlName& /*name*/) override {
        end_content();
        path_.resize(path_.rfind('/'));
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

    void begin_in_piece(std::string_view path, const XmlAttributes& attributes) {
        VtpPiece& piece = document_.pieces.back();
        const std::string_view name = attributes.find("Name").value_or("");
        if (path == "/Points/DataArray") {
            begin_array(piece.points, "Points", attributes);
            if (attributes.find("NumberOfComponents").value_or("3") != "3") {
                refuse("expected Points of 3 components");
            }
        } else if (path == "/Polys/DataArray" && name == "connectivity") {
            begin_array(piece.polygons.connectivity, "connectivity of Polys", attributes);
        } else if (path == "/Polys/DataArray" && name == "offsets") {
            begin_array(piece.polygons.offsets, "offsets of Polys", attributes);
        } else if (path == "/Strips/DataArray" && name == "connectivity") {
            begin_array(piece.strips.connectivity, "connectivity of Strips", attributes);
        } else if (path == "/Strips/DataArray" && name == "offsets") {
            begin_array(piece.strips.offsets, "offsets of Strips", attributes);
        }
    }

    void begin_array(std::optional<VtpArray>& place, std::string_view name, const XmlAttributes& attributes) {
        if (place) {
            refuse("expected one such DataArray, found a second");
        }
        VtpArray& array = place.emplace();
        array.name = name;
        array.element = event();
        const std::string_view type = attributes.find("type").value_or("");
        const auto* const found = std::find(vtk_type_names.begin(), vtk_type_names.end(), type);
        if (type == "String" && name == "SPACE") {
            array.type = NumberType::uint8;  // characters, and a 0 after each string
        } else if (found == vtk_type_names.end()) {
            refuse("expected a DataArray of a type from Int8 to Float64, found " + in_quotes(type));
        } else {
            array.type = static_cast<NumberType>(found - vtk_type_names.begin());
        }
        if (!is_integer(array.type) && name != "Points") {
            refuse("expected integers, found numbers of type " + in_quotes(type));
        }
        if (attributes.find("format") == "appended") {
            array.format = VtpArray::Format::appended;
            array.appended_offset = count(attributes, "offset");
        } else if (is_second(attributes, "format", "ascii", "binary")) {
            array.format = VtpArray::Format::binary;
        }
        array_ = &array;
        content_ = event_end();
        array.content = file_.text.substr(content_, 0);
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

    std::uint64_t count(const XmlAttributes& attributes, std::string_view name) const {
        const std::string_view digits = attributes.find(name).value_or("0");
        std::uint64_t count = 0;
        if (!read_integer(digits, count)) {
            refuse("expected a number as " + std::string(name) + ", found " + in_quotes(digits));
        }
        return count;
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
    std::string path_;           ///< of the open element
    std::uint64_t tag_end_ = 0;  ///< of the last element that began
    VtpArray* array_ = nullptr;  ///< whose content has not ended
    std::uint64_t content_ = 0;  ///< where it began
};

/// The arrays of a document.
class Vtp {
public:
    Vtp(VtkFile& file, const VtpDocument& document) : file_(file), document_(document) {}

    /// The points of all pieces that have some.
    std::vector<NumberArray> load_points() const {
        std::vector<NumberArray> points;
        std::uint64_t count = 0;
        for (const VtpPiece& piece : document_.pieces) {
            if (piece.point_count > std::numeric_limits<std::uint32_t>::max() - count) {
                throw TextError{piece.element, "expected fewer than 2^32 points in all, found " +
                                                   std::to_string(piece.point_count) + " in this Piece"};
            }
            count += piece.point_count;
            if (piece.point_count == 0) {
                continue;
            }
            if (!piece.points) {
                throw TextError{piece.element, "expected a DataArray in the Points of this Piece"};
            }
            const bool floats = piece.points->type == NumberType::float32;
            points.push_back(load(*piece.points, 3 * piece.point_count, floats ? NumberType::float32 : NumberType::float64));
        }
        return points;
    }

    std::vector<CellArray> load_cells() const {
        std::vector<CellArray> arrays;
        std::uint32_t first_point = 0;
        for (const VtpPiece& piece : document_.pieces) {
            for (const VtpCells* const cells : {&piece.polygons, &piece.strips}) {
                if (cells->count > 0) {
                    CellArray& array = arrays.emplace_back(load(*cells, piece));
                    array.kind = cells == &piece.polygons ? CellKind::polygons : CellKind::strips;
                    array.first_point = first_point;
                    array.point_count = static_cast<std::uint32_t>(piece.point_count);
                }
            }
            first_point += static_cast<std::uint32_t>(piece.point_count);
        }
        return arrays;
    }

    /// The frame that the string SPACE states. Strings of other lengths are no known frame.
    StatedFrame patient_frame() const {
        StatedFrame frame;
        std::array<std::uint64_t, 4> code{};  // three letters, and a 0, which ends the string
        try {
            if (document_.space) {
                decode_integers(load(*document_.space, code.size(), NumberType::uint32), 0, code.size(), code.data());
            }
        } catch (const TextError&) {
            return frame;
        } catch (const Refused&) {
            return frame;
        }
        if (std::all_of(code.begin(), code.end() - 1, [](std::uint64_t c) { return c > ' ' && c <= '~'; }) && code[3] == 0) {
            frame.read_space(std::string(code.begin(), code.end() - 1));
        }
        return frame;
    }

private:
    CellArray load(const VtpCells& cells, const VtpPiece& piece) const {
        CellArray array;
        array.name = &cells == &piece.polygons ? "Polys" : "Strips";
        if (!cells.offsets || !cells.connectivity) {
            throw TextError{piece.element,
                            "expected the DataArrays 'connectivity' and 'offsets' of the " + std::string(array.name)};
        }
        array.cells = cells.count;
        array.ends = load(*cells.offsets, cells.count, NumberType::uint64);
        std::uint64_t corners = 0;
        decode_integers(array.ends, cells.count - 1, 1, &corners);
        array.corners = load(*cells.connectivity, corners, NumberType::uint32);
        return array;
    }

    NumberArray load(const VtpArray& array, std::uint64_t count, NumberType as) const {
        return load_array(file_, document_.form, array, count, as);
    }

    VtkFile& file_;
    const VtpDocument& document_;
};

void parse_vtp(FileContents& contents, MeshFile& mesh) {
    VtkFile file(contents);
    const VtpDocument document = VtpParser(file).read();
    if (const std::optional<XmlUnboundName>& unbound = document.unbound_name) {
        mesh.warnings.push_back(file.source.name() + ": line " + std::to_string(line_of(file.text, unbound->offset)) + ": " +
                                unbound->words());
    }
    const Vtp vtp(file, document);
    vtp.patient_frame().give(file.source, mesh);
    std::vector<NumberArray> points = vtp.load_points();
    give_points(file, points, mesh);
    cut_cells(file, vtp.load_cells(), mesh);
}

}  // namespace

bool looks_like_vtp(const FileSource& source) {
    const std::string_view sample = without_byte_order_mark(source.sample());
    const char* const end = sample.data() + sample.size();
    const char* const first = skip_space(sample.data(), end);
    return first != end && *first == '<' && sample.find("<VTKFile") != std::string_view::npos;
}

MeshFile read_vtp(FileSource& source) {
    return read_contents(source, parse_vtp);
}

}  // namespace lamella
