// VTP, the XML files of VTK for polygonal data: all pieces are joined. Data at points and cells are
// skipped.
#include <algorithm>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "io/read/reader.hpp"
#include "io/read/stated_frame.hpp"
#include "io/read/vtk/vtk_cells.hpp"
#include "io/read/vtk/vtp_data.hpp"
#include "io/read/vtk/vtp_document.hpp"
#include "io/text/text.hpp"

namespace lamella {

namespace {

class Vtp {
public:
    Vtp(VtkFile& file, VtpDocument document) : file_(file), document_(std::move(document)) {}

    /// Gives `mesh` the points. Where they can stay in `bytes`, the file's own, it takes these.
    Status give_points(Array<std::byte>& bytes, MeshFile& mesh);
    /// Gives it the triangles; the points are there.
    Status give_triangles(MeshFile& mesh);
    StatedFrame patient_frame();

private:
    Status load_points(VtpData& data, std::vector<NumberArray>& points, std::uint64_t& count);
    Status load_cells(VtpData& data, const VtpCells& cells, const VtpPiece& piece, CellArray array);
    Error error_in(const VtpPiece& piece, const std::string& what) const {
        return file_.error_at(file_.text.data() + piece.element, what);
    }

    VtkFile& file_;
    VtpDocument document_;
    std::vector<CellArray> cells_;
};

/// The points of all pieces, and how many they are.
Status Vtp::load_points(VtpData& data, std::vector<NumberArray>& points, std::uint64_t& count) {
    for (const VtpPiece& piece : document_.pieces) {
        if (piece.point_count > std::numeric_limits<std::uint32_t>::max() - count) {
            return error_in(piece, "expected fewer than 2^32 points in all, found " + std::to_string(piece.point_count) +
                                       " in this Piece");
        }
        count += piece.point_count;
        if (piece.point_count == 0) {
            continue;
        }
        if (!piece.points) {
            return error_in(piece, "expected a DataArray in the Points of this Piece");
        }
        const bool floats = piece.points->type == NumberType::float32;
        const Result<NumberArray> loaded = floats ? data.load<float>(*piece.points, 3 * piece.point_count)
                                                  : data.load<double>(*piece.points, 3 * piece.point_count);
        if (!loaded) {
            return loaded.error();
        }
        points.push_back(loaded.value());
    }
    return {};
}

Status Vtp::give_points(Array<std::byte>& bytes, MeshFile& mesh) {
    VtpData data(file_, document_.form);
    std::vector<NumberArray> points;
    if (Status loaded = load_points(data, points, mesh.vertex_count); !loaded) {
        return loaded;
    }
    const bool floats = std::all_of(points.begin(), points.end(), [](const NumberArray& numbers) {
        return coordinates_of(numbers.type) == CoordinateType::f32;
    });
    mesh.text = std::any_of(points.begin(), points.end(),
                            [](const NumberArray& numbers) { return numbers.place.form == NumberPlace::Form::text; });
    mesh.coordinate_type = floats ? CoordinateType::f32 : CoordinateType::f64;
    mesh.stride = 3 * bytes_of(mesh.coordinate_type);
    if (points.size() == 1 && !is_integer(points[0].type)) {
        const bool in_file = points[0].place.form == NumberPlace::Form::bytes;
        mesh.first_offset = in_file ? points[0].place.offset : 0;
        mesh.bytes = std::move(in_file ? bytes : data.last_storage());
    } else {
        if (Status room = file_.budget.take(mesh.vertex_count, mesh.stride); !room) {
            return room;
        }
        mesh.bytes = Array<std::byte>(file_.source.memory());
        mesh.bytes.resize_discarding(mesh.vertex_count * mesh.stride);
    }
    std::byte* out = mesh.bytes.data() + mesh.first_offset;
    for (const NumberArray& numbers : points) {
        convert_coordinates(numbers, mesh.coordinate_type, out, file_.source.parallel());
        out += numbers.count * bytes_of(mesh.coordinate_type);
    }
    return {};
}

/// Adds `array`, whose kind and points are set, if there are any such cells.
Status Vtp::load_cells(VtpData& data, const VtpCells& cells, const VtpPiece& piece, CellArray array) {
    if (cells.count == 0) {
        return {};
    }
    if (!cells.offsets || !cells.connectivity) {
        return error_in(piece, "expected the DataArrays 'connectivity' and 'offsets' of the " + std::string(array.name));
    }
    const Result<NumberArray> ends = data.load<std::uint64_t>(*cells.offsets, cells.count);
    if (!ends) {
        return ends.error();
    }
    std::uint64_t corners = 0;
    decode_integers(ends.value(), cells.count - 1, 1, &corners);
    const Result<NumberArray> connectivity = data.load<std::uint32_t>(*cells.connectivity, corners);
    if (!connectivity) {
        return connectivity.error();
    }
    array.cells = cells.count;
    array.ends = ends.value();
    array.corners = connectivity.value();
    cells_.push_back(array);
    return {};
}

Status Vtp::give_triangles(MeshFile& mesh) {
    VtpData data(file_, document_.form);
    CellArray array;
    for (const VtpPiece& piece : document_.pieces) {
        array.point_count = static_cast<std::uint32_t>(piece.point_count);
        array.name = "Polys";
        array.kind = CellKind::polygons;
        if (Status loaded = load_cells(data, piece.polygons, piece, array); !loaded) {
            return loaded;
        }
        array.name = "Strips";
        array.kind = CellKind::strips;
        if (Status loaded = load_cells(data, piece.strips, piece, array); !loaded) {
            return loaded;
        }
        array.first_point += array.point_count;
    }
    return cut_cells(file_, cells_, mesh);
}

/// What the string SPACE states. Strings of other lengths are no known frame.
StatedFrame Vtp::patient_frame() {
    constexpr std::size_t letters = 3;  // and a 0, which ends the string
    StatedFrame frame;
    if (!document_.space) {
        return frame;
    }
    VtpData data(file_, document_.form);
    const Result<NumberArray> codes = data.load<std::uint32_t>(*document_.space, letters + 1);
    if (!codes) {
        return frame;
    }
    std::uint64_t code[letters + 1] = {};
    decode_integers(codes.value(), 0, letters + 1, code);
    const bool is_ascii = std::all_of(code, code + letters, [](std::uint64_t c) { return c > ' ' && c <= '~'; });
    if (is_ascii && code[letters] == 0) {
        frame.read_space(std::string(code, code + letters));
    }
    return frame;
}

}  // namespace

bool looks_like_vtp(const FileSource& source) {
    const std::string_view sample = without_byte_order_mark(source.sample());
    const char* const end = sample.data() + sample.size();
    const char* const first = skip_space(sample.data(), end);
    return first != end && *first == '<' && sample.find("<VTKFile") != std::string_view::npos;
}

Result<MeshFile> read_vtp(FileSource& source) {
    Result<Array<std::byte>> bytes = source.take(source.size());
    if (!bytes) {
        return bytes.error();
    }
    const Clock::time_point start = Clock::now();
    VtkFile file{source, as_text(bytes.value().span()), MemoryBudget(source)};
    Result<VtpDocument> document = read_vtp_document(file);
    if (!document) {
        return document.error();
    }
    MeshFile mesh;
    if (const std::optional<XmlUnboundName>& unbound = document->unbound_name) {
        mesh.warnings.push_back(source.name() + ": line " + std::to_string(line_of(file.text, unbound->offset)) + ": " +
                                unbound->words());
    }
    Vtp vtp(file, std::move(document).value());
    vtp.patient_frame().give(source, mesh);
    if (Status given = vtp.give_points(bytes.value(), mesh); !given) {
        return given.error();
    }
    if (Status given = vtp.give_triangles(mesh); !given) {
        return given.error();
    }
    mesh.parse_ms = milliseconds_since(start);
    return mesh;
}

}  // namespace lamella
