// Text for people: counts with separators, the progress bar, single-line messages. Numbers and small text files as people
// write them: on the command line, in manifests, heights, matrices. And how a command fails: by one line for a person and an
// exit status for a script. A command as stages: the bar shows each, and SIGINT, SIGTERM and SIGHUP end it in an orderly
// way, so that nothing half-written stays behind.
#pragma once

#include <atomic>
#include <cstdint>
#include <limits>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "base/words.hpp"
#include "io/text/text.hpp"
#include "lamella/context.hpp"
#include "lamella/error.hpp"
#include "lamella/io/name_text.hpp"

namespace lamella::cli {

enum ExitStatus : int {
    done = 0,
    bad_usage = 2,
    bad_input = 3,
    bad_output = 4,
    some_failed = 5,  ///< items of a batch, or outputs that differ from their records
};

class Failure : public std::runtime_error {
public:
    Failure(ExitStatus status, const std::string& line) : std::runtime_error(line), status_(status) {}
    ExitStatus status() const noexcept { return status_; }

private:
    ExitStatus status_;
};

inline void refuse_if(bool wrong, ExitStatus status, const std::string& line) {
    if (wrong) {
        throw Failure(status, line);
    }
}

/// The exit status and line for an error of the library.
inline Failure failure_of(const Error& error) {
    const bool usage = error.code == ErrorCode::invalid_argument || error.code == ErrorCode::bad_planes ||
                       error.code == ErrorCode::result_too_large;
    const bool output = error.code == ErrorCode::unwritable_file;
    return {usage ? bad_usage : output ? bad_output : bad_input, error.message};
}

/// Throws Failure unless the library did what it was asked for. A line on what is wrong with `mesh`, where one is given,
/// names it; one on an option says all.
inline void done_or_thrown(const Status& status, const std::string& mesh = {}) {
    if (!status) {
        const Failure failure = failure_of(status.error());
        throw failure.status() == bad_input && !mesh.empty() ? Failure(bad_input, mesh + ": " + failure.what()) : failure;
    }
}

/// The value that the library made. Throws Failure where it made none.
template <class T>
T done_or_thrown(Result<T> result, const std::string& mesh = {}) {
    if (!result) {
        done_or_thrown(Status(result.error()), mesh);
    }
    return std::move(result).value();
}

inline constexpr int most_threads = 4096;  ///< that --threads takes

/// "lamella: TEXT", printable and as exactly one line.
std::string complaint(std::string_view text);

/// The same on stderr.
void complain(std::string_view text);
void warn(std::string_view text);

/// 1234567 as "1,234,567".
std::string grouped(std::uint64_t count);

/// "1 triangle", "1,234 triangles"; `plural` where an s does not make it.
std::string counted(std::uint64_t count, std::string_view noun, std::string_view plural = {});

/// Words with the separator between them.
template <class Words>
std::string joined(const Words& words, std::string_view separator = ", ") {
    std::string all;
    for (const std::string_view word : words) {
        all.append(all.empty() ? "" : separator).append(word);
    }
    return all;
}

/// The text, or nothing.
inline std::string when(bool so, std::string text) {
    return so ? std::move(text) : std::string();
}

/// With so many decimals.
std::string rounded(double value, int decimals);

/// For people, with at least six digits.
std::string measure_text(double value);

/// As "12.3 MB", or in smaller units what is smaller.
std::string file_size_text(std::uint64_t bytes);

/// "9.5 s", "35 s", "12 min", "3.4 h"
std::string duration_text(double seconds);

/// "1.2 M triangles/s"
std::string rate_text(double count, std::string_view noun, double seconds);

/// Writes all of `words`, as utf8_text(), to standard output; throws Failure (bad_output) when that cannot be done.
void print(std::string_view words);

/// Prints what a command did, unless it is to be quiet: on standard output, or on stderr where an output has taken that.
void print_words(std::string_view text, bool stdout_taken, bool quiet = false);

/// What a stage goes through: "triangles", "bytes". Unknown: 0.
struct Amount {
    double count = 0;
    std::string_view noun{};
};

/// A bar on stderr, redrawn at most ten times a second and wiped when done. After a second it also tells how fast it goes
/// and how long it will take: "slicing [####......] 43 %, 12.4 M triangles/s, 9.5 s left".
class ProgressBar {
public:
    enum class When : std::uint8_t { automatic, always, never };

    explicit ProgressBar(When when);
    ~ProgressBar() { wipe(); }
    ProgressBar(const ProgressBar&) = delete;
    ProgressBar& operator=(const ProgressBar&) = delete;

    bool shown() const noexcept { return shown_; }
    void show(std::string_view what, double fraction, const Amount& amount = {});
    void wipe();

private:
    bool shown_;
    bool drawn_ = false;
    std::string last_what_;
    Clock::time_point begin_;  ///< of what is shown
    Clock::time_point next_;
};

/// Milliseconds since construction.
class Stopwatch {
public:
    double ms() const { return milliseconds_since(begin_); }

private:
    Clock::time_point begin_ = Clock::now();
};

// --- stages

/// Signals, which a thread of its own takes until the process ends. Construct it before any other thread, so that all of
/// them inherit the blocked signals, and never destroy it.
class Interrupt {
public:
    Interrupt();  ///< throws Failure
    Interrupt(const Interrupt&) = delete;
    Interrupt& operator=(const Interrupt&) = delete;

    /// The files that will be written: what is unfinished of them goes with the process.
    void tidy(std::vector<std::string> outputs);

    /// From here on a signal becomes a stop request; until here it ends the process, and so does always the second one. One
    /// that comes when all is written is too late: the command ends as it would have.
    Callback<bool()> defer() noexcept;

    /// From here on a signal ends the process again, and one that was deferred does so now.
    void end_deferring() noexcept;

    /// Ends the process as the deferred signal would have, if one came.
    void die_if_interrupted() noexcept;

private:
    void take(int signal_number) noexcept;
    void die_by(int signal_number) noexcept;

    std::atomic<bool> deferring_ = false;
    std::atomic<int> signal_ = 0;
    std::mutex mutex_;  ///< of the outputs
    std::vector<std::string> outputs_;
};

/// The stages of a command, of which the bar shows each.
class Stages {
public:
    Stages(ProgressBar::When progress, int threads, Interrupt& interrupt)
        : bar_(progress), threads_(threads), interrupt_(interrupt) {}

    /// Returns what `call` does, which takes a Context. From here on a signal is a stop request.
    template <class Call>
    auto run(std::string_view what, const Call& call) {
        return run(what, Amount{}, call);
    }
    template <class Call>
    auto run(std::string_view what, const Amount& amount, const Call& call) {
        const auto show = [&](double fraction) noexcept { bar_.show(what, fraction, amount); };
        const Wiping wiping{bar_};
        show(0);
        return call(Context{.threads = threads_,
                            .stop = interrupt_.defer(),
                            .progress = bar_.shown() ? Callback<void(double)>(show) : Callback<void(double)>()});
    }

    /// The value that it makes; `ms` gets how long that takes. Throws Failure where it makes none.
    template <class Call>
    auto done(std::string_view what, const Call& call, double* ms = nullptr) {
        const Stopwatch watch;
        auto made = done_or_thrown(run(what, call));
        if (ms != nullptr) {
            *ms = watch.ms();
        }
        return made;
    }

    void warn(std::string_view text) {
        bar_.wipe();
        cli::warn(text);
    }

    Interrupt& interrupt() noexcept { return interrupt_; }

private:
    struct Wiping {
        ProgressBar& bar;
        ~Wiping() { bar.wipe(); }
    };

    ProgressBar bar_;
    int threads_;
    Interrupt& interrupt_;
};

// --- what people write

/// All of the file. Throws Failure (bad_input) of one that cannot be read, or is larger than `most_bytes`.
std::string read_bytes(const std::string& path, std::size_t most_bytes = std::numeric_limits<std::size_t>::max());

/// All of a file that people write, but for a byte-order mark. Throws Failure (bad_input) also of one larger than 1 GiB, and
/// of UTF-16.
std::string read_text(const std::string& path);

/// The pieces between separators, of which one more than of these: text that ends with one has an empty last piece.
std::vector<std::string_view> split(std::string_view text, char separator);

/// True if all of `text` is digits with one comma between them, as 0,5.
bool is_decimal_comma(std::string_view text) noexcept;
/// Its comma as a point.
std::string with_point(std::string_view text);

}  // namespace lamella::cli
