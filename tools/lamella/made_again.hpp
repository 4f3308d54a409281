// An output made once more, by this program itself, from the inputs and options of its record.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "lamella/context.hpp"
#include "lamella/medical/record.hpp"

namespace lamella::cli::verify {

/// How many of the record's inputs the output was made of: meshes, archives or parts. What options name follows them.
std::size_t count_of_parts(const Record& record) noexcept;

/// How the output differs from one made again, if it does: one line a finding. `output`: where it lies, with what lies
/// beside it, such as a table of labels. `inputs`: where each input of the record lies now, as absolute paths. They are laid
/// out under the names that the record has, since names and warnings are part of some outputs. Throws Failure where the
/// output cannot be made again.
std::vector<std::string> differences_from_remade(const Record& record, const std::filesystem::path& output,
                                                 const std::vector<std::filesystem::path>& inputs, const Context& context);

}  // namespace lamella::cli::verify
