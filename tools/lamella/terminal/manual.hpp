// The manual page and the completion of the tool, made from what its commands declare.
#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace lamella::cli {

/// In the language of man(7).
std::string manual_of(const CLI::App& app);

/// A script that bash sources: commands, options, words that an option takes; else names of files.
std::string bash_completion_of(const CLI::App& app);

}  // namespace lamella::cli
