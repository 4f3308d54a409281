#include "verify/record_words.hpp"

#include <cstddef>
#include <optional>

#include "slice/slice_arguments.hpp"
#include "terminal/failure.hpp"

namespace lamella::cli {

std::vector<RecordedOption> parse_record_words(const std::vector<std::string>& words) {
    CLI::App slice_command;
    SliceArguments arguments;
    declare(slice_command, arguments);
    std::vector<RecordedOption> options;
    for (std::size_t i = 0; i < words.size(); ++i) {
        const std::string& name = words[i];
        const CLI::Option* const option = name.starts_with("--") ? slice_command.get_option_no_throw(name) : nullptr;
        if (option == nullptr || !is_recorded(name)) {
            throw Failure(bad_input, "'" + name + "' is no option that a record holds");
        }
        if (is_flag(*option)) {
            options.push_back({name, std::nullopt});
        } else if (i + 1 < words.size()) {
            options.push_back({name, words[++i]});
        } else {
            throw Failure(bad_input, "its option " + name + " has no value");
        }
    }
    return options;
}

}  // namespace lamella::cli
