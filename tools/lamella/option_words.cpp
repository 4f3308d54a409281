#include "option_words.hpp"

#include <algorithm>
#include <array>
#include <string_view>

namespace lamella::cli {

std::vector<std::string> option_words(const CLI::App& command) {
    static constexpr std::array<std::string_view, 10> without_effect = {
        "",  // hidden options have no name
        "mesh", "--output", "--to", "--threads", "--progress", "--report", "--map", "--band", "--form"};
    std::vector<std::string> words;
    for (const CLI::Option* option : command.get_options()) {
        const std::string name = option->get_name();
        if (option->count() == 0 || std::find(without_effect.begin(), without_effect.end(), name) != without_effect.end()) {
            continue;
        }
        if (option->get_items_expected_max() == 0) {
            words.push_back(name);
            continue;
        }
        for (const std::string& value : option->results()) {
            words.insert(words.end(), {name, value});
        }
    }
    return words;
}

}  // namespace lamella::cli
