// How archives are combined: the flags of lamella combine, and the rule and sets that they stand for.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "lamella/context.hpp"
#include "lamella/options.hpp"
#include "lamella/overlay.hpp"
#include "terminal/console.hpp"

namespace lamella::cli {

struct Combination {
    std::size_t rule = 0;                      ///< index of a word
    std::vector<std::uint32_t> labels{};       ///< instead of the rule; empty: not given
    std::map<std::size_t, LayerSet> archives;  ///< what is said of them, by their numbers from 0 on; without layers
    SliceOptions after{};                      ///< of which rules of regions are used
};

/// Declares the flags that decide what comes of the archives.
void declare_combination(CLI::App& command, Combination& combination);

/// Combines the layers of archives, which `names` names in messages. Throws Failure.
SliceResult combined(const std::vector<const SliceResult*>& layers, const std::vector<std::string>& names,
                     const Combination& combination, Stages& stages);

}  // namespace lamella::cli
