// Every call on files that takes a Context, by name.
#pragma once

#include <filesystem>
#include <vector>

#include "engine/calls.hpp"
#include "lamella/io.hpp"

/// After `calls`: one that reads a file, and one that writes the other. The result must outlive them.
inline std::vector<ContextCall> file_calls(const std::filesystem::path& mesh, const lamella::SliceResult& result,
                                           const std::filesystem::path& svg, std::vector<ContextCall> calls = {}) {
    using lamella::Context;
    calls.push_back({"read_mesh", [mesh](const Context& c) { return code_of(read_mesh(mesh, {}, c)); }});
    calls.push_back(
        {"write_layers", [&result, svg](const Context& c) { return code_of(write_layers(result, svg, {}, c)); }});
    return calls;
}
