// Text in a CSV file.
#pragma once

#include <string>

namespace lamella {

/// Quoted where it has to be.
std::string csv_text(const std::string& text);

}  // namespace lamella
