#include "io/write/output_file.hpp"

#include <cassert>
#include <cerrno>
#include <cstring>
#include <new>
#include <system_error>
#include <utility>

#include "base/system/machine.hpp"
#include "io/text/text.hpp"
#include "lamella/io/name_text.hpp"
#include "lamella/io/text_file.hpp"

namespace lamella {

namespace {

/// The number of the open file of this process that the path stands for, or -1.
int descriptor_named(const std::filesystem::path& named) {
    constexpr std::string_view numbered = "/dev/fd/";
    const std::string path = path_text(named);
    int number = -1;
    if (path.starts_with(numbered)) {
        return read_integer(std::string_view(path).substr(numbered.size()), number) ? number : -1;
    }
    return path == "/dev/stdout" ? 1 : path == "/dev/stderr" ? 2 : -1;
}

/// The beginning of the names of this process's files aside of `destination`: hidden, and short enough for any name limit.
std::filesystem::path aside_prefix(const std::filesystem::path& destination) {
    constexpr std::size_t longest_stem = 180;
    std::filesystem::path prefix = ".";
    prefix += destination.filename().native().substr(0, longest_stem);
    return prefix += "." + std::to_string(process_number()) + "-";
}

}  // namespace

Error unwritable(const std::filesystem::path& path, int error_number) {
    return {.code = ErrorCode::unwritable_file,
            .message = "cannot write '" + printable(path_text(path)) + "': " + system_message(error_number)};
}

void remove_unfinished(const std::filesystem::path& path) noexcept {
    try {
        std::error_code ignored;
        const std::filesystem::path real = std::filesystem::canonical(system_path(path), ignored);
        const std::filesystem::path destination = system_path(ignored ? path : real);
        const std::filesystem::path folder = destination.has_parent_path() ? destination.parent_path() : ".";
        const std::filesystem::path prefix = aside_prefix(destination);
        std::filesystem::directory_iterator entry;
        if (can_list(folder)) {
            entry = std::filesystem::directory_iterator(folder, ignored);
        }
        for (; entry != std::filesystem::directory_iterator(); entry.increment(ignored)) {
            if (entry->path().filename().native().starts_with(prefix.native())) {
                std::filesystem::remove(entry->path(), ignored);
            }
        }
    } catch (const std::bad_alloc&) {  // NOLINT(bugprone-empty-catch): without memory the file stays, and the end goes on
    }
}

Result<OutputFile> OutputFile::create(const std::filesystem::path& target) {
    if (descriptor_named(target) >= 0) {
        OutputFile file(target, target);
        const int error_number = file.open_in_place();
        return error_number == 0 ? Result<OutputFile>(std::move(file)) : unwritable(target, error_number);
    }
    std::error_code missing;
    const std::filesystem::file_status existing = std::filesystem::status(system_path(target), missing);
    const bool exists = std::filesystem::exists(existing);
    if (!exists && error_number_of(missing) != ENOENT) {
        return unwritable(target, error_number_of(missing));
    }
    if (target.filename().empty() || std::filesystem::is_directory(existing)) {
        return unwritable(target, EISDIR);
    }
    const bool in_place = exists && !std::filesystem::is_regular_file(existing);
    if (const int read_only = exists ? check_writable(target) : 0; read_only != 0) {
        return unwritable(target, read_only);
    }
    std::error_code unresolved;
    const std::filesystem::path real = std::filesystem::canonical(system_path(target), unresolved);
    OutputFile file(target, system_path(unresolved || in_place ? target : real));
    const int error_number = in_place ? file.open_in_place() : file.open_aside();
    if (error_number != 0) {
        return unwritable(target, error_number);
    }
    if (exists && !in_place) {
        // A file keeps its mode when it is replaced.
        std::filesystem::permissions(file.aside_, existing.permissions(), unresolved);
    }
    return file;
}

int OutputFile::open_in_place() {
    const int named = descriptor_named(destination_);
    return named >= 0 ? file_.duplicate(named) : file_.open_to_write(destination_);
}

int OutputFile::open_aside() {
    // Beside the target, so that the rename stays within one file system.
    return file_.create_unique(destination_.parent_path() / aside_prefix(destination_), ".part", 0666, aside_);
}

OutputFile::OutputFile(std::filesystem::path target, std::filesystem::path destination)
    : target_(std::move(target)), destination_(std::move(destination)), buffer_(new char[buffer_bytes]) {}

OutputFile::~OutputFile() {
    if (file_.is_open()) {
        (void)file_.close();
        if (!aside_.empty()) {
            std::error_code left_behind;
            std::filesystem::remove(aside_, left_behind);
        }
    }
}

char* OutputFile::room(std::size_t bytes) {
    assert(bytes <= buffer_bytes);
    if (buffer_bytes - used_ < bytes) {
        flush();
    }
    return buffer_.get() + used_;
}

void OutputFile::advance(const char* end) noexcept {
    used_ = static_cast<std::size_t>(end - buffer_.get());
    assert(used_ <= buffer_bytes);
}

void OutputFile::append(std::string_view text) {
    if (text.empty()) {  // and its place may be null
        return;
    }
    if (text.size() > buffer_bytes) {
        flush();
        write_out(text);
        return;
    }
    char* const to = room(text.size());
    std::memcpy(to, text.data(), text.size());
    advance(to + text.size());
}

void OutputFile::write_out(std::string_view text) noexcept {
    error_number_ = error_number_ == 0 ? file_.write(text) : error_number_;
}

void OutputFile::flush() noexcept {
    write_out({buffer_.get(), used_});
    used_ = 0;
}

Status OutputFile::commit(bool durable) {
    assert(file_.is_open());
    flush();
    for (const int failure : {durable ? file_.sync() : 0, file_.close()}) {
        error_number_ = error_number_ == 0 ? failure : error_number_;
    }
    if (aside_.empty()) {
        return error_number_ == 0 ? Status() : unwritable(target_, error_number_);
    }
    std::error_code failure;
    if (error_number_ == 0) {
        std::filesystem::rename(aside_, destination_, failure);
        error_number_ = error_number_of(failure);
    }
    if (error_number_ != 0) {
        std::filesystem::remove(aside_, failure);
        return unwritable(target_, error_number_);
    }
    if (File entries; durable && entries.open_to_read(destination_.parent_path()) == 0) {
        (void)entries.sync();  // some file systems have none for folders
    }
    return {};
}

Status write_text_file(const std::filesystem::path& path, const std::string& text) noexcept {
    return guarded([&]() -> Status {
        OutputFile file = require(OutputFile::create(path));
        file.append(text);
        return file.commit();
    });
}

}  // namespace lamella
