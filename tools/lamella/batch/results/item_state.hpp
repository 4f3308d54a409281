// Whether an item is done already.
#pragma once

#include "batch/plan/item.hpp"
#include "batch/results/result_line.hpp"
#include "lamella/control.hpp"

namespace lamella::cli::batch {

/// What is known of a file: its time, or its content. Of a folder: the bytes in its files, and the latest time. A file that
/// cannot be read has no bytes and no time: the item then says why. Throws Failure where `stop` ends it.
InputFact fact_of(const std::string& path, bool hash, const StopCheck& stop);

/// Done: the line says so, of the same mesh, options and inputs, and every output is there in the size that it says, or is
/// not there if it says so (slice within --memory leaves out a table).
bool is_done(const Item& item, const ResultLine& line);

/// Whether the line does not state what every line of this version does: see changed_defaults.
bool is_of_older_version(const ResultLine& line);

/// The outputs of an item with their sizes; an output that is not there has none.
std::vector<OutputFact> outputs_of(const Item& item);

}  // namespace lamella::cli::batch
