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
    /// The archive among the bytes of `file`, both of which must outlive it. Its offsets count from its first part. All
    /// parts together may expand to `limit_bytes`. Throws Refused.
    ZipArchive(const FileSource& file, std::span<const std::byte> bytes, std::uint64_t limit_bytes)
        : file_(file), limit_bytes_(limit_bytes) {
        constexpr std::size_t end_record_bytes = 22;  // without the comment, whose length is the last two
        const std::string_view text = as_text(bytes);
        const std::size_t end_record = text.rfind(end_magic);
        if (end_record == std::string_view::npos || text.size() - end_record < end_record_bytes) {
            file.refuse(ErrorCode::malformed_mesh, "is truncated or no zip archive: it does not end with a zip directory");
        }
        std::uint16_t comment_bytes = 0;
        std::memcpy(&comment_bytes, text.data() + end_record + end_record_bytes - sizeof comment_bytes,
                    sizeof comment_bytes);
        bytes_before_ = std::min(text.find(zip_magic), end_record);
        bytes_after_ = text.size() - std::min(end_record + end_record_bytes + comment_bytes, text.size());
        const std::string_view own = text.substr(bytes_before_, text.size() - bytes_after_ - bytes_before_);
        if (holds_more_than(most_entries, directory_magic, own) || holds_more_than(most_end_records, end_magic, own)) {
            file.refuse(ErrorCode::malformed_mesh, "is a zip archive of more than the " + std::to_string(most_entries) +
                                                       " parts or " + std::to_string(most_end_records) +
                                                       " directories that are read");
        }
        struct OwnError : zip_error_t {
            OwnError() noexcept : zip_error_t() { zip_error_init(this); }
            OwnError(const OwnError&) = delete;
            OwnError& operator=(const OwnError&) = delete;
            ~OwnError() { zip_error_fini(this); }
        } error;
        zip_source_t* const source = zip_source_buffer_create(own.data(), own.size(), 0, &error);
        zip_.reset(source != nullptr ? zip_open_from_source(source, ZIP_RDONLY, &error) : nullptr);
        if (zip_ == nullptr) {
            zip_source_free(source);
            file.refuse(ErrorCode::malformed_mesh, "is damaged: its zip directory, which the end record at byte " +
                                                       std::to_string(end_record) + " describes: " + reason(&error));
        }
        list_parts();
    }

    /// Bytes of the file before and after the archive.
    std::uint64_t bytes_before() const noexcept { return bytes_before_; }
    std::uint64_t bytes_after() const noexcept { return bytes_after_; }

    bool contains(std::string_view part) const { return entries_.contains(lower_case(without_escapes(part))); }

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

    /// Hands the part to `take`, in pieces that end after a '>' where there is one, until it answers false; the rest is then
    /// only checked to be undamaged. Throws Refused, which names the part: there is none of that name, it is damaged or
    /// encrypted, or it expands too far.
    void read(std::string_view part, FunctionRef<bool(std::string_view piece)> take) {
        zip_stat_t stated{};
        const OpenPart open = open_part(part, stated);
        std::vector<char> buffer(piece_bytes);
        std::size_t held = 0;
        std::uint64_t bytes = 0;
        bool wanted = true;
        for (zip_int64_t got = 1; got > 0;) {
            file_.parallel().stop_if_asked();
            got = zip_fread(open.get(), buffer.data() + held, buffer.size() - held);
            if (got < 0) {
                refuse(part, "is damaged: " + reason(zip_file_get_error(open.get())));
            }
            bytes += static_cast<std::uint64_t>(got);
            expanded_bytes_ += static_cast<std::uint64_t>(got);
            if (expanded_bytes_ > limit_bytes_) {
                refuse(part,
                       "expands to more than the " + std::to_string(limit_bytes_) + " bytes that all parts together may", 0,
                       ErrorCode::out_of_memory);
            }
            const std::string_view all(buffer.data(), held + static_cast<std::size_t>(got));
            std::size_t whole = all.rfind('>') + 1;  // 0 where there is none
            whole = got == 0 || (whole == 0 && all.size() == buffer.size()) ? all.size() : whole;
            wanted = wanted && take(all.substr(0, whole));
            held = all.size() - whole;
            std::memmove(buffer.data(), buffer.data() + whole, held);
        }
        if (bytes != stated.size) {
            refuse(part, "is damaged: " + std::to_string(bytes) + " bytes, of which the zip directory says that they are " +
                             std::to_string(stated.size));
        }
    }

    [[noreturn]] void refuse(std::string_view part, const std::string& what, std::uint64_t line = 0,
                             ErrorCode code = ErrorCode::malformed_mesh) const {
        refuse_part(file_, code, part, line, what);
    }

private:
    static constexpr std::size_t piece_bytes = std::size_t{256} << 10;

    /// libzip reads the directory anew for each end record that it finds, and compares names by pairs where they were chosen
    /// to collide in its hash table.
    static constexpr std::size_t most_end_records = 16;
    static constexpr std::size_t most_entries = 10'000;

    static constexpr std::string_view directory_magic = "PK\x01\x02";
    static constexpr std::string_view end_magic = "PK\x05\x06";

    static bool holds_more_than(std::size_t most, std::string_view magic, std::string_view archive) {
        std::size_t count = 0;
        for (std::size_t at = archive.find(magic); at != std::string_view::npos && count <= most;
             at = archive.find(magic, at + magic.size())) {
            ++count;
        }
        return count > most;
    }

    /// In libzip's words. Throws std::bad_alloc where that is it.
    static std::string reason(zip_error_t* error) {
        if (zip_error_code_zip(error) == ZIP_ER_MEMORY) {
            throw std::bad_alloc();
        }
        return zip_error_strerror(error);
    }

    struct Closer {
        void operator()(zip* archive) const noexcept { zip_discard(archive); }
        void operator()(zip_file* part) const noexcept { zip_fclose(part); }
    };
    using OpenPart = std::unique_ptr<zip_file, Closer>;

    void list_parts() {
        const auto count = static_cast<std::uint64_t>(std::max<zip_int64_t>(0, zip_get_num_entries(zip_.get(), 0)));
        if (count == 0) {
            file_.refuse(ErrorCode::malformed_mesh, "is a zip archive without any part");
        }
        for (std::uint64_t index = 0; index < count; ++index) {
            const char* const name = zip_get_name(zip_.get(), index, ZIP_FL_ENC_RAW);
            const auto [entry, is_new] = entries_.emplace(lower_case(without_escapes(name != nullptr ? name : "")), index);
            if (!is_new) {
                refuse(entry->first, "is there twice");
            }
        }
    }

    OpenPart open_part(std::string_view part, zip_stat_t& info) const {
        const auto entry = entries_.find(lower_case(without_escapes(part)));
        if (entry == entries_.end()) {
            refuse(part, "is missing");
        }
        zip_stat_index(zip_.get(), entry->second, 0, &info);
        if (info.comp_method != ZIP_CM_STORE && info.comp_method != ZIP_CM_DEFLATE) {  // others take memory as they say
            refuse(part, "is compressed by method " + std::to_string(info.comp_method) + ", which is not deflate");
        }
        OpenPart open(zip_fopen_index(zip_.get(), entry->second, 0));
        if (open == nullptr) {
            refuse(part, "cannot be read: " + reason(zip_get_error(zip_.get())));
        }
        return open;
    }

    const FileSource& file_;
    std::uint64_t limit_bytes_;
    std::uint64_t expanded_bytes_ = 0;
    std::uint64_t bytes_before_ = 0;
    std::uint64_t bytes_after_ = 0;
    std::unique_ptr<zip, Closer> zip_;
    std::map<std::string, std::uint64_t> entries_;  // where in the archive's directory, by the name's key
};

}  // namespace lamella
