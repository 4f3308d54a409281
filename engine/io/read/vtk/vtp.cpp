// VTP, the XML files of VTK for polygonal data: all pieces are joined. Data at points and cells are
// skipped.
#include <limits>

#include "io/read/stated.hpp"
#include "io/read/vtk/vtp_document.hpp"

namespace lamella {

namespace {

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

    /// Gives it the triangles; the points are there.
    void give_triangles(MeshFile& mesh) const {
        std::vector<CellArray> arrays;
        std::uint32_t first_point = 0;
        for (const VtpPiece& piece : document_.pieces) {
            const auto count = static_cast<std::uint32_t>(piece.point_count);
            load_cells(piece.polygons, piece,
                       {.name = "Polys", .kind = CellKind::polygons, .first_point = first_point, .point_count = count},
                       arrays);
            load_cells(piece.strips, piece,
                       {.name = "Strips", .kind = CellKind::strips, .first_point = first_point, .point_count = count},
                       arrays);
            first_point += count;
        }
        cut_cells(file_, arrays, mesh);
    }

    /// The frame that the string SPACE states. Strings of other lengths are no known frame.
    StatedFrame patient_frame() const {
        constexpr std::size_t letters = 3;  // and a 0, which ends the string
        StatedFrame frame;
        if (!document_.space) {
            return frame;
        }
        std::uint64_t code[letters + 1] = {};
        try {
            decode_integers(load(*document_.space, letters + 1, NumberType::uint32), 0, letters + 1, code);
        } catch (const TextError&) {
            return frame;
        } catch (const Refused&) {
            return frame;
        }
        const bool is_ascii = std::all_of(code, code + letters, [](std::uint64_t c) { return c > ' ' && c <= '~'; });
        if (is_ascii && code[letters] == 0) {
            frame.read_space(std::string(code, code + letters));
        }
        return frame;
    }

private:
    /// Adds `array`, whose kind and points are set, if there are any such cells.
    void load_cells(const VtpCells& cells, const VtpPiece& piece, CellArray array, std::vector<CellArray>& arrays) const {
        if (cells.count == 0) {
            return;
        }
        if (!cells.offsets || !cells.connectivity) {
            throw TextError{piece.element,
                            "expected the DataArrays 'connectivity' and 'offsets' of the " + std::string(array.name)};
        }
        array.cells = cells.count;
        array.ends = load(*cells.offsets, cells.count, NumberType::uint64);
        std::uint64_t corners = 0;
        decode_integers(array.ends, cells.count - 1, 1, &corners);
        array.corners = load(*cells.connectivity, corners, NumberType::uint32);
        arrays.push_back(std::move(array));
    }

    NumberArray load(const VtpArray& array, std::uint64_t count, NumberType as) const {
        return load_array(file_, document_.form, array, count, as);
    }

    VtkFile& file_;
    const VtpDocument& document_;
};

void parse_vtp(FileContents& contents, MeshFile& mesh) {
    VtkFile file(contents);
    const VtpDocument document = read_vtp_document(file);
    if (const std::optional<XmlUnboundName>& unbound = document.unbound_name) {
        mesh.warnings.push_back(file.source.name() + ": line " + std::to_string(line_of(file.text, unbound->offset)) + ": " +
                                unbound->words());
    }
    const Vtp vtp(file, document);
    vtp.patient_frame().give(file.source, mesh);
    std::vector<NumberArray> points = vtp.load_points();
    give_points(file, points, mesh);
    vtp.give_triangles(mesh);
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
