// What check() found, for people and programs.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "lamella/error.hpp"
#include "lamella/io/write.hpp"
#include "lamella/mesh/check.hpp"

namespace lamella {

/// One line: "closed and clean", with slivers named where there are any, or "not clean: 3 boundary edges, 1 boundary loop".
/// Where a search was cut short it ends in "as far as was searched".
/// Throws std::bad_alloc.
std::string verdict(const MeshCheck& check);

/// The report as JSON text (indented, with a final newline), with at most so many places of each kind and so many shells. Of
/// the context mesh_file, file and warnings are used. Errors: out_of_memory.
Result<std::string> check_json(const MeshCheck& check, const ReportContext& context, std::size_t most_places = 10) noexcept;

/// All places kept, as an ASCII PLY of coloured points and edges in mm; a comment in the file tells the colour of each kind.
/// Errors: unwritable_file, out_of_memory.
Status write_marks(const MeshCheck& check, const std::filesystem::path& path) noexcept;

}  // namespace lamella
