#include "io/read/three_mf/zip_archive.hpp"

#include <unzip.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <new>
#include <utility>

namespace lamella {

namespace {

constexpr std::size_t inflated_bytes = std::size_t{256} << 10;
constexpr std::size_t longest_name = 0xFFFF;
constexpr unsigned encrypted_flag = 1;

std::string lower_case(std::string_view name) {
    std::string lower(name);
    std::transform(lower.begin(), lower.end(), lower.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + ('a' - 'A')) : c; });
    return lower;
}

template <class Value>
std::uint64_t number_at(std::string_view file, std::size_t at) {
    Value number = 0;
    std::memcpy(&number, file.data() + at, sizeof number);
    return number;
}

/// Bytes before an archive whose directory's end record is at `end`, found by an offset that the archive states.
///
///     ... | directory | [record of zip64 (56) | where that is (20)] | end record
std::uint64_t bytes_before_archive(std::string_view file, std::size_t end) {
    constexpr std::size_t record_bytes = 56;
    constexpr std::size_t locator_bytes = 20;
    if (end >= record_bytes + locator_bytes && file.substr(end - locator_bytes).starts_with("PK\x06\x07")) {
        const std::size_t record = end - locator_bytes - record_bytes;
        const std::uint64_t stated = number_at<std::uint64_t>(file, end - locator_bytes + 8);
        return file.substr(record).starts_with("PK\x06\x06") && stated <= record ? record - stated : 0;
    }
    const std::uint64_t stated = number_at<std::uint32_t>(file, end + 12) + number_at<std::uint32_t>(file, end + 16);
    return stated <= end ? end - stated : 0;
}

}  // namespace

OtherBytes other_bytes(std::string_view file) {
    constexpr std::size_t end_record_bytes = 22;
    const std::size_t end = file.rfind("PK\x05\x06");  // as minizip finds it
    if (end == std::string_view::npos || file.size() - end < end_record_bytes) {
        return {};
    }
    const std::uint64_t archive_end = end + end_record_bytes + number_at<std::uint16_t>(file, end + 20);
    return {bytes_before_archive(file, end), file.size() - std::min<std::uint64_t>(archive_end, file.size())};
}

Error error_in_part(const FileSource& file, ErrorCode code, std::string_view part, std::uint64_t line,
                    const std::string& what) {
    const std::string place = "part '" + printable(std::string(part)) + "'";
    return file.error(code, line == 0 ? place + " " + what : place + ", line " + std::to_string(line) + ": " + what);
}

/// The archive's bytes as a file for minizip, and what minizip keeps of it.
struct ZipArchive::Stream {
    std::span<const std::byte> bytes;
    std::uint64_t at = 0;
    bool fell_short = false;  // the last read: without this, minizip takes bytes beyond the end for zeros
    unzFile zip = nullptr;
    std::array<char, inflated_bytes> piece;

    explicit Stream(std::span<const std::byte> archive) : bytes(archive) {}
    ~Stream() {
        if (zip != nullptr) {
            unzClose(zip);
        }
    }
    Stream(const Stream&) = delete;
    Stream& operator=(const Stream&) = delete;

    bool open() {
        zlib_filefunc64_def functions{open_file, read_bytes, write_bytes, tell, seek, close_file, has_failed, this};
        zip = unzOpen2_64("", &functions);
        return zip != nullptr;
    }

private:
    static Stream& of(void* stream) noexcept { return *static_cast<Stream*>(stream); }
    static void* open_file(void* self, const void*, int) noexcept { return self; }
    static uLong write_bytes(void*, void*, const void*, uLong) noexcept { return 0; }
    static ZPOS64_T tell(void*, void* stream) noexcept { return of(stream).at; }
    static int close_file(void*, void*) noexcept { return 0; }
    static int has_failed(void*, void* stream) noexcept { return of(stream).fell_short ? 1 : 0; }

    static uLong read_bytes(void*, void* stream, void* to, uLong count) noexcept {
        Stream& self = of(stream);
        const std::size_t got = std::min<std::size_t>(count, self.bytes.size() - self.at);
        std::memcpy(to, self.bytes.data() + self.at, got);
        self.at += got;
        self.fell_short = got < count;
        return static_cast<uLong>(got);
    }

    static long seek(void*, void* stream, ZPOS64_T offset, int origin) noexcept {
        Stream& self = of(stream);
        const std::uint64_t size = self.bytes.size();
        const std::uint64_t base =
            origin == ZLIB_FILEFUNC_SEEK_CUR ? self.at : (origin == ZLIB_FILEFUNC_SEEK_END ? size : 0);
        if (offset > size - base) {
            return -1;
        }
        self.at = base + offset;
        return 0;
    }
};

void ZipArchive::StreamDeleter::operator()(Stream* stream) const noexcept {
    delete stream;
}

Result<ZipArchive> ZipArchive::open(const FileSource& file, std::span<const std::byte> bytes, std::uint64_t limit_bytes) {
    ZipArchive archive(file, limit_bytes);
    archive.stream_.reset(new Stream(bytes));
    if (!archive.stream_->open()) {
        return file.error(ErrorCode::malformed_mesh, "is truncated or no zip archive: it does not end with a zip directory");
    }
    if (Status listed = archive.list_parts(); !listed) {
        return listed.error();
    }
    return archive;
}

Status ZipArchive::list_parts() {
    const unzFile zip = stream_->zip;
    unz_global_info64 archive{};
    if (unzGetGlobalInfo64(zip, &archive) == UNZ_OK && archive.number_entry == 0) {
        return file_->error(ErrorCode::malformed_mesh, "is a zip archive without any part");
    }
    std::string name(longest_name + 1, '\0');
    int answer = unzGoToFirstFile(zip);
    for (; answer == UNZ_OK; answer = unzGoToNextFile(zip)) {
        unz_file_info64 part{};
        unz64_file_pos position{};
        answer = unzGetCurrentFileInfo64(zip, &part, name.data(), static_cast<uLong>(name.size()), nullptr, 0, nullptr, 0);
        if (answer == UNZ_OK) {
            answer = unzGetFilePos64(zip, &position);
        }
        if (answer != UNZ_OK) {
            break;
        }
        entries_.push_back(
            {lower_case({name.data(), part.size_filename}), position.pos_in_zip_directory, position.num_of_file});
    }
    if (answer != UNZ_END_OF_LIST_OF_FILE) {
        return file_->error(ErrorCode::malformed_mesh, "is damaged: its zip directory breaks off after " +
                                                           std::to_string(entries_.size()) + " of " +
                                                           std::to_string(archive.number_entry) + " parts");
    }
    std::sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) { return a.key < b.key; });
    const auto twice =
        std::adjacent_find(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) { return a.key == b.key; });
    return twice == entries_.end() ? Status() : error(ErrorCode::malformed_mesh, twice->key, 0, "is there twice");
}

const ZipArchive::Entry* ZipArchive::find(std::string_view part) const {
    const std::string key = lower_case(part);
    const auto found = std::lower_bound(entries_.begin(), entries_.end(), key,
                                        [](const Entry& entry, const std::string& name) { return entry.key < name; });
    return found != entries_.end() && found->key == key ? &*found : nullptr;
}

Status ZipArchive::read(std::string_view part, FunctionRef<bool(std::string_view piece)> take) {
    std::uint64_t stated_bytes = 0;
    if (Status opened = open_part(part, stated_bytes); !opened) {
        return opened;
    }
    std::uint64_t bytes = 0;
    bool wanted = true;
    for (;;) {
        std::array<char, inflated_bytes>& piece = stream_->piece;
        const int got = unzReadCurrentFile(stream_->zip, piece.data(), static_cast<unsigned>(piece.size()));
        if (got < 0) {
            unzCloseCurrentFile(stream_->zip);
            return error(ErrorCode::malformed_mesh, part, 0, "is damaged: no valid deflate data");
        }
        if (got == 0) {
            break;
        }
        const auto count = static_cast<std::size_t>(got);
        bytes += count;
        expanded_bytes_ += count;
        if (expanded_bytes_ > limit_bytes_) {
            unzCloseCurrentFile(stream_->zip);
            return error(ErrorCode::out_of_memory, part, 0,
                         "expands to more than the " + std::to_string(limit_bytes_) + " bytes that all parts together may");
        }
        wanted = wanted && take({piece.data(), count});
    }
    if (bytes != stated_bytes) {
        unzCloseCurrentFile(stream_->zip);
        return error(ErrorCode::malformed_mesh, part, 0,
                     "is damaged: " + std::to_string(bytes) + " bytes, of which the zip " + "directory says that they are " +
                         std::to_string(stated_bytes));
    }
    return close_part(part);
}

Status ZipArchive::open_part(std::string_view part, std::uint64_t& bytes) {
    const Entry* const entry = find(part);
    if (entry == nullptr) {
        return error(ErrorCode::malformed_mesh, part, 0, "is missing");
    }
    const unz64_file_pos position{entry->directory_offset, entry->index};
    unz_file_info64 info{};
    if (unzGoToFilePos64(stream_->zip, &position) != UNZ_OK ||
        unzGetCurrentFileInfo64(stream_->zip, &info, nullptr, 0, nullptr, 0, nullptr, 0) != UNZ_OK) {
        return error(ErrorCode::malformed_mesh, part, 0, "is damaged: its entry in the zip directory");
    }
    if ((info.flag & encrypted_flag) != 0) {
        return error(ErrorCode::malformed_mesh, part, 0, "is encrypted");
    }
    if (info.compression_method != 0 && info.compression_method != Z_DEFLATED) {
        return error(ErrorCode::malformed_mesh, part, 0,
                     "is compressed by method " + std::to_string(info.compression_method) + ", which is not deflate");
    }
    const int answer = unzOpenCurrentFile(stream_->zip);
    if (answer == UNZ_INTERNALERROR) {
        throw std::bad_alloc();
    }
    if (answer != UNZ_OK) {
        return error(ErrorCode::malformed_mesh, part, 0, "is damaged: its header in the zip archive");
    }
    bytes = info.uncompressed_size;
    return {};
}

Status ZipArchive::close_part(std::string_view part) {
    if (unzCloseCurrentFile(stream_->zip) != UNZ_OK) {
        return error(ErrorCode::malformed_mesh, part, 0, "is damaged: its checksum differs");
    }
    return {};
}

}  // namespace lamella
