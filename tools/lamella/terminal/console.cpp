#include "terminal/console.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <system_error>

#include <unistd.h>

namespace lamella::cli {

std::string complaint(std::string_view text) {
    return "lamella: " + printable(text) + "\n";
}

void complain(std::string_view text) {
    (void)std::fputs(complaint(text).c_str(), stderr);
}

void warn(std::string_view text) {
    complain("warning: " + std::string(text));
}

std::string grouped(std::uint64_t count) {
    const std::string digits = std::to_string(count);
    std::string text;
    for (std::size_t i = 0; i < digits.size(); ++i) {
        if (i > 0 && (digits.size() - i) % 3 == 0) {
            text += ',';
        }
        text += digits[i];
    }
    return text;
}

std::string counted(std::uint64_t count, std::string_view noun, std::string_view plural) {
    const bool irregular = count != 1 && !plural.empty();
    return grouped(count) + " " + std::string(irregular ? plural : noun) + (count == 1 || irregular ? "" : "s");
}

std::string rounded(double value, int decimals) {
    std::array<char, 400> text{};  // The largest double has 309 digits before the point.
    (void)std::snprintf(text.data(), text.size(), "%.*f", decimals, value);
    return text.data();
}

std::string measure_text(double value) {
    if (value == 0 || !std::isfinite(value)) {
        return rounded(value, 3);
    }
    const int digits_before_point = static_cast<int>(std::floor(std::log10(std::abs(value)))) + 1;
    return rounded(value, std::max(3, 6 - digits_before_point));
}

std::string hexadecimal(std::uint64_t value) {
    std::array<char, 17> text{};
    (void)std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(value));
    return text.data();
}

std::string file_size_text(std::uint64_t bytes) {
    constexpr std::uint64_t kilobyte = 1000;
    constexpr std::uint64_t megabyte = 1000 * kilobyte;
    if (bytes < 10 * kilobyte) {
        return grouped(bytes) + " bytes";
    }
    return bytes < megabyte ? rounded(static_cast<double>(bytes) / kilobyte, 1) + " kB"
                            : rounded(static_cast<double>(bytes) / megabyte, 1) + " MB";
}

void print(std::string_view words) {
    const std::string text = utf8_text(words);
    if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0) {
        throw Failure(bad_output, "cannot write to standard output: " + std::generic_category().message(errno));
    }
}

void print_words(std::string_view text, bool stdout_taken) {
    if (stdout_taken) {
        (void)std::fputs(utf8_text(text).c_str(), stderr);
    } else {
        print(text);
    }
}

ProgressBar::ProgressBar(When when)
    : shown_(when == When::always || (when == When::automatic && ::isatty(STDERR_FILENO) == 1)) {}

void ProgressBar::show(std::string_view what, double fraction) {
    const auto now = std::chrono::steady_clock::now();
    if (!shown_ || (drawn_ && now < next_ && what == last_what_)) {
        return;
    }
    constexpr int width = 40;
    const double share = std::clamp(fraction, 0.0, 1.0);
    const auto filled = static_cast<std::size_t>(share * width);
    const std::string line = "\r\x1b[K" + std::string(what) + " [" + std::string(filled, '#') +
                             std::string(width - filled, '.') + "] " + rounded(100 * share, 0) + " %";
    (void)std::fputs(line.c_str(), stderr);
    (void)std::fflush(stderr);
    drawn_ = true;
    last_what_ = what;
    next_ = now + std::chrono::milliseconds(100);
}

void ProgressBar::wipe() {
    if (drawn_) {
        (void)std::fputs("\r\x1b[K", stderr);
        drawn_ = false;
    }
}

std::optional<std::uint64_t> system_number(const std::string& path, std::string_view key) {
    std::ifstream file(path);
    std::uint64_t number = 0;
    for (std::string word; file >> word;) {
        if (word == key && file >> number) {
            return number;
        }
    }
    return std::nullopt;
}

std::uint64_t peak_rss_bytes() {
    // Not getrusage(): what it reports survives exec, so a large parent process would be reported instead.
    return system_number("/proc/self/status", "VmHWM:").value_or(0) * 1024;
}

}  // namespace lamella::cli
