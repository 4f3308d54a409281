#include "batch/results/item_state.hpp"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <system_error>

#include <sys/stat.h>

#include "lamella/medical/record.hpp"
#include "outputs/recorded_options.hpp"
#include "terminal/failure.hpp"

namespace lamella::cli::batch {

namespace {

std::int64_t modified_ns(const struct stat& file) {
    return std::int64_t{file.st_mtim.tv_sec} * 1'000'000'000 + file.st_mtim.tv_nsec;
}

/// As of a DICOM series: its files, and none of the folders in it.
InputFact fact_of_folder(const std::string& path) {
    InputFact fact{path, 0, 0, ""};
    std::error_code problem;
    for (std::filesystem::directory_iterator at(path, problem); !problem && at != std::filesystem::directory_iterator();
         at.increment(problem)) {
        struct stat file {};
        if (::stat(at->path().c_str(), &file) == 0 && S_ISREG(file.st_mode)) {
            fact.bytes += static_cast<std::uint64_t>(file.st_size);
            fact.modified_ns = std::max(fact.modified_ns, modified_ns(file));
        }
    }
    return fact;
}

}  // namespace

InputFact fact_of(const std::string& path, bool hash, const StopCheck& stop) {
    struct stat file {};
    if (::stat(path.c_str(), &file) != 0) {
        return {path, 0, 0, ""};
    }
    if (S_ISDIR(file.st_mode)) {
        return fact_of_folder(path);
    }
    InputFact fact{path, static_cast<std::uint64_t>(file.st_size), 0, ""};
    if (!hash || !S_ISREG(file.st_mode)) {
        fact.modified_ns = modified_ns(file);
        return fact;
    }
    Control control;
    control.stop = stop;
    Result<FileSeal> seal = seal_file(path, control);
    if (!seal && seal.error().code == ErrorCode::cancelled) {
        throw failure_of(seal.error());
    }
    if (seal) {
        fact.bytes = seal->bytes;
        fact.sha256 = std::move(seal->sha256);
    }
    return fact;
}

std::vector<OutputFact> outputs_of(const Item& item) {
    std::vector<OutputFact> outputs;
    for (const std::string& path : item.files) {
        std::error_code unknown;
        const std::uintmax_t bytes = std::filesystem::file_size(path, unknown);
        outputs.push_back({path, unknown ? std::nullopt : std::optional<std::uint64_t>(bytes)});
    }
    return outputs;
}

bool is_of_older_version(const ResultLine& line) {
    return std::any_of(changed_defaults.begin(), changed_defaults.end(), [&](const ChangedDefault& changed) {
        return std::none_of(line.options.begin(), line.options.end(),
                            [&](const std::string& word) { return word.starts_with(std::string(changed.name) + "="); });
    });
}

bool is_done(const Item& item, const ResultLine& line) {
    std::error_code unknown;
    return line.done() && line.mesh == item.mesh && line.options == item.words && line.inputs == item.inputs &&
           line.outputs == outputs_of(item) && line.outputs.front().bytes.has_value() &&
           (item.report.empty() || std::filesystem::exists(item.report, unknown));
}

}  // namespace lamella::cli::batch
