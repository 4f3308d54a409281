// PLY, ASCII and binary, of either byte order.
#include <utility>

#include "base/clock.hpp"
#include "base/words.hpp"
#include "io/read/ply/ply_binary.hpp"
#include "io/read/ply/ply_body.hpp"
#include "io/read/ply/ply_words.hpp"
#include "io/read/reader.hpp"
#include "io/text/text.hpp"

namespace lamella {

namespace {

/// What is not read is said.
std::vector<std::string> warnings_of(const FileSource& file, std::string_view contents, const PlyHeader& header,
                                     const PlyMesh& body) {
    std::vector<std::string> warnings;
    warn_of_skipped_lines(file, contents, header, warnings);
    if (body.long_rows.count > 0) {
        warnings.push_back(file.name() + ": ignored what follows the declared properties in " +
                           counted(body.long_rows.count, "line") + first_line_words(body.long_rows, contents));
    }
    if (body.small_faces > 0) {
        warnings.push_back(file.name() + ": left out " + counted(body.small_faces, "face") +
                           " of fewer than three vertices");
    }
    const char* rest = contents.data() + body.end;
    const char* const end = contents.data() + contents.size();
    rest = header.encoding == PlyEncoding::ascii ? skip_space(rest, end) : rest;
    warn_of_rest(file, static_cast<std::uint64_t>(end - rest), warnings);
    return warnings;
}

MeshFile mesh_of(PlyMesh body, Array<std::byte> bytes, const PlyHeader& header, const Parallel& parallel) {
    MeshFile mesh;
    mesh.bytes = std::move(body.coordinates.empty() ? bytes : body.coordinates);
    mesh.first_offset = body.first_offset;
    mesh.stride = body.stride;
    mesh.coordinate_type = body.coordinate_type;
    mesh.vertex_count = body.vertex_count;
    if (body.swapped) {
        swap_vertices(mesh.bytes.data() + mesh.first_offset, mesh.stride, mesh.coordinate_type, mesh.vertex_count, parallel);
    }
    mesh.triangle_count = body.indices.size() / 3;
    mesh.indices = std::move(body.indices);
    mesh.text = header.encoding == PlyEncoding::ascii;
    return mesh;
}

}  // namespace

bool looks_like_ply(const FileSource& source) {
    return begins_as_ply(source.sample());
}

Result<MeshFile> read_ply(FileSource& source) {
    Result<Array<std::byte>> bytes = source.take(source.size());
    if (!bytes) {
        return bytes.error();
    }
    const auto start = Clock::now();
    const std::string_view contents = as_text(bytes.value().span());
    PlyHeader header;
    PlyProblem problem;
    if (!parse_ply_header(contents, header, problem)) {
        return ply_error(source, contents, header, problem);
    }
    if (header.element_of(PlyRole::faces) == nullptr && header.element_of(PlyRole::strips) == nullptr) {
        return source.error(ErrorCode::empty_mesh, "holds no faces");
    }
    if (header.element_of(PlyRole::vertices) == nullptr) {
        return source.error(ErrorCode::malformed_mesh, "holds faces but no vertices");
    }
    PlyMesh body(source.memory());
    const PlyInput input{contents, header, source.memory_limit(), source.parallel()};
    if (!read_ply_body(input, body, problem)) {
        return ply_error(source, contents, header, problem);
    }
    if (body.indices.empty()) {
        return source.error(ErrorCode::empty_mesh, "holds no triangles");
    }
    std::vector<std::string> warnings = warnings_of(source, contents, header, body);
    MeshFile mesh = mesh_of(std::move(body), std::move(bytes).value(), header, source.parallel());
    mesh.warnings = std::move(warnings);
    header.patient_frame.give(source, mesh);
    mesh.parse_ms = milliseconds_since(start);
    return mesh;
}

}  // namespace lamella
