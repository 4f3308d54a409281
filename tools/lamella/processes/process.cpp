#include "processes/process.hpp"

#include <chrono>
#include <cstdlib>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include "system/process.hpp"
#include "terminal/console.hpp"

namespace lamella::cli {

namespace {

constexpr std::chrono::milliseconds patience{2000};  ///< between asking a process to end and killing it
constexpr std::chrono::milliseconds between_looks{100};
constexpr std::size_t most_text = std::size_t{1} << 20;  ///< of one process that is kept

/// Sets the failure of a process that ended so, or its facts, by what it has printed: warnings, and in the end the facts or
/// the reason.
void set_outcome(const ProcessOutcome& outcome, std::string_view text, ProcessEnd& end) {
    constexpr std::string_view before = "lamella: ";
    std::string last;
    for (const std::string_view line : split(text, '\n')) {
        if (Facts facts = Facts::parse(line, nullptr, false); facts.is_object()) {
            end.facts = std::move(facts);
        } else if (!line.empty() && !line.starts_with("lamella: warning: ")) {
            last = line.substr(line.starts_with(before) ? before.size() : 0);
        }
    }
    if (!outcome.crash.empty()) {
        end.failure = outcome.crash;
        end.lacked_memory = outcome.lacked_memory;
        end.may_retry = true;
    } else if (outcome.exit_status != 0) {
        end.failure = last.empty() ? "ended with exit status " + std::to_string(outcome.exit_status) : last;
        end.lacked_memory = last.ends_with("out of memory");
        end.may_retry = end.lacked_memory;
    }
}

}  // namespace

void declare_worker(CLI::App& command) {
    const auto serve = [](std::uint64_t starter) {
        if (!end_with(starter)) {
            std::_Exit(bad_input);
        }
    };
    command.add_option_function<std::uint64_t>("--worker", serve)->group("");
}

ProcessEnd run_process(std::vector<std::string> words, const std::string& folder, double timeout_s,
                       const std::function<bool()>& stop) {
    std::optional<ChildProcess> process;
    try {
        process.emplace(std::move(words), folder, bad_input);
    } catch (const std::system_error& refused) {
        throw Failure(bad_input, cannot_start + refused.code().message());
    }
    const Stopwatch watch;
    bool late = false;
    std::optional<double> asked_ms;
    std::string text;
    while (process->read_output(text, between_looks)) {
        text.erase(0, text.size() > most_text ? text.size() - most_text / 2 : 0);
        late = late || (timeout_s > 0 && watch.ms() >= 1000 * timeout_s);
        if (!late && !stop()) {
            continue;
        }
        if (!asked_ms) {
            process->ask_to_end();
            asked_ms = watch.ms();
        } else if (watch.ms() >= *asked_ms + static_cast<double>(patience.count())) {
            process->kill();
        }
    }
    const ProcessOutcome outcome = process->wait();
    ProcessEnd end{.peak_bytes = outcome.peak_bytes};
    set_outcome(outcome, text, end);
    if (late) {
        end.failure = "took longer than " + exact_text(timeout_s) + " s";
        end.may_retry = true;
    }
    return end;
}

}  // namespace lamella::cli
