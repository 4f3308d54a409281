#include "terminal/console.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <memory>
#include <system_error>

#include "base/system/file.hpp"
#include "lamella/io/text_file.hpp"
#include "system/process.hpp"
#include "system/terminal.hpp"

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
    std::string digits = std::to_string(count);
    for (std::size_t end = digits.size(); end > 3; end -= 3) {
        digits.insert(end - 3, ",");
    }
    return digits;
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

std::string file_size_text(std::uint64_t bytes) {
    const auto size = static_cast<double>(bytes);
    return size < 1e4   ? grouped(bytes) + " bytes"
           : size < 1e6 ? rounded(size / 1e3, 1) + " kB"
                        : rounded(size / 1e6, 1) + " MB";
}

std::string duration_text(double seconds) {
    constexpr double minute = 60;
    constexpr double hour = 60 * minute;
    if (seconds < 2 * minute) {
        return rounded(seconds, seconds < 10 ? 1 : 0) + " s";
    }
    return seconds < 2 * hour ? rounded(seconds / minute, 0) + " min" : rounded(seconds / hour, 1) + " h";
}

std::string rate_text(double count, std::string_view noun, double seconds) {
    const double thousands = count / std::max(seconds, 1e-3) / 1e3;
    return rounded(thousands < 1e3 ? thousands : thousands / 1e3, 1) + (thousands < 1e3 ? " k " : " M ") +
           std::string(noun) + "/s";
}

void print(std::string_view words) {
    const std::string text = utf8_text(words);
    if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0) {
        throw Failure(bad_output, "cannot write to standard output: " + std::generic_category().message(errno));
    }
}

void print_words(std::string_view text, bool stdout_taken, bool quiet) {
    if (quiet) {
        return;
    }
    if (stdout_taken) {
        (void)std::fputs(utf8_text(text).c_str(), stderr);
    } else {
        print(text);
    }
}

ProgressBar::ProgressBar(When when) : shown_(when == When::always || (when == When::automatic && is_terminal())) {}

void ProgressBar::show(std::string_view what, double fraction, const Amount& amount) {
    const auto now = Clock::now();
    begin_ = drawn_ && what == last_what_ ? begin_ : now;
    if (!shown_ || (drawn_ && now < next_ && what == last_what_)) {
        return;
    }
    constexpr int width = 40;
    const double share = std::clamp(fraction, 0.0, 1.0);
    const auto filled = static_cast<std::size_t>(share * width);
    std::string line = "\r\x1b[K" + std::string(what) + " [" + std::string(filled, '#') + std::string(width - filled, '.') +
                       "] " + rounded(100 * share, 0) + " %";
    if (const double seconds = milliseconds_since(begin_) / 1000; seconds > 1 && share > 0.01) {
        line += when(amount.count > 0, ", " + rate_text(share * amount.count, amount.noun, seconds)) + ", " +
                duration_text(seconds * (1 / share - 1)) + " left";
    }
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

Interrupt::Interrupt() {
    try {
        take_signals([](void* own, int number) { static_cast<Interrupt*>(own)->take(number); }, this);
    } catch (const std::system_error& refused) {
        throw Failure(bad_input,
                      "cannot start a thread, as there are too many or too little memory: " + refused.code().message());
    }
}

void Interrupt::tidy(std::vector<std::string> outputs) {
    const std::lock_guard lock(mutex_);
    outputs_ = std::move(outputs);
}

Callback<bool()> Interrupt::defer() noexcept {
    deferring_ = true;
    return {this, [](void* own) noexcept { return static_cast<Interrupt*>(own)->signal_ != 0; }};
}

void Interrupt::end_deferring() noexcept {
    deferring_ = false;
    die_if_interrupted();
}

void Interrupt::take(int signal_number) noexcept {
    if (!deferring_ || signal_ != 0) {
        die_by(signal_number);
    }
    signal_ = signal_number;
}

/// As if the signal had never been handled: shells and schedulers see its number in the exit status.
void Interrupt::die_by(int signal_number) noexcept {
    const std::lock_guard lock(mutex_);
    for (const std::string& output : outputs_) {
        remove_unfinished(path_of(output));
    }
    complain("interrupted");
    end_by_signal(signal_number);
}

void Interrupt::die_if_interrupted() noexcept {
    if (const int signal_number = signal_; signal_number != 0) {
        die_by(signal_number);
    }
}

bool is_decimal_comma(std::string_view text) noexcept {
    const std::size_t comma = text.find(',');
    text.remove_prefix(text.starts_with('-') || text.starts_with('+') ? 1 : 0);
    return comma != std::string_view::npos && text.find_first_not_of("0123456789,") == std::string_view::npos &&
           text.find(',') == text.rfind(',') && text.front() != ',' && text.back() != ',';
}

std::string with_point(std::string_view text) {
    std::string number(text);
    std::replace(number.begin(), number.end(), ',', '.');
    return number;
}

std::string read_bytes(const std::string& path, std::size_t most_bytes) {
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(open_stream(path_of(path)), &std::fclose);
    std::string text;
    std::vector<char> piece(std::size_t{1} << 16);
    std::size_t count = 0;
    while (file && (count = std::fread(piece.data(), 1, piece.size(), file.get())) > 0) {
        text.append(piece.data(), count);
        refuse_if(text.size() > most_bytes, bad_input, path + ": too large for such a file");
    }
    refuse_if(!file || std::ferror(file.get()) != 0, bad_input,
              "cannot read '" + path + "': " + std::generic_category().message(errno));
    return text;
}

std::string read_text(const std::string& path) {
    std::string text = read_bytes(path, std::size_t{1} << 30);
    const std::string_view start = std::string_view(text).substr(0, 2);
    refuse_if(start == "\xff\xfe" || start == "\xfe\xff" || start.find('\0') != std::string_view::npos, bad_input,
              path + ": is text in UTF-16: save it as UTF-8");
    return text.starts_with("\xef\xbb\xbf") ? text.substr(3) : text;
}

std::vector<std::string_view> split(std::string_view text, char separator) {
    std::vector<std::string_view> pieces;
    for (std::size_t end = text.find(separator); end != std::string_view::npos; end = text.find(separator)) {
        pieces.push_back(text.substr(0, end));
        text.remove_prefix(end + 1);
    }
    pieces.push_back(text);
    return pieces;
}

}  // namespace lamella::cli
