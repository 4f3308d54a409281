// Text for people: counts with separators, the progress bar, single-line messages.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "lamella/io/name_text.hpp"

namespace lamella::cli {

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

/// With so many decimals.
std::string rounded(double value, int decimals);

/// Shortest decimal text that reads back as the same number.
std::string exact_text(double value);

/// 16 digits.
std::string hexadecimal(std::uint64_t value);

/// As "12.3 MB", or in smaller units what is smaller.
std::string file_size_text(std::uint64_t bytes);

/// Writes all of `words`, as utf8_text(), to standard output; throws Failure (bad_output) when that cannot be done.
void print(std::string_view words);

/// Prints what a command did: on standard output, or on stderr where an output has taken that.
void print_words(std::string_view text, bool stdout_taken);

/// A bar on stderr, redrawn at most ten times a second and wiped when done.
class ProgressBar {
public:
    enum class When : std::uint8_t { automatic, always, never };

    explicit ProgressBar(When when);
    ~ProgressBar() { wipe(); }
    ProgressBar(const ProgressBar&) = delete;
    ProgressBar& operator=(const ProgressBar&) = delete;

    bool shown() const noexcept { return shown_; }
    void show(std::string_view what, double fraction);
    void wipe();

private:
    bool shown_;
    bool drawn_ = false;
    std::string last_what_;
    std::chrono::steady_clock::time_point next_;
};

/// Milliseconds since construction.
class Stopwatch {
public:
    double ms() const {
        return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin_).count();
    }

private:
    std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

/// The number after `key` in a file of the system, as after "MemTotal:" in /proc/meminfo; none if it is not there.
std::optional<std::uint64_t> system_number(const std::string& path, std::string_view key);

/// Largest resident size so far.
std::uint64_t peak_rss_bytes();

}  // namespace lamella::cli
