// Errors and warnings of PLY files, which are the same whether a file is read as a whole or in pieces.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "io/read/ply/ply_header.hpp"
#include "io/read/reader.hpp"

namespace lamella {

/// `contents` begin with the header, and hold what `problem` lies in if that is text.
Error ply_error(const FileSource& file, std::string_view contents, const PlyHeader& header, const PlyProblem& problem);

void warn_of_skipped_lines(const FileSource& file, std::string_view contents, const PlyHeader& header,
                           std::vector<std::string>& warnings);

/// `bytes` after the last element, or none.
void warn_of_rest(const FileSource& file, std::uint64_t bytes, std::vector<std::string>& warnings);

}  // namespace lamella
