// The options of a slicing as its record holds them.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include "outputs/output_formats.hpp"

namespace lamella::cli {

/// An option that decides what comes out, as typed; flags have no value.
struct RecordedOption {
    std::string name;  ///< "--layer-height"
    std::optional<std::string> value;

    /// Whether the value is a path of a file that decides the output, such as --like's.
    bool names_file() const;
};

/// An option of slice whose default is not what it was. Records and results of a batch state it always: where one does not,
/// an older version made it, by the older default.
struct ChangedDefault {
    std::string_view name;
    std::string_view now;
    std::string_view before;
};
inline constexpr std::array changed_defaults = {ChangedDefault{"--fill-rule", "non-zero", "contours"},
                                                ChangedDefault{"--close-gaps", "auto", "0"}};

/// Those that were given to slice, and those of changed_defaults, in the order of `lamella slice --help`. Left out is what
/// says only where results go or how they are made.
std::vector<RecordedOption> recorded_options(const CLI::App& slice_command);

/// A record's words: name, value, name, ... Those that the output does not depend on are left out.
std::vector<std::string> record_words(const std::vector<RecordedOption>& options, const PlannedOutput& output);

/// Whether records hold the option of this name.
bool is_recorded(const std::string& name);

/// An option that takes no value.
bool is_flag(const CLI::Option& option);

}  // namespace lamella::cli
