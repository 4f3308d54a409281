// What a mapped file does that ends before its mapping: the system sends SIGBUS to whoever reads on.
#pragma once

#include <string>

namespace lamella::cli {

/// From here on such a signal ends the process with one line that names `path` and the status of bad input. Nothing is being
/// written while the mesh is read, so there is nothing to tidy up.
void explain_bus_errors(const std::string& path);

}  // namespace lamella::cli
