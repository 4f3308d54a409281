#include <algorithm>
#include <cerrno>
#include <iterator>

#include "base/system/file.hpp"
#include "base/system/windows.hpp"

namespace lamella {

namespace {

HANDLE as_handle(std::intptr_t handle) noexcept {
    return reinterpret_cast<HANDLE>(handle);
}

int last_error() noexcept {
    return error_number_of({static_cast<int>(::GetLastError()), std::system_category()});
}

int open(const std::filesystem::path& path, DWORD access, DWORD creation, DWORD flags, std::intptr_t& handle) {
    constexpr DWORD share_all = FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE;
    const HANDLE opened = ::CreateFileW(system_path(path).c_str(), access, share_all, nullptr, creation, flags, nullptr);
    handle = reinterpret_cast<std::intptr_t>(opened);
    return opened == INVALID_HANDLE_VALUE ? last_error() : 0;
}

OVERLAPPED place(std::uint64_t offset) noexcept {
    OVERLAPPED at{};
    at.Offset = static_cast<DWORD>(offset);
    at.OffsetHigh = static_cast<DWORD>(offset >> 32);
    return at;
}

/// Calls step(bytes done so far, most at once, bytes done by it) until all are: sizes have 32 bits.
template <class Step>
int in_steps(std::size_t bytes, int none_done, const Step& step) noexcept {
    constexpr std::size_t largest = std::size_t{1} << 30;
    for (std::size_t done = 0; done < bytes;) {
        DWORD more = 0;
        const bool failed = step(done, static_cast<DWORD>(std::min(bytes - done, largest)), &more) == 0;
        if (failed && ::GetLastError() != ERROR_HANDLE_EOF) {
            return last_error();
        }
        if (more == 0) {
            return none_done;
        }
        done += more;
    }
    return 0;
}

}  // namespace

std::string system_message(int error_number) {
    return error_number == EBUSY ? "in use by another program" : std::generic_category().message(error_number);
}

std::string path_text(const std::filesystem::path& path) {
    const std::u8string text = path.u8string();
    return {text.begin(), text.end()};
}

std::filesystem::path system_path(const std::filesystem::path& path) {
    constexpr std::size_t longest_unmarked = 240;  // of 260, and a folder's leaves room for the name of a file
    const std::wstring& name = path.native();
    std::wstring full(std::size_t{1} << 15, 0);
    full.resize(::GetFullPathNameW(name.c_str(), static_cast<DWORD>(full.size()), full.data(), nullptr));
    if (full.size() < longest_unmarked || full.starts_with(LR"(\\?\)")) {
        return path;
    }
    return full.starts_with(LR"(\\)") ? LR"(\\?\UNC)" + full.substr(1) : LR"(\\?\)" + full;
}

int File::open_to_read(const std::filesystem::path& path) {
    return open(path, GENERIC_READ, OPEN_EXISTING, FILE_FLAG_BACKUP_SEMANTICS, handle_);  // folders too
}

int File::open_to_write(const std::filesystem::path& path) {
    return open(path, GENERIC_WRITE, OPEN_EXISTING, FILE_ATTRIBUTE_NORMAL, handle_);
}

int File::create(const std::filesystem::path& path, unsigned /*mode*/) {  // permissions are those of the folder
    return open(path, GENERIC_READ | GENERIC_WRITE, CREATE_NEW, FILE_ATTRIBUTE_NORMAL, handle_);
}

int File::create_scratch(const std::filesystem::path& folder) {
    constexpr DWORD flags = FILE_ATTRIBUTE_TEMPORARY | FILE_FLAG_DELETE_ON_CLOSE;
    std::filesystem::path made;
    return make_unique(folder / ".lamella-", {}, made, [&](const std::filesystem::path& path) {
        return open(path, GENERIC_READ | GENERIC_WRITE, CREATE_NEW, flags, handle_);
    });
}

int File::duplicate(int number) noexcept {
    constexpr DWORD standard[] = {STD_INPUT_HANDLE, STD_OUTPUT_HANDLE, STD_ERROR_HANDLE};
    if (number < 0 || number >= std::ssize(standard)) {
        return EBADF;
    }
    const HANDLE process = ::GetCurrentProcess();
    HANDLE copy = INVALID_HANDLE_VALUE;
    const bool made =
        ::DuplicateHandle(process, ::GetStdHandle(standard[number]), process, &copy, 0, FALSE, DUPLICATE_SAME_ACCESS) != 0;
    handle_ = reinterpret_cast<std::intptr_t>(copy);
    return made ? 0 : last_error();
}

int File::status(FileStatus& status) const noexcept {
    using Type = std::filesystem::file_type;
    const DWORD type = ::GetFileType(as_handle(handle_));
    if (type != FILE_TYPE_DISK) {
        status = {type == FILE_TYPE_PIPE ? Type::fifo : Type::character, 0, 0};
        return 0;
    }
    BY_HANDLE_FILE_INFORMATION found{};
    if (::GetFileInformationByHandle(as_handle(handle_), &found) == 0) {
        return last_error();
    }
    const auto joined = [](DWORD high, DWORD low) { return std::uint64_t{high} << 32 | low; };
    status = {(found.dwFileAttributes & FILE_ATTRIBUTE_DIRECTORY) != 0 ? Type::directory : Type::regular,
              joined(found.nFileSizeHigh, found.nFileSizeLow),
              joined(found.ftLastWriteTime.dwHighDateTime, found.ftLastWriteTime.dwLowDateTime)};
    return 0;
}

int File::read_at(std::span<std::byte> into, std::uint64_t offset) const noexcept {
    return in_steps(into.size(), ended, [&](std::size_t done, DWORD most, DWORD* more) {
        OVERLAPPED at = place(offset + done);
        return ::ReadFile(as_handle(handle_), into.data() + done, most, more, &at);
    });
}

int File::write_at(std::span<const std::byte> from, std::uint64_t offset) noexcept {
    return in_steps(from.size(), EIO, [&](std::size_t done, DWORD most, DWORD* more) {
        OVERLAPPED at = place(offset + done);
        return ::WriteFile(as_handle(handle_), from.data() + done, most, more, &at);
    });
}

int File::write(std::string_view text) noexcept {
    return in_steps(text.size(), EIO, [&](std::size_t done, DWORD most, DWORD* more) {
        return ::WriteFile(as_handle(handle_), text.data() + done, most, more, nullptr);
    });
}

int File::close() noexcept {
    return is_open() && ::CloseHandle(as_handle(std::exchange(handle_, none))) == 0 ? last_error() : 0;
}

int check_writable(const std::filesystem::path& path) {
    const DWORD attributes = ::GetFileAttributesW(system_path(path).c_str());
    return attributes != INVALID_FILE_ATTRIBUTES && (attributes & FILE_ATTRIBUTE_READONLY) != 0 ? EACCES : 0;
}

}  // namespace lamella
