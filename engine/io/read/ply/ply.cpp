// PLY, ASCII and binary, of either byte order.
#include <utility>

#include "base/guard.hpp"
#include "base/words.hpp"
#include "io/read/ply/ply_body.hpp"
#include "io/read/reader.hpp"

namespace lamella {

namespace {

/// What is not read is said.
std::vector<std::string> warnings_of(const FileSource& file, std::string_view contents, const PlyHeader& header,
                                     const PlyBody& body) {
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

void parse_ply(FileContents& file, MeshFile& mesh) {
    const FileSource& source = file.source;
    const PlyHeader header = parse_ply_header(file.whole);
    if (header.element_of(PlyRole::faces) == nullptr && header.element_of(PlyRole::strips) == nullptr) {
        throw Refused{source.error(ErrorCode::empty_mesh, "holds no faces")};
    }
    if (header.element_of(PlyRole::vertices) == nullptr) {
        throw Refused{source.error(ErrorCode::malformed_mesh, "holds faces but no vertices")};
    }
    const PlyBody body = read_ply_body({source, file.whole, header}, mesh);
    if (mesh.triangle_count == 0) {
        throw Refused{source.error(ErrorCode::empty_mesh, "holds no triangles")};
    }
    mesh.text = header.encoding == PlyEncoding::ascii;
    mesh.warnings = warnings_of(source, file.whole, header, body);
    header.patient_frame.give(source, mesh);
    if (mesh.bytes.empty()) {
        mesh.bytes = std::move(file.bytes);
    }
    if (body.swapped) {
        swap_vertices(mesh, source.parallel());
    }
}

}  // namespace

bool looks_like_ply(const FileSource& source) {
    return begins_as_ply(source.sample());
}

Result<MeshFile> read_ply(FileSource& source) {
    return read_contents(source, parse_ply);
}

}  // namespace lamella
