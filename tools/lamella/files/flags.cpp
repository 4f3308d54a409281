#include "files/flags.hpp"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>

#include "base/system/file.hpp"
#include "options/option_words.hpp"

namespace lamella::cli {

namespace {

// --- text that people write

/// "A:B", "A:" or ":B": layers from A up to, but not with, B. False where it is none of these; what is not given stays.
bool parse_layers(std::string_view text, std::uint64_t& first, std::uint64_t& end) {
    const auto part = [](std::string_view digits, std::uint64_t& value) {
        return digits.empty() || read_integer(digits, value);
    };
    const std::size_t colon = text.find(':');
    return colon != std::string_view::npos && part(text.substr(0, colon), first) && part(text.substr(colon + 1), end) &&
           first < end;
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
        throw Failure(bad_input, path + ":" + std::to_string(pair->line) + ": " + in_quotes(pair->text) +
                                     " is one number or two: write numbers as 0.5, or separate them by ; or blanks");
    }
    return true;
}

struct NumberFile {
    std::vector<double> values;
    std::vector<std::size_t> lines;  ///< where each value stands, from 1
};

/// Numbers separated by white space, semicolons or commas; # begins a comment. In columns separated by semicolons or tabs
/// commas may be decimal ones. Throws Failure naming the file and the line.
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
                throw Failure(bad_input,
                              path + ":" + std::to_string(word.line) + ": " + in_quotes(text) + " is not a number");
            }
            numbers.values.push_back(*value);
            numbers.lines.push_back(word.line);
        }
    }
    return numbers;
}

// --- options.inc

/// A line of options.inc, but for what tells its kind and where it is stored.
struct OptionLine {
    std::string flag;
    std::string help;
    double least = -no_limit;
    bool exclusive = false;   ///< it must be more than `least`
    std::string_view word{};  ///< for a special value
    double value_of_word = 0;
};

/// A number, "MM" or another of its type.
CLI::Option* add_limited(CLI::App& command, const OptionLine& line, const std::string& type,
                         std::function<void(double)> take) {
    const std::string word(line.word);
    std::string wanted = type == "MM" ? "a number of mm" : "a number";
    if (line.least > -no_limit) {
        wanted += std::string(" that is ") + (line.exclusive ? "more than " : "at least ") + exact_text(line.least);
    }
    const auto read = [line, word, wanted, take = std::move(take)](const std::string& text) {
        const std::optional<double> number =
            !word.empty() && text == word ? std::optional(line.value_of_word) : parse_number(text);
        if (!number || (text != word && (line.exclusive ? *number <= line.least : *number < line.least))) {
            return "'" + text + "' is " + (word.empty() ? "not " + wanted : "neither " + wanted + " nor " + word);
        }
        take(*number);
        return std::string();
    };
    CLI::Option* const option = add_parsed(command, line.flag, type + when(!word.empty(), "|" + word), line.help, read);
    return word.empty() ? option : option->transform(in_lower_case);
}

void declare_number(CLI::App& command, const OptionLine& line, double& value) {
    add_limited(command, line, "N", [&value](double number) { value = number; });
}

template <class Number>
void declare_mm(CLI::App& command, const OptionLine& line, Number& value) {
    add_limited(command, line, "MM", [&value](double mm) { value = mm; });
}

constexpr auto declare_optional_mm = declare_mm<std::optional<double>>;

void declare_flag(CLI::App& command, const OptionLine& line, bool& value) {
    command.add_flag(line.flag, value, line.help);
}

template <class Enum>
void declare_choice(CLI::App& command, const OptionLine& line, Enum& value) {
    static constexpr auto words = detail::words_of(Enum{});
    add_choice(command, line.flag, words, line.help, value);
}

void declare_heights(CLI::App& command, const OptionLine& line, std::optional<std::vector<double>>& heights) {
    const auto take = [&heights](const std::string& text) -> std::string {
        heights = parse_numbers(text, ',');
        std::error_code unknown;
        if (!heights && text.find(',') != std::string::npos && !std::filesystem::exists(path_of(text), unknown)) {
            return "'" + text + "' is neither a list of numbers nor a file";
        }
        if (!heights && (heights = read_numbers(text).values)->empty()) {
            throw Failure(bad_input, text + ": no heights");
        }
        return "";
    };
    add_parsed(command, line.flag, "FILE|Z,Z,...", line.help, take)->check(given);
}

void declare_slabs(CLI::App& /*command*/, const OptionLine& /*line*/, const std::vector<Slab>& /*no flag of the tool*/) {}

constexpr std::array<double, 4> last_row = {0, 0, 0, 1};  ///< of a 4x4 matrix

void declare_transform(CLI::App& command, const OptionLine& line, Transform& transform) {
    const auto take = [&transform](const std::string& path) {
        const NumberFile file = read_numbers(path);
        const std::size_t count = file.values.size();
        refuse_if(count != transform.m.size() && count != 16, bad_input,
                  path + ": " + counted(count, "number") + " where a 3x4 matrix has 12 and a 4x4 one 16");
        const bool is_affine = count == 12 || std::equal(file.values.begin() + 12, file.values.end(), last_row.begin());
        refuse_if(!is_affine, bad_input,
                  path + ":" + std::to_string(file.lines[count - 4]) + ": the last row is not 0 0 0 1");
        std::copy_n(file.values.begin(), transform.m.size(), transform.m.begin());
        refuse_if(transform.is_singular(), bad_input,
                  path + ": the matrix is singular: its determinant is 0, so that it flattens every mesh");
        return "";
    };
    add_parsed(command, line.flag, "FILE", line.help, take)->check(given);
}

void declare_fill_from(CLI::App& command, const OptionLine& line, std::vector<FillFrom>& rules) {
    const auto take = [flag = line.flag, &rules](const std::vector<std::string>& all) {
        constexpr auto words = detail::words_of(FillRule{});
        rules.clear();
        for (const std::string& text : all) {
            const std::size_t colon = std::min(text.find(':'), text.size());
            const auto* const rule = std::find(words.begin(), words.end(), text.substr(std::min(colon + 1, text.size())));
            FillFrom& from = rules.emplace_back();
            if (!read_integer(text.substr(0, colon), from.first_layer) || rule == words.end()) {
                throw CLI::ValidationError(flag, "'" + text + "' is not LAYER:RULE, such as 12:non-zero");
            }
            from.rule = static_cast<FillRule>(rule - words.begin());
        }
    };
    add_repeatable(command, line.flag, "LAYER:RULE", line.help, take)->transform(in_lower_case);
}

/// Options and values as earlier versions recorded them.
struct OlderWord {
    std::string_view name;
    std::string_view value;  ///< empty: any, which stays
    std::string_view name_now;
    std::string_view value_now;
};
constexpr std::array<OlderWord, 7> older_words = {{{"--gap-sense", "kept", "--stitch-direction", "oriented"},
                                                   {"--gap-sense", "", "--stitch-direction", ""},
                                                   {"--close-gaps", "", "--stitch", ""},
                                                   {"--close", "", "--closing", ""},
                                                   {"--mark-near", "", "--flag-closing", ""},
                                                   {"--tolerance", "", "--simplify", ""},
                                                   {"--grid", "auto", "--grid", "finest"}}};

}  // namespace

const std::array<ChangedDefault, 2> changed_defaults = {
    {{"--fill-rule", "non-zero", "contours"}, {"--stitch", "auto", "0"}}};

std::string given(const std::string& text) {
    return text.empty() ? "is empty" : "";
}

CLI::Option* add_parsed(CLI::App& command, const std::string& flag, const std::string& type, const std::string& help,
                        std::function<std::string(const std::string&)> take) {
    const auto store = [flag, take = std::move(take)](const std::string& text) {
        if (const std::string wrong = take(text); !wrong.empty()) {
            throw CLI::ValidationError(flag, wrong);
        }
    };
    return command.add_option_function<std::string>(flag, store, help)->type_name(type);
}

CLI::Option* add_number(CLI::App& command, const std::string& flag, const std::string& type, const std::string& help,
                        std::function<void(double)> take) {
    return add_limited(command, {.flag = flag, .help = help, .least = 0}, type, std::move(take));
}

CLI::Option* add_bytes(CLI::App& command, const std::string& flag, const std::string& type, const std::string& help,
                       std::uint64_t& bytes) {
    const auto take = [&bytes](std::string text) {
        std::string wrong = "'" + text + "' is not a number of bytes, such as 4000000000 or 4G";
        try {
            (void)CLI::AsSizeValue(false)(text);
        } catch (const CLI::ValidationError&) {
            return wrong;
        }
        const bool in_range = read_integer(std::string_view(text), bytes) && bytes > 0 && bytes >> 62 == 0;
        return in_range ? std::string() : wrong;
    };
    return add_parsed(command, flag, type, help, take)->check(given);
}

CLI::Option* add_triple(CLI::App& command, const std::string& flag, const std::string& help,
                        std::function<std::string(const std::array<double, 3>&)> take) {
    return add_parsed(command, flag, "X,Y,Z", help,
                      [take = std::move(take)](const std::string& text) {
                          const std::vector<double> values = parse_numbers(text, ',').value_or(std::vector<double>());
                          const std::string wrong =
                              values.size() == 3 ? take({values[0], values[1], values[2]}) : " is not three numbers X,Y,Z";
                          return when(!wrong.empty(), "'" + text + "'" + wrong);
                      })
        ->check(given);
}

CLI::Option* add_range(CLI::App& command, const std::string& flag, const std::string& help,
                       std::function<void(double, double)> take) {
    return add_parsed(command, flag, "MIN:MAX", help,
                      [take = std::move(take)](const std::string& text) {
                          const std::vector<double> ends = parse_numbers(text, ':').value_or(std::vector<double>());
                          const bool good = ends.size() == 2 && ends[0] > 0 && ends[1] >= ends[0];
                          if (good) {
                              take(ends[0], ends[1]);
                          }
                          return when(!good, "'" + text + "' is not MIN:MAX in mm with 0 < MIN <= MAX");
                      })
        ->check(given);
}

CLI::Option* add_repeatable(CLI::App& command, const std::string& flag, const std::string& type, const std::string& help,
                            const std::function<void(const std::vector<std::string>&)>& take) {
    return command.add_option_function<std::vector<std::string>>(flag, take, help)
        ->type_name(type)
        ->take_all()
        ->allow_extra_args(false);
}

CLI::Option* add_count(CLI::App& command, const std::string& flag, const std::string& help,
                       std::function<void(std::uint64_t)> take) {
    return add_parsed(command, flag, "N", help, [take = std::move(take)](const std::string& text) {
        std::uint64_t count = 0;
        const bool counts = read_integer(std::string_view(text), count);
        take(count);
        return counts ? "" : "'" + text + "' is not a whole number that is at least 0";
    });
}

CLI::Option* add_choice(CLI::App& command, const std::string& flag, std::span<const std::string_view> words,
                        const std::string& help, std::function<void(std::size_t)> take) {
    const std::string names = joined(words, "|");
    const auto store = [names, words, take = std::move(take)](const std::string& text) {
        const auto found = std::find(words.begin(), words.end(), text);
        if (found == words.end()) {
            return "'" + text + "' is not one of " + names;
        }
        take(static_cast<std::size_t>(found - words.begin()));
        return std::string();
    };
    return add_parsed(command, flag, names, help, store)->transform(in_lower_case);
}

void declare_options(CLI::App& command, SliceOptions& options, std::string_view only) {
    const auto is_wanted = [&](std::string_view flag) {
        return !flag.empty() && (only.empty() || only == flag) && command.get_option_no_throw(std::string(flag)) == nullptr;
    };
    // The two lines of a range are one flag.
    const auto declare_count = [&](CLI::App& app, const OptionLine& line, std::uint64_t& /*first or end*/) {
        add_parsed(app, line.flag, "A:B", line.help, [&planes = options.planes](const std::string& text) {
            return parse_layers(text, planes.first_layer, planes.end_layer)
                       ? ""
                       : "'" + text + "' is not A:B with A < B, such as 0:100";
        });
    };
#define OPTION(kind, name, path, python, flag, least, exclusive, word, value, needs_region, help)     \
    if (is_wanted(flag)) {                                                                            \
        declare_##kind(command, OptionLine{flag, help, least, exclusive, word, value}, options.path); \
    }
#include "options/options.inc"
}

SliceOptions tool_options() {
    SliceOptions options;
    options.stitch_mm = stitch_by_mesh;
    make_region(options);
    return options;
}

void make_region(SliceOptions& options) {
    if (options.region.keeps_contours()) {
        options.region.fill_rule = FillRule::non_zero;
    }
}

void put_in_words_of_today(std::vector<std::string>& words) {
    for (std::size_t i = 0; i + 1 < words.size(); ++i) {
        for (const OlderWord& older : older_words) {
            if (older.name == words[i] && (older.value.empty() || older.value == words[i + 1])) {
                words[i] = older.name_now;
                words[i + 1] = older.value.empty() ? words[i + 1] : std::string(older.value_now);
                break;
            }
        }
    }
}

std::string_view name_of_today(std::string_view flag) {
    const auto* const older = std::find_if(older_words.begin(), older_words.end(), [&](const OlderWord& word) {
        return word.name == flag && word.name != word.name_now;
    });
    return older == older_words.end() ? std::string_view() : older->name_now;
}

bool is_file_of(std::string_view flag, const std::string& value) {
    std::string_view kind;
#define OPTION(kind_of_line, name, path, python, own_flag, ...) kind = flag == own_flag ? #kind_of_line : kind;
#include "options/options.inc"
    return kind == "transform" || (kind == "heights" && !parse_numbers(value, ','));
}

}  // namespace lamella::cli
