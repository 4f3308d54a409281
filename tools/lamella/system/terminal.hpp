// What is typed and printed, as systems have it: the words of the command line, the standard streams, the environment.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace lamella::cli {

/// The words of the command line, in UTF-8, without the program's own. From here on the standard streams take bytes as they
/// are.
std::vector<std::string> begin_program(int count, char** words);

/// True if people see what is written to stderr, and escape sequences work there.
bool is_terminal();

/// An error number of <cerrno>: 0 if standard output can be written to.
int check_standard_output() noexcept;

/// To stderr, without memory.
void write_error(std::string_view text) noexcept;

/// An empty value removes the variable, also from what processes inherit.
void set_environment(const char* name, const std::string& value);

/// Reading on where a mapped file has ended ends the process, from here on with this line and exit status. Systems that map
/// no files have no such end.
void explain_bus_errors(std::string line, int exit_status);

/// The paths that a pattern with *, ? or [ stands for, in order; none where something in its way cannot be listed. Windows
/// has no [, and patterns in names of files alone, not of folders.
std::optional<std::vector<std::string>> expand_glob(const std::string& pattern);

}  // namespace lamella::cli
