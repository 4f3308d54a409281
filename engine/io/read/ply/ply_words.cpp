#include "io/read/ply/ply_words.hpp"

#include "base/words.hpp"

namespace lamella {

Error ply_error(const FileSource& file, std::string_view contents, const PlyHeader& header, const PlyProblem& problem) {
    if (problem.code != ErrorCode::malformed_mesh) {
        return file.error(problem.code, problem.what);
    }
    if (header.encoding == PlyEncoding::ascii || problem.offset < header.body || header.body == 0) {
        return file.error_in_text(contents, problem.offset, problem.what);
    }
    return file.error(ErrorCode::malformed_mesh, "byte " + std::to_string(problem.offset) + ": " + problem.what,
                      static_cast<std::int64_t>(problem.offset));
}

void warn_of_skipped_lines(const FileSource& file, std::string_view contents, const PlyHeader& header,
                           std::vector<std::string>& warnings) {
    if (header.skipped.count > 0) {
        warnings.push_back(file.name() + ": ignored " + counted(header.skipped.count, "line") +
                           " of the header without a keyword" + first_word_words(header.skipped, contents));
    }
}

void warn_of_rest(const FileSource& file, std::uint64_t bytes, std::vector<std::string>& warnings) {
    if (bytes > 0) {
        warnings.push_back(file.name() + ": ignored " + counted(bytes, "byte") + " after the last element");
    }
}

}  // namespace lamella
