#include <algorithm>
#include <cerrno>
#include <chrono>
#include <system_error>

#include "base/system/file.hpp"
#include "base/system/machine.hpp"
#include "base/system/windows.hpp"

namespace lamella {

namespace {

constexpr DWORD share_all = FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE;
constexpr std::size_t largest_step = std::size_t{1} << 30;  // sizes of reads and writes have 32 bits

HANDLE as_handle(std::intptr_t handle) noexcept {
    return reinterpret_cast<HANDLE>(handle);
}

/// The number in <cerrno> of the last error.
int last_error() noexcept {
    switch (::GetLastError()) {
        case ERROR_FILE_NOT_FOUND:
        case ERROR_PATH_NOT_FOUND:
        case ERROR_INVALID_NAME:
        case ERROR_BAD_NETPATH:
        case ERROR_INVALID_DRIVE:
            return ENOENT;
        case ERROR_ACCESS_DENIED:
        case ERROR_WRITE_PROTECT:
            return EACCES;
        case ERROR_SHARING_VIOLATION:
        case ERROR_LOCK_VIOLATION:
        case ERROR_USER_MAPPED_FILE:
            return EBUSY;
        case ERROR_FILE_EXISTS:
        case ERROR_ALREADY_EXISTS:
            return EEXIST;
        case ERROR_DISK_FULL:
        case ERROR_HANDLE_DISK_FULL:
            return ENOSPC;
        case ERROR_BROKEN_PIPE:
        case ERROR_NO_DATA:
            return EPIPE;
        case ERROR_TOO_MANY_OPEN_FILES:
            return EMFILE;
        case ERROR_NOT_ENOUGH_MEMORY:
        case ERROR_OUTOFMEMORY:
            return ENOMEM;
        case ERROR_FILENAME_EXCED_RANGE:
            return ENAMETOOLONG;
        case ERROR_INVALID_HANDLE:
            return EBADF;
        case ERROR_DIRECTORY:
            return ENOTDIR;
        default:
            return EIO;
    }
}

int error_where(bool failed) noexcept {
    return failed ? last_error() : 0;
}

/// Paths of 260 characters and more need to be absolute and to be marked. Throws std::bad_alloc.
std::wstring long_path(const std::filesystem::path& path) {
    constexpr std::size_t longest_unmarked = 240;  // and room for the name within a folder
    const std::wstring& native = path.native();
    std::wstring full(std::size_t{1} << 15, L'\0');
    if (native.starts_with(L"\\\\?\\")) {
        return native;
    }
    full.resize(::GetFullPathNameW(native.c_str(), static_cast<DWORD>(full.size()), full.data(), nullptr));
    if (full.size() < longest_unmarked) {
        return native;
    }
    return full.starts_with(L"\\\\") ? L"\\\\?\\UNC" + full.substr(1) : L"\\\\?\\" + full;
}

/// Calls use(path as Windows takes it), an error number.
template <class Use>
int with_long_path(const std::filesystem::path& path, const Use& use) noexcept {
    try {
        return use(long_path(path).c_str());
    } catch (const std::exception&) {
        return ENOMEM;
    }
}

int open(const std::filesystem::path& path, DWORD access, DWORD share, DWORD creation, DWORD flags,
         std::intptr_t& handle) noexcept {
    return with_long_path(path, [&](const wchar_t* name) {
        handle = reinterpret_cast<std::intptr_t>(::CreateFileW(name, access, share, nullptr, creation, flags, nullptr));
        return error_where(as_handle(handle) == INVALID_HANDLE_VALUE);
    });
}

/// A name that no file of this process had.
std::filesystem::path unique_name(const std::filesystem::path& folder, std::string_view prefix, int attempt) {
    const auto now = std::chrono::steady_clock::now().time_since_epoch().count();
    return folder / (std::string(prefix) + "-" + std::to_string(process_number()) + "-" + std::to_string(now + attempt));
}

/// Calls make(name) until the name is not taken.
template <class Make>
int make_unique(const std::filesystem::path& folder, std::string_view prefix, std::filesystem::path& made,
                const Make& make) {
    constexpr int most_attempts = 100;
    int failure = EEXIST;
    for (int attempt = 0; attempt < most_attempts && failure == EEXIST; ++attempt) {
        made = unique_name(folder, prefix, attempt);
        failure = make(made);
    }
    return failure;
}

OVERLAPPED place(std::uint64_t offset) noexcept {
    OVERLAPPED at{};
    at.Offset = static_cast<DWORD>(offset);
    at.OffsetHigh = static_cast<DWORD>(offset >> 32);
    return at;
}

/// Calls step(bytes done so far, most at once, bytes done by it) until all are.
template <class Step>
int in_steps(std::size_t bytes, int none_done, const Step& step) noexcept {
    for (std::size_t done = 0; done < bytes;) {
        DWORD more = 0;
        if (step(done, static_cast<DWORD>(std::min(bytes - done, largest_step)), &more) == 0) {
            return ::GetLastError() == ERROR_HANDLE_EOF ? none_done : last_error();
        }
        if (more == 0) {
            return none_done;
        }
        done += more;
    }
    return 0;
}

int read_status(HANDLE file, FileStatus& status) noexcept {
    BY_HANDLE_FILE_INFORMATION found{};
    const DWORD type = ::GetFileType(file);
    if (type != FILE_TYPE_DISK) {
        status = {type == FILE_TYPE_PIPE ? FileKind::fifo : FileKind::device, 0, 0, 0};
        return 0;
    }
    if (::GetFileInformationByHandle(file, &found) == 0) {
        return last_error();
    }
    const auto joined = [](DWORD high, DWORD low) { return std::uint64_t{high} << 32 | low; };
    status = {(found.dwFileAttributes & FILE_ATTRIBUTE_DIRECTORY) != 0 ? FileKind::folder : FileKind::regular, 0,
              joined(found.nFileSizeHigh, found.nFileSizeLow),
              joined(found.ftLastWriteTime.dwHighDateTime, found.ftLastWriteTime.dwLowDateTime)};
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

int File::open_to_read(const std::filesystem::path& path) noexcept {
    return open(path, GENERIC_READ, share_all, OPEN_EXISTING, FILE_FLAG_BACKUP_SEMANTICS, handle_);  // folders too
}

int File::open_to_write(const std::filesystem::path& path) noexcept {
    return open(path, GENERIC_WRITE, share_all, OPEN_EXISTING, FILE_ATTRIBUTE_NORMAL, handle_);
}

int File::create(const std::filesystem::path& path) noexcept {
    return open(path, GENERIC_WRITE, share_all, CREATE_NEW, FILE_ATTRIBUTE_NORMAL, handle_);
}

int File::create_unique(const std::filesystem::path& folder, std::string_view prefix, std::filesystem::path& made) {
    return make_unique(folder, prefix, made, [&](const std::filesystem::path& name) {
        return open(name, GENERIC_READ | GENERIC_WRITE, share_all, CREATE_NEW, FILE_ATTRIBUTE_TEMPORARY, handle_);
    });
}

int File::create_scratch(const std::filesystem::path& folder) {
    constexpr DWORD flags = FILE_ATTRIBUTE_TEMPORARY | FILE_FLAG_DELETE_ON_CLOSE;
    std::filesystem::path made;
    return make_unique(folder, ".lamella", made, [&](const std::filesystem::path& name) {
        return open(name, GENERIC_READ | GENERIC_WRITE, share_all, CREATE_NEW, flags, handle_);
    });
}

int File::duplicate(int number) noexcept {
    constexpr DWORD standard[] = {STD_INPUT_HANDLE, STD_OUTPUT_HANDLE, STD_ERROR_HANDLE};
    if (number < 0 || number > 2) {
        return EBADF;
    }
    const HANDLE process = ::GetCurrentProcess();
    HANDLE copy = INVALID_HANDLE_VALUE;
    if (::DuplicateHandle(process, ::GetStdHandle(standard[number]), process, &copy, 0, FALSE, DUPLICATE_SAME_ACCESS) == 0) {
        return last_error();
    }
    handle_ = reinterpret_cast<std::intptr_t>(copy);
    return 0;
}

int File::status(FileStatus& status) const noexcept {
    return read_status(as_handle(handle_), status);
}

int File::set_mode(unsigned /*mode*/) noexcept {
    return 0;  // a new file gets what its folder says
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
    return is_open() ? error_where(::CloseHandle(as_handle(std::exchange(handle_, none))) == 0) : 0;
}

int status_of(const std::filesystem::path& path, FileStatus& status) noexcept {
    std::intptr_t handle = -1;
    if (const int missing = open(path, 0, share_all, OPEN_EXISTING, FILE_FLAG_BACKUP_SEMANTICS, handle); missing != 0) {
        return missing;
    }
    const int failure = read_status(as_handle(handle), status);
    ::CloseHandle(as_handle(handle));
    return failure;
}

int check_writable(const std::filesystem::path& path) noexcept {
    return with_long_path(path, [](const wchar_t* name) {
        const DWORD attributes = ::GetFileAttributesW(name);
        const bool is_there = attributes != INVALID_FILE_ATTRIBUTES;
        return is_there && (attributes & FILE_ATTRIBUTE_READONLY) != 0 ? EACCES : error_where(!is_there);
    });
}

int replace_file(const std::filesystem::path& from, const std::filesystem::path& to) noexcept {
    return with_long_path(from, [&](const wchar_t* old_name) {
        return with_long_path(to, [&](const wchar_t* new_name) {
            return error_where(::MoveFileExW(old_name, new_name, MOVEFILE_REPLACE_EXISTING) == 0);
        });
    });
}

int remove_file(const std::filesystem::path& path) noexcept {
    return with_long_path(path, [](const wchar_t* name) { return error_where(::DeleteFileW(name) == 0); });
}

int create_unique_folder(const std::filesystem::path& folder, std::string_view prefix, std::filesystem::path& made) {
    return make_unique(folder, prefix, made, [](const std::filesystem::path& folder_name) {
        return with_long_path(folder_name,
                              [](const wchar_t* name) { return error_where(::CreateDirectoryW(name, nullptr) == 0); });
    });
}

}  // namespace lamella
