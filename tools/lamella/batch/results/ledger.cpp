#include "batch/results/ledger.hpp"

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>
#include <tuple>
#include <unordered_set>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include "terminal/failure.hpp"

namespace lamella::cli::batch {

namespace {

Failure unwritable_results(const std::string& path, int error_number) {
    return {bad_output, "cannot write '" + path + "': " + std::generic_category().message(error_number)};
}

/// 0, or an error number.
int write_fully(int descriptor, std::string_view text) noexcept {
    while (!text.empty()) {
        const ssize_t written = ::write(descriptor, text.data(), text.size());
        if (written < 0 && errno != EINTR) {
            return errno;
        }
        text.remove_prefix(static_cast<std::size_t>(std::max<ssize_t>(written, 0)));
    }
    return 0;
}

void sync_folder(const std::string& folder) noexcept {
    const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor >= 0) {
        (void)::fsync(descriptor);  // Some file systems have none for folders.
        ::close(descriptor);
    }
}

/// Calls `use` with each whole line, without its end; the bytes up to the first that `use` refuses are returned.
template <class Use>
std::size_t for_each_line(std::string_view text, const Use& use) {
    std::size_t begin = 0;
    while (true) {
        const std::size_t end = text.find('\n', begin);
        if (end == std::string_view::npos || !use(text.substr(begin, end - begin))) {
            return begin;
        }
        begin = end + 1;
    }
}

std::string text_of_results(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    if (!file.is_open() || file.bad()) {
        throw Failure(bad_input, "cannot read '" + path + "': " + std::generic_category().message(errno));
    }
    return text;
}

}  // namespace

std::string LedgerName::path() const {
    if (shards == 0) {
        return path_of_whole();
    }
    return (std::filesystem::path(folder) /
            ("results." + std::to_string(shard) + "-of-" + std::to_string(shards) + ".jsonl"))
        .string();
}

std::string LedgerName::path_of_whole() const {
    return (std::filesystem::path(folder) / "results.jsonl").string();
}

Ledger::Ledger(const LedgerName& name) : path_(name.path()), shard_(name.shards > 0) {
    open_and_lock();
    std::error_code unknown;
    if (shard_ && std::filesystem::exists(name.path_of_whole(), unknown)) {
        read_lines(name.path_of_whole(), false);
    }
    read_lines(path_, true);
}

Ledger::~Ledger() {
    ::close(descriptor_);
}

void Ledger::open_and_lock() {
    descriptor_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
    if (descriptor_ < 0) {
        throw unwritable_results(path_, errno);
    }
    // Where a file system has no locks, that two batches do not meet is up to who starts them.
    if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
        ::close(descriptor_);
        throw Failure(bad_output, path_ + ": another lamella batch is at work on it");
    }
}

void Ledger::read_lines(const std::string& path, bool own) {
    const std::string text = text_of_results(path);
    const std::size_t whole = for_each_line(text, [&](std::string_view line) {
        std::optional<ResultLine> result = parse_line(line);
        const bool is_result = result.has_value();
        if (is_result) {
            std::string key = result->key();
            lines_.insert_or_assign(std::move(key), *std::move(result));
        }
        return is_result;
    });
    if (!own) {
        return;
    }
    if (text.find('\n', whole) != std::string::npos) {
        ::close(descriptor_);
        throw Failure(
            bad_input,
            path + ":" +
                std::to_string(1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(whole), '\n')) +
                ": no line of lamella batch");
    }
    bytes_ = whole;
    if (whole < text.size() && ::ftruncate(descriptor_, static_cast<off_t>(whole)) != 0) {
        ::close(descriptor_);
        throw unwritable_results(path, errno);
    }
}

const ResultLine* Ledger::find(const std::string& key) const {
    const auto found = lines_.find(key);
    return found == lines_.end() ? nullptr : &found->second;
}

void Ledger::append(const ResultLine& result) {
    const std::string line = line_of(result);
    int error_number = write_fully(descriptor_, line);
    if (error_number == 0 && ::fsync(descriptor_) != 0) {
        error_number = errno;
    }
    if (error_number != 0) {
        (void)!::ftruncate(descriptor_, static_cast<off_t>(bytes_));
        throw unwritable_results(path_, error_number);
    }
    bytes_ += line.size();
    lines_.insert_or_assign(result.key(), result);
}

void Ledger::finish(const std::vector<Item>& items) {
    std::unordered_set<std::string> keys;
    std::unordered_set<std::string> written;
    for (const Item& item : items) {
        keys.insert(item.key());
        written.insert(item.files.begin(), item.files.end());
    }
    std::erase_if(lines_, [&](const auto& line) {
        return !keys.contains(line.first) &&
               (shard_ || std::any_of(line.second.outputs.begin(), line.second.outputs.end(),
                                      [&](const OutputFact& output) { return written.contains(output.path); }));
    });
    write_durably(path_, ordered_text(lines_));
}

std::string ordered_text(const std::unordered_map<std::string, ResultLine>& lines) {
    std::vector<const ResultLine*> order;
    order.reserve(lines.size());
    for (const auto& [key, line] : lines) {
        order.push_back(&line);
    }
    std::sort(order.begin(), order.end(), [](const ResultLine* a, const ResultLine* b) {
        return std::tie(a->mesh, a->key()) < std::tie(b->mesh, b->key());
    });
    std::string text;
    for (const ResultLine* line : order) {
        text += line_of(*line);
    }
    return text;
}

void write_durably(const std::string& path, const std::string& text) {
    const std::filesystem::path target(path);
    const std::string folder = target.has_parent_path() ? target.parent_path().string() : ".";
    const std::string aside = folder + "/." + target.filename().string() + "." + std::to_string(::getpid()) + "-0.part";
    const int descriptor = ::open(aside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (descriptor < 0) {
        throw unwritable_results(path, errno);
    }
    int error_number = write_fully(descriptor, text);
    if (error_number == 0 && ::fsync(descriptor) != 0) {
        error_number = errno;
    }
    if (::close(descriptor) != 0 && error_number == 0) {
        error_number = errno;
    }
    if (error_number == 0 && ::rename(aside.c_str(), path.c_str()) != 0) {
        error_number = errno;
    }
    if (error_number != 0) {
        ::unlink(aside.c_str());
        throw unwritable_results(path, error_number);
    }
    sync_folder(folder);
}

std::vector<ResultLine> read_results(const std::string& path) {
    std::vector<ResultLine> results;
    const std::string text = text_of_results(path);
    const std::size_t whole = for_each_line(text, [&](std::string_view line) {
        std::optional<ResultLine> result = parse_line(line);
        const bool is_result = result.has_value();
        if (is_result) {
            results.push_back(*std::move(result));
        }
        return is_result;
    });
    if (text.find('\n', whole) != std::string::npos) {
        throw Failure(bad_input, path + ":" + std::to_string(results.size() + 1) + ": no line of lamella batch");
    }
    return results;
}

}  // namespace lamella::cli::batch
