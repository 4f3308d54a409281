// The options of a record, read back.
#pragma once

#include <string>
#include <vector>

#include "outputs/recorded_options.hpp"

namespace lamella::cli {

/// The reverse of record_words(). Throws Failure (bad_input) unless all words are options of slice that records hold.
std::vector<RecordedOption> parse_record_words(const std::vector<std::string>& words);

}  // namespace lamella::cli
