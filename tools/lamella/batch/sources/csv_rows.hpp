// CSV as RFC 4180 has it, or with semicolons or tabs in place of commas: quoted cells that may hold commas, quotes ("") and
// line ends; LF or CRLF.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace lamella::cli::batch {

struct CsvRow {
    std::vector<std::string> cells;
    std::size_t line = 0;  ///< where the row begins, from 1
};

/// Comma, semicolon or tab: what separates the names in the first line; comma where there is one name. Throws Failure where
/// there are several.
char separator_of(std::string_view text, const std::string& name);

/// For messages.
std::string name_of(char separator);

/// The rows of `text`, but for those without a word. Throws Failure naming `name` and the line of a cell whose quotes do not
/// match.
std::vector<CsvRow> csv_rows(std::string_view text, char separator, const std::string& name);

}  // namespace lamella::cli::batch
