// The options of `lamella slice` by name, as a batch passes them on: which there are, which values they take, and whether
// they go together.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace lamella::cli::batch {

/// Values by the option's name with its dashes, "--layer-height"; a flag has the value "true".
using OptionValues = std::map<std::string, std::vector<std::string>>;

class SliceWords {
public:
    SliceWords();

    /// The name with dashes of an option that an item may have: of "layer-height", "layer_height" or "--layer-height". Empty
    /// if there is none of that name.
    std::string name_of(const std::string& text) const;
    /// As slice declares it.
    const CLI::Option& option(const std::string& name) const { return *prototype_.get_option(name); }
    /// The options that slice does not take together with --memory, as they need the whole mesh.
    std::vector<std::string> names_without_memory() const;

    /// What was typed for `command`, which has the options of slice and more.
    OptionValues typed(const CLI::App& command) const;

    /// "--layer-height=0.5", in the order of `lamella slice --help`.
    std::vector<std::string> words(const OptionValues& values) const;

    /// Throws Failure (bad_usage) if slice would refuse these options.
    void require_accepted(const OptionValues& values) const;

private:
    CLI::App prototype_;
};

}  // namespace lamella::cli::batch
