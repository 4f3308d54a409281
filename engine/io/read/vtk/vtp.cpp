// VTP, the XML files of VTK for polygonal data: all pieces are joined. Data at cells are skipped, and those at points unless
// they are asked for.
#include <algorithm>
#include <deque>
#include <limits>

#include "io/read/arrays/array_xml.hpp"
#include "io/read/stated.hpp"
#include "io/read/vtk/vtp_data.hpp"

namespace lamella {

namespace {

struct VtpCells {
    CellKind kind;
    std::string_view name;
    std::uint64_t count = 0;
    std::optional<VtpArray> connectivity{};
    std::optional<VtpArray> offsets{};
};

/// An array of numbers at points.
struct VtpScalars {
    std::string name;
    std::uint64_t components = 1;
    std::optional<VtpArray> array{};
};

struct VtpPiece {
    const char* element = nullptr;  ///< where in the file it begins
    std::uint64_t point_count = 0;
    std::optional<VtpArray> points{};
    std::array<VtpCells, 2> cells{VtpCells{CellKind::polygons, "Polys"}, VtpCells{CellKind::strips, "Strips"}};
    std::deque<VtpScalars> scalars{};
};

struct VtpDocument {
    VtpForm form;
    std::deque<VtpPiece> pieces;
    std::optional<VtpArray> space;  ///< the string of that name among the field data, as 3D Slicer writes it
};

constexpr std::string_view piece_path = "/VTKFile/PolyData/Piece";

/// Reads the document up to the appended data, which are no XML. Throws errors.
class VtpParser : public ArrayXml {
public:
    explicit VtpParser(ArrayFile& file) : ArrayXml(file, "VTKFile", "<DataArray") {}

    VtpDocument read() {
        parse_document();
        return std::move(document_);
    }

private:
    void begin_path(const XmlAttributes& attributes) override {
        if (path() == "/VTKFile") {
            begin_file(attributes);
        } else if (path() == piece_path) {
            begin_piece(attributes);
        } else if (path() == "/VTKFile/AppendedData") {
            begin_appended(attributes);
        } else if (path() == "/VTKFile/PolyData/FieldData/Array") {
            if (attributes.find("Name") == "SPACE") {
                begin_array(document_.space, "SPACE", attributes, false);
            }
        } else if (path().starts_with(piece_path)) {
            begin_in_piece(path().substr(piece_path.size()), attributes);
        }
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
        for (VtpCells& cells : piece.cells) {
            cells.count = count(attributes, "NumberOf" + std::string(cells.name));
        }
    }

    void begin_in_piece(std::string_view place, const XmlAttributes& attributes) {
        VtpPiece& piece = document_.pieces.back();
        const std::string_view name = attributes.find("Name").value_or("");
        if (place == "/Points/DataArray") {
            begin_array(piece.points, "Points", attributes, true);
            if (attributes.find("NumberOfComponents").value_or("3") != "3") {
                refuse("expected Points of 3 components");
            }
        }
        if (place == "/PointData/DataArray" && file_.source.scalars()) {
            begin_scalars(piece, name, attributes);
        }
        for (VtpCells& cells : piece.cells) {
            if (place == "/" + std::string(cells.name) + "/DataArray" && (name == "connectivity" || name == "offsets")) {
                begin_array(name == "offsets" ? cells.offsets : cells.connectivity,
                            std::string(name) + " of " + std::string(cells.name), attributes, false);
            }
        }
    }

    /// Others than numbers are passed over.
    void begin_scalars(VtpPiece& piece, std::string_view name, const XmlAttributes& attributes) {
        const std::string_view type = attributes.find("type").value_or("");
        if (std::find(number_type_names.begin(), number_type_names.end(), type) == number_type_names.end()) {
            return;
        }
        constexpr std::uint64_t most_components = 1024;
        file_.budget.take(1, sizeof(VtpScalars) + 2 * name.size());
        VtpScalars& scalars = piece.scalars.emplace_back(VtpScalars{std::string(name)});
        scalars.components = attributes.find("NumberOfComponents") ? count(attributes, "NumberOfComponents") : 1;
        if (scalars.components == 0 || scalars.components > most_components) {
            refuse("expected 1 to 1024 components");
        }
        begin_array(scalars.array, "values " + in_quotes(name), attributes, true);
    }

    void begin_array(std::optional<VtpArray>& place, const std::string& name, const XmlAttributes& attributes,
                     bool may_be_floats) {
        if (place) {
            refuse("expected one such DataArray, found a second");
        }
        VtpArray& array = place.emplace();
        array.name = name;
        array.element = event();
        const std::string_view type = attributes.find("type").value_or("");
        const auto* const found = std::find(number_type_names.begin(), number_type_names.end(), type);
        if (type == "String" && name == "SPACE") {
            array.type = NumberType::uint8;  // characters, and a 0 after each string
        } else if (found == number_type_names.end()) {
            refuse("expected a DataArray of a type from Int8 to Float64, found " + in_quotes(type));
        } else {
            array.type = static_cast<NumberType>(found - number_type_names.begin());
        }
        if (!is_integer(array.type) && !may_be_floats) {
            refuse("expected integers, found numbers of type " + in_quotes(type));
        }
        if (attributes.find("format") == "appended") {
            array.format = VtpArray::Format::appended;
            array.appended_offset = count(attributes, "offset");
        } else if (is_second(attributes, "format", "ascii", "binary")) {
            array.format = VtpArray::Format::binary;
        }
        begin_content(array.content);
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

    VtpDocument document_;
};

/// The points of all pieces that have some.
std::vector<NumberArray> load_points(ArrayFile& file, const VtpDocument& document) {
    std::vector<NumberArray> points;
    std::uint64_t count = 0;
    for (const VtpPiece& piece : document.pieces) {
        if (piece.point_count > std::numeric_limits<std::uint32_t>::max() - count) {
            throw TextError{piece.element, "expected fewer than 2^32 points in all, found " +
                                               std::to_string(piece.point_count) + " in this Piece"};
        }
        count += piece.point_count;
        if (piece.point_count > 0) {
            if (!piece.points) {
                throw TextError{piece.element, "expected a DataArray in the Points of this Piece"};
            }
            const bool floats = piece.points->type == NumberType::float32;
            points.push_back(load_array(file, document.form, *piece.points, 3 * piece.point_count,
                                        floats ? NumberType::float32 : NumberType::float64));
        }
    }
    return points;
}

std::vector<CellArray> load_cells(ArrayFile& file, const VtpDocument& document) {
    std::vector<CellArray> arrays;
    std::uint32_t first_point = 0;
    for (const VtpPiece& piece : document.pieces) {
        for (const VtpCells& cells : piece.cells) {
            if (cells.count == 0) {
                continue;
            }
            if (!cells.offsets || !cells.connectivity) {
                throw TextError{piece.element,
                                "expected the DataArrays 'connectivity' and 'offsets' of the " + std::string(cells.name)};
            }
            CellArray& array = arrays.emplace_back(CellArray{.name = cells.name, .kind = cells.kind, .cells = cells.count});
            array.ends = load_array(file, document.form, *cells.offsets, cells.count, NumberType::uint64);
            array.corners = load_array(file, document.form, *cells.connectivity, integer_at(array.ends, cells.count - 1),
                                       NumberType::uint32);
            array.first_point = first_point;
            array.point_count = static_cast<std::uint32_t>(piece.point_count);
        }
        first_point += static_cast<std::uint32_t>(piece.point_count);
    }
    return arrays;
}

/// Gives `mesh` each array that all pieces with points have, in the same order.
void give_all_scalars(ArrayFile& file, const VtpDocument& document, MeshFile& mesh) {
    const auto first = std::find_if(document.pieces.begin(), document.pieces.end(),
                                    [](const VtpPiece& piece) { return piece.point_count > 0; });
    for (std::size_t i = 0; first != document.pieces.end() && i < first->scalars.size(); ++i) {
        const VtpScalars& wanted = first->scalars[i];
        const auto load = [&] {
            std::vector<NumberArray> arrays;
            for (const VtpPiece& piece : document.pieces) {
                if (piece.point_count == 0) {
                    continue;
                }
                const VtpScalars* const own = i < piece.scalars.size() ? &piece.scalars[i] : nullptr;
                if (own == nullptr || own->name != wanted.name || own->components != wanted.components) {
                    throw TextError{piece.element, "this Piece lacks an array that others have, in their order"};
                }
                const bool floats = own->array->type == NumberType::float32;
                arrays.push_back(load_array(file, document.form, *own->array, own->components * piece.point_count,
                                            floats ? NumberType::float32 : NumberType::float64));
            }
            return arrays;
        };
        const bool integers = is_integer(wanted.array->type);
        give_scalars(file, {wanted.name, static_cast<std::size_t>(wanted.components), integers}, load, mesh);
    }
}

/// The frame that the string SPACE states. Strings of other lengths are no known frame.
StatedFrame patient_frame(ArrayFile& file, const VtpDocument& document) {
    constexpr std::uint64_t most_characters = 4;  // three letters, and a 0, which ends the string
    StatedFrame frame;
    std::string space;
    try {
        if (document.space) {
            const NumberArray codes = load_array(file, document.form, *document.space, most_characters, NumberType::uint32);
            for (std::uint64_t i = 0; i < most_characters; ++i) {
                const std::uint64_t code = integer_at(codes, i);
                space += code < 0x80 ? static_cast<char>(code) : '?';
            }
        }
    } catch (const TextError&) {
        return frame;
    } catch (const Refused&) {
        return frame;
    }
    frame.read_space(space.ends_with('\0') ? space.substr(0, most_characters - 1) : std::string());
    return frame;
}

}  // namespace

void parse_vtp(FileContents& contents, MeshFile& mesh) {
    ArrayFile file(contents);
    VtpParser parser(file);
    const VtpDocument document = parser.read();
    warn_unbound(file, parser, mesh);
    patient_frame(file, document).give(file.source, mesh);
    std::vector<NumberArray> points = load_points(file, document);
    give_all_scalars(file, document, mesh);  // before points are swapped where they lie, which an array may share
    give_points(file, points, mesh);
    cut_cells(file, load_cells(file, document), mesh);
}

bool looks_like_vtp(const FileSource& source) {
    return begins_as_xml(source, "<VTKFile");
}

}  // namespace lamella
