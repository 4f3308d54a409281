// The flags of `lamella batch`: those of slice, and its own.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "batch/results/ledger.hpp"
#include "slice/slice_arguments.hpp"

namespace lamella::cli::batch {

struct BatchArguments {
    SliceArguments slice;  ///< its meshes are the sources; what it holds else is read from the command
    int jobs = 0;          ///< 0: as many as there are processors
    std::string memory;
    double timeout_s = 0;
    int retries = 1;
    std::string shard;
    std::string results;
    bool force = false;
    bool hash = false;
    bool merge = false;

    const std::vector<std::string>& sources() const noexcept { return slice.meshes; }
};

void declare_batch(CLI::App& command, BatchArguments& arguments);

/// Of "I/N"; none where it is empty. Throws Failure (bad_usage).
LedgerName ledger_name_of(const BatchArguments& arguments);

}  // namespace lamella::cli::batch
