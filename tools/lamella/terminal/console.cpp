#include "terminal/console.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <system_error>

#include <unistd.h>

namespace lamella::cli {

namespace {

constexpr std::string_view blanks = " \t\r\v\f";

std::string_view trimmed(std::string_view text) {
    const std::size_t first = text.find_first_not_of(blanks);
    return first == std::string_view::npos ? std::string_view{}
                                           : text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

/// For messages: shortened, and fit to print, as what is no number may be of a binary file.
std::string quoted(std::string_view word) {
    constexpr std::size_t longest = 40;
    return "'" + printable(word.substr(0, longest)) + (word.size() > longest ? "...'" : "'");
}

/// Stands between white space and semicolons.
struct Word {
    std::string_view text;
    std::size_t line;
};

struct WordList {
    std::vector<Word> words;
    bool in_columns = false;  ///< separated by semicolons or tabs
};

WordList words_of(std::string_view text) {
    constexpr std::string_view separators = " \t\r\v\f;";
    WordList list;
    for (std::size_t number = 1; !text.empty(); ++number) {
        const std::size_t line_end = std::min(text.find('\n'), text.size());
        const std::string_view line = text.substr(0, std::min(line_end, text.find('#')));
        text.remove_prefix(std::min(line_end + 1, text.size()));
        list.in_columns = list.in_columns || line.find_first_of("\t;") != std::string_view::npos;
        for (std::size_t begin = line.find_first_not_of(separators); begin != std::string_view::npos;) {
            const std::size_t end = std::min(line.find_first_of(separators, begin), line.size());
            list.words.push_back({line.substr(begin, end - begin), number});
            begin = line.find_first_not_of(separators, end);
        }
    }
    return list;
}

/// True if commas are decimal ones: in columns of whole numbers and such as 0,5. Throws Failure of a file that may be read
/// in both ways.
bool has_decimal_commas(const WordList& list, const std::string& path) {
    const auto separates = [](const Word& word) {
        return word.text.find('.') != std::string_view::npos ||
               (word.text.find(',') != std::string_view::npos && !is_decimal_comma(word.text));
    };
    const auto pair =
        std::find_if(list.words.begin(), list.words.end(), [](const Word& word) { return is_decimal_comma(word.text); });
    if (pair == list.words.end()) {
        return false;
    }
    const bool separated = std::any_of(list.words.begin(), list.words.end(), separates);
    if (separated && !list.in_columns) {
        return false;
    }
    if (separated || !list.in_columns) {
        throw Failure(bad_input, path + ":" + std::to_string(pair->line) + ": " + quoted(pair->text) +
                                     " is one number or two: write numbers as 0.5, or separate them by ; or blanks");
    }
    return true;
}

}  // namespace

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
    const auto now = Clock::now();
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

std::optional<double> parse_number(std::string_view text) noexcept {
    if (text.size() > 1 && text[0] == '+' && text[1] != '-') {
        text.remove_prefix(1);
    }
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
        return std::nullopt;
    }
    return value;
}

std::optional<std::vector<double>> parse_list(std::string_view text) {
    std::vector<double> values;
    for (const std::string_view piece : split(text, ',')) {
        const std::optional<double> value = parse_number(trimmed(piece));
        if (!value) {
            return std::nullopt;
        }
        values.push_back(*value);
    }
    return values;
}

std::array<double, 3> parse_triple(std::string_view text, const std::string& option) {
    const std::vector<double> values = parse_list(text).value_or(std::vector<double>());
    refuse_if(values.size() != 3, bad_usage, option + ": '" + std::string(text) + "' is not three numbers X,Y,Z");
    return {values[0], values[1], values[2]};
}

std::uint64_t parse_bytes(const std::string& text, const std::string& option) {
    std::uint64_t bytes = 0;
    const char* const end = text.data() + text.size();
    const auto [stop, problem] = std::from_chars(text.data(), end, bytes);
    std::string_view suffix(stop, static_cast<std::size_t>(end - stop));
    unsigned shift = 0;
    if (!suffix.empty()) {
        constexpr std::string_view letters = "KMGT";
        const std::size_t letter = letters.find(suffix.front() == 'k' ? 'K' : suffix.front());
        shift = letter == std::string_view::npos ? 64 : 10 * (static_cast<unsigned>(letter) + 1);
        suffix.remove_prefix(1);
    }
    const bool rest = !(suffix.empty() || suffix == "B" || suffix == "iB");
    if (problem != std::errc() || rest || shift == 64 || bytes == 0 || bytes > (std::uint64_t{1} << 62 >> shift)) {
        throw Failure(bad_usage, option + ": '" + text + "' is not a number of bytes, such as 4000000000 or 4G");
    }
    return bytes << shift;
}

bool parse_layers(std::string_view text, std::uint64_t& first, std::uint64_t& end) {
    const auto part = [](std::string_view digits, std::uint64_t& value) {
        return digits.empty() || read_integer(digits, value);
    };
    const std::size_t colon = text.find(':');
    return colon != std::string_view::npos && part(text.substr(0, colon), first) && part(text.substr(colon + 1), end) &&
           first < end;
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
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), &std::fclose);
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

NumberFile read_numbers(const std::string& path) {
    const std::string whole = read_text(path);
    const WordList list = words_of(whole);
    const bool decimal = has_decimal_commas(list, path);
    NumberFile numbers;
    for (const Word& word : list.words) {
        for (const std::string_view piece : split(word.text, decimal ? ' ' : ',')) {
            if (piece.empty()) {
                continue;
            }
            const std::string text = with_point(piece);
            const std::optional<double> value = parse_number(text);
            if (!value) {
                throw Failure(bad_input, path + ":" + std::to_string(word.line) + ": " + quoted(std::string_view(text)) +
                                             " is not a number");
            }
            numbers.values.push_back(*value);
            numbers.lines.push_back(word.line);
        }
    }
    return numbers;
}

}  // namespace lamella::cli
