#include "files/combination.hpp"

#include <array>
#include <string_view>

#include "files/flags.hpp"

namespace lamella::cli {

namespace {

constexpr std::array<std::string_view, 5> rule_words = {"unite", "subtract", "intersect", "exclusive", "last"};

Rule rule_of(const Combination& combination, std::size_t archives) noexcept {
    const Rule rules[] = {unite, subtract, intersect(archives), exclusive, {.last_wins = true}};
    return combination.labels.empty() ? rules[combination.rule] : Rule{.labels = combination.labels};
}

/// Declares a repeatable option of values "ARCHIVE:" and what `take` reads into the set of this number; false: it is none.
void add_by_archive(CLI::App& command, const std::string& flag, const std::string& type, const std::string& help,
                    Combination& combination, std::function<bool(LayerSet&, std::string_view)> take) {
    const auto store = [flag, type, &combination, take = std::move(take)](const std::vector<std::string>& all) {
        for (const std::string& text : all) {
            const std::size_t colon = std::min(text.find(':'), text.size());
            std::uint32_t archive = 0;
            const std::string_view rest = std::string_view(text).substr(std::min(colon + 1, text.size()));
            if (!read_integer(std::string_view(text).substr(0, colon), archive) || archive >= most_layer_sets ||
                rest.empty() || !take(combination.archives[archive], rest)) {
                throw CLI::ValidationError(flag, in_quotes(text).append(" is not ").append(type));
            }
        }
    };
    add_repeatable(command, flag, type, help, store);
}

bool read_labels(const std::string& text, std::vector<std::uint32_t>& labels) {
    labels.clear();
    for (const std::string_view label : split(text, ',')) {
        if (!read_integer(label, labels.emplace_back())) {
            return false;
        }
    }
    return true;
}

}  // namespace

void declare_combination(CLI::App& command, Combination& combination) {
    add_choice(command, "--rule", rule_words,
               "What is solid: what lies in any archive; in the first and no other; in all; in an odd number; or in any, as "
               "the part of the last one (unite)",
               [&combination](std::size_t i) { combination.rule = i; });
    add_parsed(command, "--labels", "L,L,...",
               "2^n labels for n archives instead: the label of what lies in archives i, j, ... stands at 2^i + 2^j + ...; "
               "0: empty, label l: part l - 1",
               [&combination](const std::string& text) {
                   return read_labels(text, combination.labels) ? "" : "'" + text + "' is not a list of labels";
               })
        ->excludes("--rule");
    add_by_archive(command, "--grow", "ARCHIVE:MM",
                   "Grow this archive's layers first, counted from 0, or shrink them where MM is negative; repeatable",
                   combination, [](LayerSet& set, std::string_view text) {
                       const std::optional<double> mm = parse_number(text);
                       set.grow_mm = mm.value_or(0);
                       return mm.has_value();
                   });
    add_by_archive(
        command, "--shift", "ARCHIVE:A[:B]",
        "For layer n its layers n + A to n + B as one; repeatable: 1:1 of an archive given twice is what lies above",
        combination, [](LayerSet& set, std::string_view text) {
            const std::vector<std::string_view> ends = split(text, ':');
            return ends.size() <= 2 && read_integer(ends.front(), set.from) && read_integer(ends.back(), set.to);
        });
    add_by_archive(command, "--of-part", "ARCHIVE:PART", "Only contours of this part, counted from 0; repeatable",
                   combination, [](LayerSet& set, std::string_view text) { return read_integer(text, set.part.emplace()); });
    for (const std::string_view rule :
         {"--closing", "--offset", "--miter-limit", "--largest-only", "--drop-collinear", "--simplify"}) {
        declare_options(command, combination.after, rule);
    }
}

SliceResult combined(const std::vector<const SliceResult*>& layers, const std::vector<std::string>& names,
                     const Combination& combination, Stages& stages) {
    std::vector<LayerSet> sets(layers.size());
    for (const auto& [archive, set] : combination.archives) {
        refuse_if(archive >= sets.size(), bad_usage,
                  "there is no archive " + std::to_string(archive) +
                      " to grow, shift or take a part of: the first is 0, and there are " + std::to_string(sets.size()));
        sets[archive] = set;
    }
    for (std::size_t i = 0; i < sets.size(); ++i) {
        sets[i].layers = *layers[i];
    }
    SliceResult result;
    const Result<SliceInfo> done = stages.run("combining", [&](const Context& context) {
        return Overlay().combine(result, sets, rule_of(combination, sets.size()), combination.after.region, context);
    });
    if (!done) {
        const Failure failure = failure_of(done.error());
        const std::int64_t set = done.error().part;
        const std::string line = failure.what();
        throw Failure(
            failure.status(),
            set < 0 ? line : names[static_cast<std::size_t>(set)] + line.substr(("set " + std::to_string(set)).size()));
    }
    return result;
}

}  // namespace lamella::cli
