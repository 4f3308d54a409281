// Checks of an output's path before the work for it is done.
#pragma once

#include <string>

namespace lamella::cli {

/// Throws Failure (bad_output) where `path`, or standard output for -, plainly cannot be written; a full disk shows only
/// later.
void require_writable(const std::string& path);

/// Throws Failure (bad_usage) if the path ends in another extension, and is no device or pipe.
void require_extension(const std::string& path, const std::string& option, const std::string& extension);

/// Where a file lies or would lie, whatever links and spellings its path has.
std::string place_of(const std::string& path);

/// Throws Failure (bad_usage) if both name the same file, whether it exists or not. An input and an output may both be
/// -, which are different streams: `require_different_output` is for two outputs.
void require_different(const std::string& path, const std::string& other, const std::string& name,
                       const std::string& other_name);
void require_different_output(const std::string& path, const std::string& other, const std::string& name,
                              const std::string& other_name);

}  // namespace lamella::cli
