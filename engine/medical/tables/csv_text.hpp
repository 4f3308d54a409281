// Text in a CSV file.
#pragma once

#include <string>

namespace lamella {

/// In UTF-8, and quoted where it has to be.
std::string csv_text(const std::string& bytes);

}  // namespace lamella
