// Every call on files that takes a Context, by name.
#pragma once

#include <filesystem>
#include <vector>

#include "engine/calls.hpp"
#include "lamella/io.hpp"

/// Reads one file and writes the other. The result must outlive the calls.
inline std::vector<ContextCall> file_calls(const std::filesystem::path& mesh, const lamella::SliceResult& result,
                                           const std::filesystem::path& svg) {
    using lamella::Context;
    return {{"read_mesh", [mesh](const Context& c) { return code_of(read_mesh(mesh, {}, c)); }},
            {"write_svg", [&result, svg](const Context& c) { return code_of(write_svg(result, svg, {}, c)); }}};
}
