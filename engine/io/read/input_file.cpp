#include "io/read/input_file.hpp"

#include <cassert>
#include <cerrno>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "io/text/text.hpp"

namespace lamella {

namespace {

/// Large enough to hide the system call, small enough to share out; a multiple of the huge page that it fills.
constexpr std::size_t read_piece_bytes = std::size_t{8} << 20;
constexpr int file_ended = -1;

std::string system_message(int number) {
    return std::generic_category().message(number);
}

const char* kind_of(mode_t mode) {
    return S_ISDIR(mode) ? "a directory" : S_ISFIFO(mode) ? "a FIFO" : S_ISSOCK(mode) ? "a socket" : "a device";
}

/// Lets an Array own a mapping: it takes address space, over which the file is then mapped. Pages are aligned enough.
constexpr Memory mapped_memory = {
    {nullptr,
     [](void*, std::size_t bytes, std::size_t) noexcept -> void* {
         void* const memory = ::mmap(nullptr, bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
         return memory == MAP_FAILED ? nullptr : memory;
     }},
    {nullptr, [](void*, void* memory, std::size_t bytes, std::size_t) noexcept { ::munmap(memory, bytes); }}};

}  // namespace

bool has_extension(std::string_view path, std::string_view extension) noexcept {
    const std::size_t name = path.rfind('/') + 1;  // 0 where there is no slash
    const std::size_t point = path.rfind('.');
    return point != std::string_view::npos && point > name && path.size() - point == extension.size() &&
           begins_in_any_case(path.substr(point), extension);
}

int read_fully(int descriptor, std::span<std::byte> into, std::uint64_t offset) {
    while (!into.empty()) {
        const ssize_t got = ::pread(descriptor, into.data(), into.size(), static_cast<off_t>(offset));
        if (got < 0 && errno == EINTR) {
            continue;
        }
        if (got <= 0) {
            return got < 0 ? errno : file_ended;
        }
        into = into.subspan(static_cast<std::size_t>(got));
        offset += static_cast<std::uint64_t>(got);
    }
    return 0;
}

InputFile::InputFile(InputFile&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      name_(std::move(other.name_)),
      size_(other.size_),
      changed_s_(other.changed_s_),
      changed_ns_(other.changed_ns_) {}

InputFile::~InputFile() {
    if (descriptor_ >= 0) {
        ::close(descriptor_);
    }
}

Error InputFile::error(ErrorCode code, const std::string& what, std::int64_t byte_offset) const {
    return {.code = code, .message = name_ + ": " + what, .byte_offset = byte_offset};
}

Result<InputFile> InputFile::open(const std::filesystem::path& path, std::string_view name) {
    InputFile file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY),
                   printable(name.empty() ? std::string_view(path.native()) : name));
    struct stat status {};
    if (file.descriptor_ < 0 || ::fstat(file.descriptor_, &status) != 0) {
        return file.error(ErrorCode::unreadable_file, "cannot be opened: " + system_message(errno));
    }
    if (!S_ISREG(status.st_mode)) {
        return file.error(ErrorCode::unreadable_file, std::string("is ") + kind_of(status.st_mode) + ", not a file");
    }
    file.size_ = static_cast<std::uint64_t>(status.st_size);
    file.changed_s_ = status.st_mtim.tv_sec;
    file.changed_ns_ = status.st_mtim.tv_nsec;
    return file;
}

Status InputFile::read(std::span<std::byte> into, const Parallel& parallel) const {
    assert(into.size() <= size_);
    std::vector<Status> pieces((into.size() + read_piece_bytes - 1) / read_piece_bytes);
    parallel.run(pieces.size(), [&](std::size_t piece, int) {
        const std::size_t offset = piece * read_piece_bytes;
        pieces[piece] = read_at(offset, into.subspan(offset, std::min(read_piece_bytes, into.size() - offset)));
    });
    const auto failed = std::find_if(pieces.begin(), pieces.end(), [](const Status& piece) { return !piece; });
    return failed == pieces.end() ? Status() : *failed;
}

Status InputFile::read_at(std::uint64_t offset, std::span<std::byte> into) const {
    const int failure = read_fully(descriptor_, into, offset);
    if (failure == file_ended) {
        return error(ErrorCode::unreadable_file, "shrank while it was read");
    }
    return failure == 0 ? Status()
                        : error(ErrorCode::unreadable_file,
                                "cannot be read near byte " + std::to_string(offset) + ": " + system_message(failure),
                                static_cast<std::int64_t>(offset));
}

Result<Array<std::byte>> InputFile::map(std::size_t count) const {
    assert(count > 0 && count <= size_);
    Array<std::byte> bytes(&mapped_memory);
    bytes.resize_discarding(count);
    if (::mmap(bytes.data(), count, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_FIXED, descriptor_, 0) == MAP_FAILED) {
        return error(ErrorCode::unreadable_file, "cannot be mapped: " + system_message(errno));
    }
    (void)::madvise(bytes.data(), count, MADV_WILLNEED);  // advice only
    return bytes;
}

Status InputFile::unchanged() const {
    struct stat status {};
    if (::fstat(descriptor_, &status) != 0) {
        return error(ErrorCode::unreadable_file, "cannot be examined: " + system_message(errno));
    }
    if (static_cast<std::uint64_t>(status.st_size) != size_ || status.st_mtim.tv_sec != changed_s_ ||
        status.st_mtim.tv_nsec != changed_ns_) {
        return error(ErrorCode::unreadable_file, "changed while it was read");
    }
    return {};
}

}  // namespace lamella
