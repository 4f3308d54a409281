#include "io/read/three_mf/zip_archive.hpp"

#include <zip.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <new>
#include <optional>

#include "io/text/text.hpp"

namespace lamella {

namespace {

constexpr std::size_t piece_bytes = std::size_t{256} << 10;

/// libzip reads the directory anew for each end record that it finds, and compares names by pairs where they were chosen to
/// collide in its hash table.
constexpr std::size_t most_end_records = 16;
constexpr std::size_t most_entries = 10'000;

constexpr std::string_view directory_magic = "PK\x01\x02";
constexpr std::string_view end_magic = "PK\x05\x06";

/// Where in a file an archive is. Its offsets count from its first part.
struct ArchivePlace {
    std::size_t begin = 0;
    std::size_t end_record = 0;
    std::size_t end = 0;
};

std::optional<ArchivePlace> locate_archive(std::string_view file) {
    constexpr std::size_t end_record_bytes = 22;  // without the comment, whose length is the last two
    const std::size_t end_record = file.rfind(end_magic);
    if (end_record == std::string_view::npos || file.size() - end_record < end_record_bytes) {
        return std::nullopt;
    }
    std::uint16_t comment_bytes = 0;
    std::memcpy(&comment_bytes, file.data() + end_record + end_record_bytes - sizeof comment_bytes, sizeof comment_bytes);
    return ArchivePlace{std::min(file.find(zip_magic), end_record), end_record,
                        std::min(end_record + end_record_bytes + comment_bytes, file.size())};
}

bool holds_more_than(std::size_t most, std::string_view magic, std::string_view archive) {
    std::size_t count = 0;
    for (std::size_t at = archive.find(magic); at != std::string_view::npos && count <= most;
         at = archive.find(magic, at + magic.size())) {
        ++count;
    }
    return count > most;
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

Error error_in_part(const FileSource& file, ErrorCode code, std::string_view part, std::uint64_t line,
                    const std::string& what) {
    const std::string place = "part '" + printable(part) + "'";
    return file.error(code, line == 0 ? place + " " + what : place + ", line " + std::to_string(line) + ": " + what);
}

void ZipArchive::Closer::operator()(zip* archive) const noexcept {
    zip_discard(archive);
}

void ZipArchive::Closer::operator()(zip_file* part) const noexcept {
    zip_fclose(part);
}

Result<ZipArchive> ZipArchive::open(const FileSource& file, std::span<const std::byte> bytes, std::uint64_t limit_bytes) {
    const std::string_view text = as_text(bytes);
    const std::optional<ArchivePlace> place = locate_archive(text);
    if (!place) {
        return file.error(ErrorCode::malformed_mesh, "is truncated or no zip archive: it does not end with a zip directory");
    }
    const std::string_view own = text.substr(place->begin, place->end - place->begin);
    if (holds_more_than(most_entries, directory_magic, own) || holds_more_than(most_end_records, end_magic, own)) {
        return file.error(ErrorCode::malformed_mesh, "is a zip archive of more than the " + std::to_string(most_entries) +
                                                         " parts or " + std::to_string(most_end_records) +
                                                         " directories that are read");
    }
    ZipArchive archive(file, limit_bytes);
    archive.bytes_before_ = place->begin;
    archive.bytes_after_ = text.size() - place->end;
    zip_error_t error;
    zip_error_init(&error);
    zip_source_t* const source = zip_source_buffer_create(own.data(), own.size(), 0, &error);
    archive.zip_.reset(source != nullptr ? zip_open_from_source(source, ZIP_RDONLY, &error) : nullptr);
    if (archive.zip_ == nullptr) {
        zip_source_free(source);
        throw_without_memory(&error);
        return file.error(ErrorCode::malformed_mesh, zip_error_code_zip(&error) == ZIP_ER_MULTIDISK
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
    const auto count = static_cast<std::uint64_t>(std::max<zip_int64_t>(0, zip_get_num_entries(zip_.get(), 0)));
    if (count == 0) {
        return file_->error(ErrorCode::malformed_mesh, "is a zip archive without any part");
    }
    for (std::uint64_t index = 0; index < count; ++index) {
        const char* const name = zip_get_name(zip_.get(), index, ZIP_FL_ENC_RAW);
        entries_.push_back({key_of(name != nullptr ? name : ""), index});
    }
    std::sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) { return a.key < b.key; });
    const auto twice =
        std::adjacent_find(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) { return a.key == b.key; });
    return twice == entries_.end() ? Status() : error(ErrorCode::malformed_mesh, twice->key, 0, "is there twice");
}

std::string ZipArchive::first_part(FunctionRef<bool(std::string_view name)> passes) const {
    for (std::uint64_t index = 0; index < entries_.size(); ++index) {
        const char* const name = zip_get_name(zip_.get(), index, ZIP_FL_ENC_RAW);
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
    const Result<OpenPart> open = open_part(part, stated_bytes);
    if (!open) {
        return open.error();
    }
    std::vector<char> piece(piece_bytes);
    std::uint64_t bytes = 0;
    bool wanted = true;
    for (;;) {
        file_->parallel().stop_if_asked();
        const zip_int64_t got = zip_fread(open->get(), piece.data(), piece.size());
        if (got < 0 || (got == 0 && bytes != stated_bytes)) {
            return unreadable(open->get(), part, bytes, stated_bytes);
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

/// `bytes`: what the directory says that it expands to.
Result<ZipArchive::OpenPart> ZipArchive::open_part(std::string_view part, std::uint64_t& bytes) const {
    const Entry* const entry = find(part);
    if (entry == nullptr) {
        return error(ErrorCode::malformed_mesh, part, 0, "is missing");
    }
    zip_stat_t info{};
    if (zip_stat_index(zip_.get(), entry->index, 0, &info) != 0) {
        return error(ErrorCode::malformed_mesh, part, 0, "is damaged: its entry in the zip directory");
    }
    if (info.encryption_method != ZIP_EM_NONE) {
        return error(ErrorCode::malformed_mesh, part, 0, "is encrypted");
    }
    if (info.comp_method != ZIP_CM_STORE && info.comp_method != ZIP_CM_DEFLATE) {
        return error(ErrorCode::malformed_mesh, part, 0,
                     "is compressed by method " + std::to_string(info.comp_method) + ", which is not deflate");
    }
    OpenPart open(zip_fopen_index(zip_.get(), entry->index, 0));
    if (open == nullptr) {
        throw_without_memory(zip_get_error(zip_.get()));
        return error(ErrorCode::malformed_mesh, part, 0, "is damaged: its header in the zip archive");
    }
    bytes = info.size;
    return open;
}

/// Why no more than `bytes` of a part can be read.
Error ZipArchive::unreadable(zip_file* open, std::string_view part, std::uint64_t bytes, std::uint64_t stated_bytes) const {
    zip_error_t* const reason = zip_file_get_error(open);
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
