// What check() found, for people and for programs.
//
//     const lamella::Result<lamella::MeshCheck> check = lamella::check(mesh);
//     if (check) {
//         const lamella::Result<std::string> verdict = lamella::make_verdict(*check);
//         std::printf("%s\n", verdict ? verdict->c_str() : "out of memory");
//     }
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "lamella/check.hpp"
#include "lamella/error.hpp"
#include "lamella/io/report.hpp"

namespace lamella {

/// One line: "closed and clean", with slivers named where there are any, or "not clean: 3 boundary edges, 1 boundary loop".
/// Where a search was cut short it ends in "as far as was searched". Errors: out_of_memory.
Result<std::string> make_verdict(const MeshCheck& check) noexcept;

/// The report as JSON, indented, with a final newline: at most `most_places` places of each kind and so many shells. Of
/// `parts` it uses the mesh's name, the file and the program's members. Errors: out_of_memory.
Result<std::string> make_check_json(const MeshCheck& check, const ReportParts& parts = {},
                                    std::size_t most_places = 10) noexcept;

/// All places that were kept, as an ASCII PLY of coloured points and edges in mm; a comment in the file tells the colour of
/// each kind. The file is written aside and renamed. Errors: unwritable_file, out_of_memory.
Status write_marks(const MeshCheck& check, const std::filesystem::path& path) noexcept;

}  // namespace lamella
