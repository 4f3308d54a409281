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

int status_of(HANDLE handle, FileStatus& status) noexcept {
    using Type = std::filesystem::file_type;
    const DWORD type = ::GetFileType(handle);
    if (type != FILE_TYPE_DISK) {
        status = {.type = type == FILE_TYPE_PIPE ? Type::fifo : Type::character};
        return 0;
    }
    BY_HANDLE_FILE_INFORMATION found{};
    if (::GetFileInformationByHandle(handle, &found) == 0) {
        return last_error();
    }
    constexpr std::uint64_t from_1601_to_1970 = 116'444'736'000'000'000;  // in the system's units of 100 ns
    const auto joined = [](DWORD high, DWORD low) { return std::uint64_t{high} << 32 | low; };
    const std::uint64_t changed = joined(found.ftLastWriteTime.dwHighDateTime, found.ftLastWriteTime.dwLowDateTime);
    status = {(found.dwFileAttributes & FILE_ATTRIBUTE_DIRECTORY) != 0 ? Type::directory : Type::regular,
              joined(found.nFileSizeHigh, found.nFileSizeLow), (changed - from_1601_to_1970) * 100,
              found.dwVolumeSerialNumber, joined(found.nFileIndexHigh, found.nFileIndexLow)};
    return 0;
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

bool can_list(const std::filesystem::path& folder) {
    return system_path(folder).native().size() < MAX_PATH - 4;  // with the mark of a long one, or "\\*"
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

int File::open_or_create(const std::filesystem::path& path, unsigned /*mode*/) {
    return open(path, GENERIC_READ | GENERIC_WRITE, OPEN_ALWAYS, FILE_ATTRIBUTE_NORMAL, handle_);
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

int status_of(const std::filesystem::path& path, FileStatus& status) {
    std::intptr_t handle = 0;
    if (const int failure = open(path, FILE_READ_ATTRIBUTES, OPEN_EXISTING, FILE_FLAG_BACKUP_SEMANTICS, handle);
        failure != 0) {
        return failure;
    }
    const int failure = status_of(as_handle(handle), status);
    ::CloseHandle(as_handle(handle));
    return failure;
}

int File::status(FileStatus& status) const noexcept {
    return status_of(as_handle(handle_), status);
}

std::filesystem::path File::path() const {
    std::wstring name(std::size_t{1} << 15, 0);
    name.resize(::GetFinalPathNameByHandleW(as_handle(handle_), name.data(), static_cast<DWORD>(name.size()), 0));
    return name;
}

int File::read(std::span<std::byte> into, std::size_t& count) noexcept {
    DWORD got = 0;
    const bool failed = ::ReadFile(as_handle(handle_), into.data(), static_cast<DWORD>(into.size()), &got, nullptr) == 0;
    count = got;
    return failed && ::GetLastError() != ERROR_BROKEN_PIPE && ::GetLastError() != ERROR_HANDLE_EOF ? last_error() : 0;
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

int File::truncate(std::uint64_t bytes) noexcept {
    LARGE_INTEGER at{};
    at.QuadPart = static_cast<LONGLONG>(bytes);
    const HANDLE file = as_handle(handle_);
    return ::SetFilePointerEx(file, at, nullptr, FILE_BEGIN) != 0 && ::SetEndOfFile(file) != 0 ? 0 : last_error();
}

int File::sync() noexcept {
    return ::FlushFileBuffers(as_handle(handle_)) != 0 ? 0 : last_error();
}

int File::lock() noexcept {
    OVERLAPPED beyond = place(std::uint64_t{1} << 62);  // Nobody can read or write a byte that another process has locked.
    constexpr DWORD flags = LOCKFILE_EXCLUSIVE_LOCK | LOCKFILE_FAIL_IMMEDIATELY;
    const bool locked = ::LockFileEx(as_handle(handle_), flags, 0, 1, 0, &beyond) != 0;
    return locked ? 0 : ::GetLastError() == ERROR_LOCK_VIOLATION ? EWOULDBLOCK : last_error();
}

int File::close() noexcept {
    return is_open() && ::CloseHandle(as_handle(std::exchange(handle_, none))) == 0 ? last_error() : 0;
}

int File::map(std::size_t /*bytes*/, Array<std::byte>& /*into*/) const {
    return ENOTSUP;
}

int check_writable(const std::filesystem::path& path) {
    const DWORD attributes = ::GetFileAttributesW(system_path(path).c_str());
    constexpr DWORD kinds = FILE_ATTRIBUTE_READONLY | FILE_ATTRIBUTE_DIRECTORY;  // A folder's flag means something else.
    return attributes == INVALID_FILE_ATTRIBUTES             ? last_error()
           : (attributes & kinds) == FILE_ATTRIBUTE_READONLY ? EACCES
                                                             : 0;
}

std::FILE* open_stream(const std::filesystem::path& path) {
    return ::_wfopen(system_path(path).c_str(), L"rb");
}

}  // namespace lamella
