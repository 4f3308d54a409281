// A zip archive in memory, with or without ZIP64, read part by part as a stream by libzip.
#pragma once

#include <zip.h>

#include <map>
#include <memory>
#include <new>

#include "io/read/reader.hpp"

namespace lamella {

inline constexpr std::string_view zip_magic = "PK\x03\x04";

/// Throws Refused at a part of a zip archive, at `line` of it if that is not 0.
[[noreturn]] inline void refuse_part(const FileSource& file, ErrorCode code, std::string_view part, std::uint64_t line,
                                     const std::string& what) {
    const std::string place = "part '" + printable(part) + "'";
    file.refuse(code, line == 0 ? place + " " + what : place + ", line " + std::to_string(line) + ": " + what);
}

/// Names of parts are equal in any case, as the Open Packaging Conventions have it, and with percent escapes or without:
/// programs differ in whether a name in the archive has those that a reference has.
class ZipArchive {
public:
    /// The archive among the bytes of `file`, both of which must outlive it. All parts together may expand to `limit_bytes`.
    /// Throws Refused.
    static ZipArchive open(const FileSource& file, std::span<const std::byte> bytes, std::uint64_t limit_bytes) {
        const std::string_view text = as_text(bytes);
        const std::optional<ArchivePlace> place = locate_archive(text);
        if (!place) {
            file.refuse(ErrorCode::malformed_mesh, "is truncated or no zip archive: it does not end with a zip directory");
        }
        const std::string_view own = text.substr(place->begin, place->end - place->begin);
        if (holds_more_than(most_entries, directory_magic, own) || holds_more_than(most_end_records, end_magic, own)) {
            file.refuse(ErrorCode::malformed_mesh, "is a zip archive of more than the " + std::to_string(most_entries) +
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
            file.refuse(ErrorCode::malformed_mesh, zip_error_code_zip(&error) == ZIP_ER_MULTIDISK
                                                       ? "is one of several volumes of a zip archive"
                                                       : "is damaged: its zip directory, which the end record at byte " +
                                                             std::to_string(place->end_record) + " describes");
        }
        archive.list_parts();
        return archive;
    }

    /// Bytes of the file before and after the archive.
    std::uint64_t bytes_before() const noexcept { return bytes_before_; }
    std::uint64_t bytes_after() const noexcept { return bytes_after_; }

    bool contains(std::string_view part) const { return entries_.contains(key_of(part)); }

    /// The first part in the archive's order whose name passes, or an empty string.
    std::string first_part(FunctionRef<bool(std::string_view name)> passes) const {
        for (std::uint64_t index = 0; index < entries_.size(); ++index) {
            const char* const name = zip_get_name(zip_.get(), index, ZIP_FL_ENC_RAW);
            if (name != nullptr && passes(name)) {
                return name;
            }
        }
        return {};
    }

    /// Hands the part to `take`, piece by piece, until it answers false; the rest is then only checked to be undamaged.
    /// Throws Refused, which names the part: there is none of that name, it is damaged or encrypted, or it expands too far.
    void read(std::string_view part, FunctionRef<bool(std::string_view piece)> take) {
        std::uint64_t stated_bytes = 0;
        const OpenPart open = open_part(part, stated_bytes);
        std::vector<char> piece(piece_bytes);
        std::uint64_t bytes = 0;
        bool wanted = true;
        for (;;) {
            file_->parallel().stop_if_asked();
            const zip_int64_t got = zip_fread(open.get(), piece.data(), piece.size());
            if (got < 0 || (got == 0 && bytes != stated_bytes)) {
                refuse_unreadable(open.get(), part, bytes, stated_bytes);
            }
            if (got == 0) {
                return;
            }
            bytes += static_cast<std::uint64_t>(got);
            expanded_bytes_ += static_cast<std::uint64_t>(got);
            if (expanded_bytes_ > limit_bytes_) {
                refuse(part,
                       "expands to more than the " + std::to_string(limit_bytes_) + " bytes that all parts together may", 0,
                       ErrorCode::out_of_memory);
            }
            if (bytes > stated_bytes) {
                refuse(part, "is damaged: more than the " + std::to_string(stated_bytes) +
                                 " bytes that the zip directory says that they are");
            }
            wanted = wanted && take({piece.data(), static_cast<std::size_t>(got)});
        }
    }

    [[noreturn]] void refuse(std::string_view part, const std::string& what, std::uint64_t line = 0,
                             ErrorCode code = ErrorCode::malformed_mesh) const {
        refuse_part(*file_, code, part, line, what);
    }

private:
    static constexpr std::size_t piece_bytes = std::size_t{256} << 10;

    /// libzip reads the directory anew for each end record that it finds, and compares names by pairs where they were chosen
    /// to collide in its hash table.
    static constexpr std::size_t most_end_records = 16;
    static constexpr std::size_t most_entries = 10'000;

    static constexpr std::string_view directory_magic = "PK\x01\x02";
    static constexpr std::string_view end_magic = "PK\x05\x06";

    /// Where in a file an archive is. Its offsets count from its first part.
    struct ArchivePlace {
        std::size_t begin = 0;
        std::size_t end_record = 0;
        std::size_t end = 0;
    };

    static std::optional<ArchivePlace> locate_archive(std::string_view file) {
        constexpr std::size_t end_record_bytes = 22;  // without the comment, whose length is the last two
        const std::size_t end_record = file.rfind(end_magic);
        if (end_record == std::string_view::npos || file.size() - end_record < end_record_bytes) {
            return std::nullopt;
        }
        std::uint16_t comment_bytes = 0;
        std::memcpy(&comment_bytes, file.data() + end_record + end_record_bytes - sizeof comment_bytes,
                    sizeof comment_bytes);
        return ArchivePlace{std::min(file.find(zip_magic), end_record), end_record,
                            std::min(end_record + end_record_bytes + comment_bytes, file.size())};
    }

    static bool holds_more_than(std::size_t most, std::string_view magic, std::string_view archive) {
        std::size_t count = 0;
        for (std::size_t at = archive.find(magic); at != std::string_view::npos && count <= most;
             at = archive.find(magic, at + magic.size())) {
            ++count;
        }
        return count > most;
    }

    /// Percent escapes resolved, in lower case.
    static std::string key_of(std::string_view name) {
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

    static void throw_without_memory(const zip_error_t* error) {
        if (zip_error_code_zip(error) == ZIP_ER_MEMORY) {
            throw std::bad_alloc();
        }
    }

    struct Closer {
        void operator()(zip* archive) const noexcept { zip_discard(archive); }
        void operator()(zip_file* part) const noexcept { zip_fclose(part); }
    };
    using OpenPart = std::unique_ptr<zip_file, Closer>;

    ZipArchive(const FileSource& file, std::uint64_t limit_bytes) : file_(&file), limit_bytes_(limit_bytes) {}

    void list_parts() {
        const auto count = static_cast<std::uint64_t>(std::max<zip_int64_t>(0, zip_get_num_entries(zip_.get(), 0)));
        if (count == 0) {
            file_->refuse(ErrorCode::malformed_mesh, "is a zip archive without any part");
        }
        for (std::uint64_t index = 0; index < count; ++index) {
            const char* const name = zip_get_name(zip_.get(), index, ZIP_FL_ENC_RAW);
            const auto [entry, is_new] = entries_.emplace(key_of(name != nullptr ? name : ""), index);
            if (!is_new) {
                refuse(entry->first, "is there twice");
            }
        }
    }

    /// `bytes`: what the directory says that it expands to.
    OpenPart open_part(std::string_view part, std::uint64_t& bytes) const {
        const auto entry = entries_.find(key_of(part));
        if (entry == entries_.end()) {
            refuse(part, "is missing");
        }
        zip_stat_t info{};
        if (zip_stat_index(zip_.get(), entry->second, 0, &info) != 0) {
            refuse(part, "is damaged: its entry in the zip directory");
        }
        if (info.encryption_method != ZIP_EM_NONE) {
            refuse(part, "is encrypted");
        }
        if (info.comp_method != ZIP_CM_STORE && info.comp_method != ZIP_CM_DEFLATE) {
            refuse(part, "is compressed by method " + std::to_string(info.comp_method) + ", which is not deflate");
        }
        OpenPart open(zip_fopen_index(zip_.get(), entry->second, 0));
        if (open == nullptr) {
            throw_without_memory(zip_get_error(zip_.get()));
            refuse(part, "is damaged: its header in the zip archive");
        }
        bytes = info.size;
        return open;
    }

    /// Why no more than `bytes` of a part can be read.
    [[noreturn]] void refuse_unreadable(zip_file* open, std::string_view part, std::uint64_t bytes,
                                        std::uint64_t stated_bytes) const {
        zip_error_t* const reason = zip_file_get_error(open);
        throw_without_memory(reason);
        switch (zip_error_code_zip(reason)) {
            case ZIP_ER_CRC:
                refuse(part, "is damaged: its checksum differs");
            case ZIP_ER_ZLIB:
                refuse(part, "is damaged: no valid deflate data");
            default:
                refuse(part, "is damaged: " + std::to_string(bytes) +
                                 " bytes, of which the zip directory says that they are " + std::to_string(stated_bytes));
        }
    }

    const FileSource* file_;
    std::uint64_t limit_bytes_;
    std::uint64_t expanded_bytes_ = 0;
    std::uint64_t bytes_before_ = 0;
    std::uint64_t bytes_after_ = 0;
    std::unique_ptr<zip, Closer> zip_;
    std::map<std::string, std::uint64_t> entries_;  // where in the archive's directory, by the name's key
};

}  // namespace lamella
