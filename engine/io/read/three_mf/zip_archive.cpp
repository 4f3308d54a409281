#include "io/read/three_mf/zip_archive.hpp"

#include <zip.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <new>
#include <optional>
#include <utility>

#include "io/text/text.hpp"

namespace lamella {

namespace {

constexpr std::size_t inflated_bytes = std::size_t{256} << 10;
constexpr std::uint64_t end_record_bytes = 22;
constexpr std::uint64_t longest_comment = 0xFFFF;

/// About ten thousand parts. libzip puts their names into a hash table, which takes the square of their number where names
/// were chosen to collide: half a second for a directory of this size.
constexpr std::uint64_t most_directory_bytes = std::uint64_t{1} << 20;

template <class Value>
std::uint64_t number_at(std::string_view file, std::uint64_t at) {
    Value number = 0;
    std::memcpy(&number, file.data() + at, sizeof number);
    return number;
}

/// Where in a file an archive is, and how long it says that its directory is.
///
///     ... | parts | directory | [ZIP64 record (56 or more) | where that is (20)] | end record (22) | comment | ...
///         begin                                                                  end_record                 end
struct ArchivePlace {
    std::uint64_t begin = 0;
    std::uint64_t end_record = 0;
    std::uint64_t end = 0;
    std::uint64_t directory_bytes = 0;
};

/// With ZIP64: by what precedes the end record.
ArchivePlace locate_zip64(std::string_view file, ArchivePlace place, std::uint64_t locator) {
    constexpr std::uint64_t record_bytes = 56;
    constexpr std::string_view record_magic = "PK\x06\x06";
    const std::uint64_t stated = number_at<std::uint64_t>(file, locator + 8);
    const std::uint64_t adjacent = locator < record_bytes ? 0 : locator - record_bytes;
    const std::uint64_t record = file.substr(adjacent).starts_with(record_magic) ? adjacent : stated;
    if (record > locator || locator - record < record_bytes || !file.substr(record).starts_with(record_magic)) {
        return place;  // libzip will say so
    }
    place.begin = stated <= record ? record - stated : 0;
    place.directory_bytes = number_at<std::uint64_t>(file, record + 40);
    return place;
}

std::optional<ArchivePlace> locate_archive(std::string_view file) {
    constexpr std::uint64_t locator_bytes = 20;
    const std::size_t end = file.rfind("PK\x05\x06");
    if (end == std::string_view::npos || file.size() - end < end_record_bytes) {
        return std::nullopt;
    }
    ArchivePlace place;
    place.end_record = end;
    place.end = std::min<std::uint64_t>(end + end_record_bytes + number_at<std::uint16_t>(file, end + 20), file.size());
    place.directory_bytes = number_at<std::uint32_t>(file, end + 12);
    if (end >= locator_bytes && file.substr(end - locator_bytes).starts_with("PK\x06\x07")) {
        return locate_zip64(file, place, end - locator_bytes);
    }
    const std::uint64_t stated = place.directory_bytes + number_at<std::uint32_t>(file, end + 16);
    place.begin = stated <= end ? end - stated : 0;
    return place;
}

/// Percent escapes resolved, in lower case.
std::string key_of(std::string_view name) {
    std::string key;
    for (std::size_t at = 0; at < name.size(); ++at) {
        unsigned char byte = 0;
        const char* const end = name.data() + std::min(at + 3, name.size());
        const bool escaped =
            name[at] == '%' && std::from_chars(name.data() + at + 1, end, byte, 16).ptr == name.data() + at + 3;
        key += lower_case(escaped ? static_cast<char>(byte) : name[at]);
        at += escaped ? 2 : 0;
    }
    return key;
}

void throw_without_memory(const zip_error_t* error) {
    if (zip_error_code_zip(error) == ZIP_ER_MEMORY) {
        throw std::bad_alloc();
    }
}

}  // namespace

OtherBytes other_bytes(std::string_view file) {
    const std::optional<ArchivePlace> place = locate_archive(file);
    return place ? OtherBytes{place->begin, file.size() - place->end} : OtherBytes{};
}

Error error_in_part(const FileSource& file, ErrorCode code, std::string_view part, std::uint64_t line,
                    const std::string& what) {
    const std::string place = "part '" + printable(part) + "'";
    return file.error(code, line == 0 ? place + " " + what : place + ", line " + std::to_string(line) + ": " + what);
}

/// The archive's bytes as a file for libzip, and what libzip keeps of it.
///
/// libzip tries every end record in the last 64 KiB and reads a directory for each. So that there is one, what follows the
/// end record is shown as zeros, as many as the longest comment has bytes:
///
///     parts | directory | end record, comment length 0 | 0 0 0 0 ...
///                         the last 64 KiB begin here (with ZIP64: at the locator before it)
struct ZipArchive::Stream {
    std::string_view bytes;  // up to the comment's length, which is shown as 0
    std::uint64_t shown_bytes;
    std::uint64_t at = 0;
    zip_error_t error{};
    zip_t* zip = nullptr;
    zip_file_t* part = nullptr;
    std::array<char, inflated_bytes> piece;

    Stream(std::string_view file, const ArchivePlace& place)
        : bytes(file.substr(place.begin, place.end_record + end_record_bytes - 2 - place.begin)),
          shown_bytes(bytes.size() + 2 + longest_comment) {
        zip_error_init(&error);
    }
    ~Stream() {
        close_part();
        if (zip != nullptr) {
            zip_discard(zip);
        }
        zip_error_fini(&error);
    }
    Stream(const Stream&) = delete;
    Stream& operator=(const Stream&) = delete;

    /// A code of libzip, ZIP_ER_OK where the archive is open.
    int open() {
        zip_source_t* const source = zip_source_function_create(answer, this, &error);
        zip = source != nullptr ? zip_open_from_source(source, ZIP_RDONLY, &error) : nullptr;
        if (zip == nullptr) {
            throw_without_memory(&error);
            const int code = zip_error_code_zip(&error);
            zip_source_free(source);
            return code;
        }
        return ZIP_ER_OK;
    }

    void close_part() {
        if (part != nullptr) {
            zip_fclose(std::exchange(part, nullptr));
        }
    }

private:
    static zip_int64_t answer(void* self, void* data, zip_uint64_t length, zip_source_cmd_t command) noexcept {
        Stream& stream = *static_cast<Stream*>(self);
        switch (command) {
            case ZIP_SOURCE_OPEN:
                stream.at = 0;
                return 0;
            case ZIP_SOURCE_CLOSE:
            case ZIP_SOURCE_FREE:
                return 0;
            case ZIP_SOURCE_READ:
                return stream.read(static_cast<char*>(data), length);
            case ZIP_SOURCE_SEEK:
                return stream.seek(data, length);
            case ZIP_SOURCE_TELL:
                return static_cast<zip_int64_t>(stream.at);
            case ZIP_SOURCE_STAT:
                return stream.state_size(static_cast<zip_stat_t*>(data));
            case ZIP_SOURCE_ERROR:
                return zip_error_to_data(&stream.error, data, length);
            case ZIP_SOURCE_SUPPORTS:
                return zip_source_make_command_bitmap(ZIP_SOURCE_OPEN, ZIP_SOURCE_READ, ZIP_SOURCE_CLOSE, ZIP_SOURCE_STAT,
                                                      ZIP_SOURCE_ERROR, ZIP_SOURCE_FREE, ZIP_SOURCE_SEEK, ZIP_SOURCE_TELL,
                                                      ZIP_SOURCE_SUPPORTS, -1);
            default:
                zip_error_set(&stream.error, ZIP_ER_OPNOTSUPP, 0);
                return -1;
        }
    }

    zip_int64_t read(char* to, std::uint64_t count) noexcept {
        const std::uint64_t got = std::min(count, shown_bytes - at);
        const std::uint64_t real = std::min(got, bytes.size() - std::min<std::uint64_t>(at, bytes.size()));
        if (real > 0) {
            std::memcpy(to, bytes.data() + at, real);
        }
        std::memset(to + real, 0, got - real);
        at += got;
        return static_cast<zip_int64_t>(got);
    }

    zip_int64_t seek(void* arguments, std::uint64_t length) noexcept {
        const zip_int64_t to = zip_source_seek_compute_offset(at, shown_bytes, arguments, length, &error);
        at = to < 0 ? at : static_cast<std::uint64_t>(to);
        return to < 0 ? -1 : 0;
    }

    zip_int64_t state_size(zip_stat_t* stat) const noexcept {
        zip_stat_init(stat);
        stat->size = shown_bytes;
        stat->valid = ZIP_STAT_SIZE;
        return sizeof *stat;
    }
};

void ZipArchive::StreamDeleter::operator()(Stream* stream) const noexcept {
    delete stream;
}

Result<ZipArchive> ZipArchive::open(const FileSource& file, std::span<const std::byte> bytes, std::uint64_t limit_bytes) {
    const std::optional<ArchivePlace> place = locate_archive(as_text(bytes));
    if (!place) {
        return file.error(ErrorCode::malformed_mesh, "is truncated or no zip archive: it does not end with a zip directory");
    }
    if (place->directory_bytes > most_directory_bytes) {
        return file.error(ErrorCode::malformed_mesh, "has a zip directory of " + std::to_string(place->directory_bytes) +
                                                         " bytes, more than the " + std::to_string(most_directory_bytes) +
                                                         " that are read");
    }
    ZipArchive archive(file, limit_bytes);
    archive.stream_.reset(new Stream(as_text(bytes), *place));
    if (const int code = archive.stream_->open(); code != ZIP_ER_OK) {
        return file.error(ErrorCode::malformed_mesh, code == ZIP_ER_MULTIDISK
                                                         ? "is one of several volumes of a zip archive"
                                                         : "is damaged: its zip directory, which the end record at byte " +
                                                               std::to_string(place->end_record) + " describes");
    }
    if (Status listed = archive.list_parts(); !listed) {
        return listed.error();
    }
    return archive;
}

Status ZipArchive::list_parts() {
    const auto count = static_cast<std::uint64_t>(std::max<zip_int64_t>(0, zip_get_num_entries(stream_->zip, 0)));
    if (count == 0) {
        return file_->error(ErrorCode::malformed_mesh, "is a zip archive without any part");
    }
    for (std::uint64_t index = 0; index < count; ++index) {
        const char* const name = zip_get_name(stream_->zip, index, ZIP_FL_ENC_RAW);
        entries_.push_back({key_of(name != nullptr ? name : ""), index});
    }
    std::sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) { return a.key < b.key; });
    const auto twice =
        std::adjacent_find(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) { return a.key == b.key; });
    return twice == entries_.end() ? Status() : error(ErrorCode::malformed_mesh, twice->key, 0, "is there twice");
}

std::string ZipArchive::first_part(FunctionRef<bool(std::string_view name)> passes) const {
    for (std::uint64_t index = 0; index < entries_.size(); ++index) {
        const char* const name = zip_get_name(stream_->zip, index, ZIP_FL_ENC_RAW);
        if (name != nullptr && passes(name)) {
            return name;
        }
    }
    return {};
}

const ZipArchive::Entry* ZipArchive::find(std::string_view part) const {
    const std::string key = key_of(part);
    const auto found = std::lower_bound(entries_.begin(), entries_.end(), key,
                                        [](const Entry& entry, const std::string& name) { return entry.key < name; });
    return found != entries_.end() && found->key == key ? &*found : nullptr;
}

Status ZipArchive::read(std::string_view part, FunctionRef<bool(std::string_view piece)> take) {
    std::uint64_t stated_bytes = 0;
    if (Status opened = open_part(part, stated_bytes); !opened) {
        return opened;
    }
    Status copied = copy_part(part, stated_bytes, take);
    stream_->close_part();
    return copied;
}

Status ZipArchive::open_part(std::string_view part, std::uint64_t& bytes) {
    const Entry* const entry = find(part);
    if (entry == nullptr) {
        return error(ErrorCode::malformed_mesh, part, 0, "is missing");
    }
    zip_stat_t info{};
    if (zip_stat_index(stream_->zip, entry->index, 0, &info) != 0) {
        return error(ErrorCode::malformed_mesh, part, 0, "is damaged: its entry in the zip directory");
    }
    if (info.encryption_method != ZIP_EM_NONE) {
        return error(ErrorCode::malformed_mesh, part, 0, "is encrypted");
    }
    if (info.comp_method != ZIP_CM_STORE && info.comp_method != ZIP_CM_DEFLATE) {
        return error(ErrorCode::malformed_mesh, part, 0,
                     "is compressed by method " + std::to_string(info.comp_method) + ", which is not deflate");
    }
    stream_->part = zip_fopen_index(stream_->zip, entry->index, 0);
    if (stream_->part == nullptr) {
        throw_without_memory(zip_get_error(stream_->zip));
        return error(ErrorCode::malformed_mesh, part, 0, "is damaged: its header in the zip archive");
    }
    bytes = info.size;
    return {};
}

Status ZipArchive::copy_part(std::string_view part, std::uint64_t stated_bytes,
                             FunctionRef<bool(std::string_view piece)> take) {
    std::array<char, inflated_bytes>& piece = stream_->piece;
    std::uint64_t bytes = 0;
    bool wanted = true;
    for (;;) {
        file_->parallel().stop_if_asked();
        const zip_int64_t got = zip_fread(stream_->part, piece.data(), piece.size());
        if (got < 0 || (got == 0 && bytes != stated_bytes)) {
            return unreadable(part, bytes, stated_bytes);
        }
        if (got == 0) {
            return {};
        }
        bytes += static_cast<std::uint64_t>(got);
        expanded_bytes_ += static_cast<std::uint64_t>(got);
        if (expanded_bytes_ > limit_bytes_) {
            return error(ErrorCode::out_of_memory, part, 0,
                         "expands to more than the " + std::to_string(limit_bytes_) + " bytes that all parts together may");
        }
        if (bytes > stated_bytes) {
            return error(ErrorCode::malformed_mesh, part, 0,
                         "is damaged: more than the " + std::to_string(stated_bytes) +
                             " bytes that the zip directory says that they are");
        }
        wanted = wanted && take({piece.data(), static_cast<std::size_t>(got)});
    }
}

/// Why no more than `bytes` of a part can be read.
Error ZipArchive::unreadable(std::string_view part, std::uint64_t bytes, std::uint64_t stated_bytes) const {
    zip_error_t* const reason = zip_file_get_error(stream_->part);
    throw_without_memory(reason);
    switch (zip_error_code_zip(reason)) {
        case ZIP_ER_CRC:
            return error(ErrorCode::malformed_mesh, part, 0, "is damaged: its checksum differs");
        case ZIP_ER_ZLIB:
            return error(ErrorCode::malformed_mesh, part, 0, "is damaged: no valid deflate data");
        default:
            return error(ErrorCode::malformed_mesh, part, 0,
                         "is damaged: " + std::to_string(bytes) + " bytes, of which the zip directory says that they are " +
                             std::to_string(stated_bytes));
    }
}

}  // namespace lamella
