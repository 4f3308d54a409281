// The subcommands. Each adds itself to the application and runs when it was the one chosen; all throw Failure.
#pragma once

#include <CLI/CLI.hpp>

#include "terminal/stages.hpp"

namespace lamella::cli {

void add_slice_command(CLI::App& app, Interrupt& interrupt);
void add_info_command(CLI::App& app, Interrupt& interrupt);
void add_check_command(CLI::App& app, Interrupt& interrupt);
void add_make_command(CLI::App& app, Interrupt& interrupt);
void add_convert_command(CLI::App& app, Interrupt& interrupt);
void add_merge_command(CLI::App& app, Interrupt& interrupt);
void add_verify_command(CLI::App& app, Interrupt& interrupt);
void add_batch_command(CLI::App& app, Interrupt& interrupt);

}  // namespace lamella::cli
