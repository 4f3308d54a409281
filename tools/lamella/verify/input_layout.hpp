// The inputs of a record under the names that the record has, for a process that makes the output once more.
#pragma once

#include <filesystem>
#include <string>

#include "lamella/medical/record.hpp"

namespace lamella::cli::verify {

/// Links in a folder of its own: names and warnings of inputs are part of some outputs.
class InputLayout {
public:
    /// `top` is made. Throws Failure (bad_input), std::filesystem::filesystem_error.
    InputLayout(const std::filesystem::path& top, const Record& record);

    /// Below `top`, so deep that no recorded path leads out of it.
    const std::filesystem::path& working_folder() const noexcept { return work_; }

    /// The word that names the input for a process in the working folder. Throws Failure (bad_input) where the record is
    /// nonsense.
    std::string add(const std::string& recorded, const std::filesystem::path& actual);

private:
    std::filesystem::path top_;
    std::filesystem::path work_;
    int elsewhere_ = 0;
};

}  // namespace lamella::cli::verify
