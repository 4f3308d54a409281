// The options of a command as a person typed them.
#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace lamella::cli {

/// Those that decide what comes out, for records: no paths of outputs, no threads, nothing hidden.
std::vector<std::string> option_words(const CLI::App& command);

}  // namespace lamella::cli
