#include "io/read/input_file.hpp"

#include <cassert>

#include "io/text/text.hpp"

namespace lamella {

namespace {

/// Large enough to hide the system call, small enough to share out; a multiple of the huge page that it fills.
constexpr std::size_t read_piece_bytes = std::size_t{8} << 20;

const char* name_of(std::filesystem::file_type type) {
    using Type = std::filesystem::file_type;
    return type == Type::directory ? "a directory"
           : type == Type::fifo    ? "a FIFO"
           : type == Type::socket  ? "a socket"
                                   : "a device";
}

}  // namespace

bool has_extension(PathView path, std::string_view extension) noexcept {
    constexpr std::filesystem::path::value_type separators[] = {'/', std::filesystem::path::preferred_separator, 0};
    const std::size_t name = path.find_last_of(separators) + 1;  // 0 where there is none
    const std::size_t point = path.rfind('.');
    return point != PathView::npos && point > name && path.size() - point == extension.size() &&
           std::equal(
               extension.begin(), extension.end(), path.begin() + static_cast<std::ptrdiff_t>(point),
               [](char wanted, auto c) { return c == wanted || (c < 'a' && lower_case(static_cast<char>(c)) == wanted); });
}

Error InputFile::error(ErrorCode code, const std::string& what, std::int64_t byte_offset) const {
    return {.code = code, .message = name_ + ": " + what, .byte_offset = byte_offset};
}

Result<InputFile> InputFile::open(const std::filesystem::path& path, std::string_view name) {
    InputFile opened(printable(name.empty() ? path_text(path) : name));
    opened.folder_ = path.parent_path();
    int failure = opened.file_.open_to_read(path);
    failure = failure == 0 ? opened.file_.status(opened.opened_) : failure;
    if (failure != 0) {
        return opened.error(ErrorCode::unreadable_file, "cannot be opened: " + system_message(failure));
    }
    if (const auto type = opened.opened_.type; type != std::filesystem::file_type::regular) {
        return opened.error(ErrorCode::unreadable_file, std::string("is ") + name_of(type) + ", not a file");
    }
    return opened;
}

Status InputFile::read(std::span<std::byte> into, const Parallel& parallel) const {
    assert(into.size() <= size());
    std::vector<Status> pieces((into.size() + read_piece_bytes - 1) / read_piece_bytes);
    parallel.run(pieces.size(), [&](std::size_t piece, int) {
        const std::size_t offset = piece * read_piece_bytes;
        pieces[piece] = read_at(offset, into.subspan(offset, std::min(read_piece_bytes, into.size() - offset)));
    });
    const auto failed = std::find_if(pieces.begin(), pieces.end(), [](const Status& piece) { return !piece; });
    return failed == pieces.end() ? Status() : *failed;
}

Status InputFile::read_at(std::uint64_t offset, std::span<std::byte> into) const {
    const int failure = file_.read_at(into, offset);
    if (failure == File::ended) {
        return error(ErrorCode::unreadable_file, "shrank while it was read");
    }
    return failure == 0 ? Status()
                        : error(ErrorCode::unreadable_file,
                                "cannot be read near byte " + std::to_string(offset) + ": " + system_message(failure),
                                static_cast<std::int64_t>(offset));
}

Result<Array<std::byte>> InputFile::map(std::size_t count) const {
    assert(count > 0 && count <= size());
    Array<std::byte> bytes;
    if (const int failure = file_.map(count, bytes); failure != 0) {
        return error(ErrorCode::unreadable_file, "cannot be mapped: " + system_message(failure));
    }
    return bytes;
}

Status InputFile::unchanged() const {
    FileStatus now;
    if (const int failure = file_.status(now); failure != 0) {
        return error(ErrorCode::unreadable_file, "cannot be examined: " + system_message(failure));
    }
    if (now.size != opened_.size || now.changed != opened_.changed) {
        return error(ErrorCode::unreadable_file, "changed while it was read");
    }
    return {};
}

}  // namespace lamella
