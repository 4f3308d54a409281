#include "batch/plan/item_plan.hpp"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <map>
#include <system_error>
#include <unordered_map>
#include <utility>

#include "batch/plan/name_pattern.hpp"
#include "files/output_path.hpp"
#include "outputs/output_formats.hpp"
#include "outputs/recorded_options.hpp"
#include "terminal/failure.hpp"

namespace lamella::cli::batch {

namespace {

using Values = std::vector<std::string>;

const Values& values_of(const OptionValues& all, const std::string& name) {
    static const Values none;
    const auto found = all.find(name);
    return found == all.end() ? none : found->second;
}

std::string value_of(const OptionValues& all, const std::string& name) {
    const Values& values = values_of(all, name);
    return values.empty() ? std::string() : values.back();
}

/// An option of the manifest takes the place of the one typed.
OptionValues merged(OptionValues common, const OptionValues& own) {
    for (const auto& [name, values] : own) {
        common[name] = values;
    }
    std::erase_if(common, [](const auto& option) { return option.second.empty(); });
    return common;
}

/// --like and --transform name files; --planes does where no list of numbers stands there.
Values files_named_by(const OptionValues& values) {
    Values files;
    for (const char* name : {"--like", "--transform", "--planes"}) {
        const std::string path = value_of(values, name);
        std::error_code unknown;
        if (!path.empty() && (std::string_view(name) != "--planes" || std::filesystem::exists(path, unknown))) {
            files.push_back(path);
        }
    }
    return files;
}

std::string in_place(const Item& item) {
    return item.place.empty() ? "" : item.place + ": ";
}

class ItemPlan {
public:
    ItemPlan(const OptionValues& common, const SliceWords& words) : common_(common), words_(words) {}

    void add(const MeshSource& source) {
        Item item;
        item.mesh = source.path;
        item.place = source.place;
        const OptionValues values = source.values.empty() ? common_ : merged(common_, source.values);
        try {
            if (!source.values.empty() || items.empty()) {
                words_.require_accepted(values);
            }
            fill(item, values, source);
        } catch (const Failure& failure) {
            throw Failure(failure.status(), in_place(item) + failure.what());
        }
        items.push_back(std::move(item));
    }

    /// In all of the batch no file is written twice, and none is an input.
    void require_distinct(const std::vector<std::string>& own_files) const {
        std::unordered_map<std::string, const Item*> writers;
        for (const Item& item : items) {
            for (const std::string& file : files_of(item)) {
                const auto [at, added] = writers.emplace(place_of(file), &item);
                if (!added) {
                    throw Failure(bad_usage, in_place(item) + "'" + at->second->mesh + "' and '" + item.mesh +
                                                 "' both write '" + file +
                                                 "'; {parent} or {dir} in --output tells them apart");
                }
            }
        }
        const auto require_unwritten = [&writers](const std::string& file, const std::string& what) {
            if (const auto written = writers.find(place_of(file)); written != writers.end()) {
                throw Failure(bad_usage, in_place(*written->second) + "--output: '" + file + "' is " + what);
            }
        };
        for (const std::string& file : own_files) {
            require_unwritten(file, "a file of the batch itself");
        }
        for (const Item& item : items) {
            require_unwritten(item.mesh, "a mesh of the batch itself");
            for (const std::string& file : item.option_files) {
                require_unwritten(file, "a file that an option of the batch names");
            }
        }
    }

    std::vector<Item> items;

private:
    static Values files_of(const Item& item) {
        Values files = item.files;
        if (!item.report.empty()) {
            files.push_back(item.report);
        }
        return files;
    }

    void fill(Item& item, const OptionValues& values, const MeshSource& source) const {
        for (const std::string& pattern : values_of(values, "--output")) {
            item.outputs.push_back(expand_pattern(pattern, source, "--output"));
        }
        if (item.outputs.empty()) {
            throw Failure(bad_usage, "--output: none is given, such as -o 'out/{stem}.nii.gz'");
        }
        item.to = value_of(values, "--to");
        item.report = value_of(values, "--report");
        if (!item.report.empty()) {
            item.report = expand_pattern(item.report, source, "--report");
        }
        plan_files(item, !value_of(values, "--split").empty());
        item.option_files = files_named_by(values);
        item.words = words_.words(with_changed_defaults(values), words_without_effect());
        item.plain = words_.words(plain_values(values), {});
        if (const std::string threads = value_of(values, "--threads"); !threads.empty()) {
            int count = 0;
            (void)std::from_chars(threads.data(), threads.data() + threads.size(), count);
            item.threads = count;
        }
    }

    static OptionValues with_changed_defaults(OptionValues values) {
        for (const ChangedDefault& changed : changed_defaults) {
            values.try_emplace(std::string(changed.name), Values{std::string(changed.now)});
        }
        return values;
    }

    static OptionValues plain_values(const OptionValues& values) {
        OptionValues plain;
        for (const char* name : {"--map", "--band", "--form"}) {
            if (const auto found = values.find(name); found != values.end()) {
                plain.insert(*found);
            }
        }
        return plain;
    }

    static void plan_files(Item& item, bool several_meshes) {
        for (const PlannedOutput& output : planned_outputs(item.outputs, item.to)) {
            if (output.path == "-" || item.report == "-") {
                throw Failure(bad_usage, "'-': a batch writes files");
            }
            for (const std::string& file : output.files(several_meshes)) {
                item.files.push_back(file);
            }
        }
    }

    const OptionValues& common_;
    const SliceWords& words_;
};

}  // namespace

std::vector<Item> plan_items(const std::vector<MeshSource>& sources, const OptionValues& common, const SliceWords& words,
                             const std::vector<std::string>& own_files) {
    ItemPlan plan(common, words);
    for (const MeshSource& source : sources) {
        plan.add(source);
    }
    plan.require_distinct(own_files);
    return std::move(plan.items);
}

std::vector<Item> items_of_shard(std::vector<Item> items, std::uint32_t index, std::uint32_t count) {
    std::vector<Item> own;
    for (std::size_t i = index; i < items.size(); i += count) {
        own.push_back(std::move(items[i]));
    }
    return own;
}

}  // namespace lamella::cli::batch
