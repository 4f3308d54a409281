// Text files that appear whole or not at all.
//
//     const lamella::Status written = lamella::write_text_file("report.json", "{}\n");
#pragma once

#include <filesystem>
#include <string>

#include "lamella/error.hpp"

namespace lamella {

/// Writes `text` aside and renames it to `path` when it is complete; a device or a pipe is written in place, and
/// /dev/stdout is standard output wherever that leads. Errors: unwritable_file, out_of_memory.
Status write_text_file(const std::filesystem::path& path, const std::string& text) noexcept;

/// Removes what this process has written aside for `path` and not yet renamed: for a program that ends at once, while
/// another of its threads may still be writing.
void remove_unfinished(const std::filesystem::path& path) noexcept;

}  // namespace lamella
