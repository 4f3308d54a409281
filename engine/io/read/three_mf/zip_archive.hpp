// A zip archive in memory, with or without ZIP64, read part by part as a stream by libzip.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/parallel.hpp"
#include "io/read/reader.hpp"
#include "lamella/error.hpp"

struct zip;
struct zip_file;

namespace lamella {

inline constexpr std::string_view zip_magic = "PK\x03\x04";

/// An error in a part of a zip archive, at `line` of it if that is not 0.
Error error_in_part(const FileSource& file, ErrorCode code, std::string_view part, std::uint64_t line,
                    const std::string& what);

/// Names of parts are equal in any case, as the Open Packaging Conventions have it, and with percent escapes or without:
/// programs differ in whether a name in the archive has those that a reference has.
class ZipArchive {
public:
    /// The archive among the bytes of `file`, both of which must outlive it. All parts together may expand to `limit_bytes`.
    static Result<ZipArchive> open(const FileSource& file, std::span<const std::byte> bytes, std::uint64_t limit_bytes);

    /// Bytes of the file before and after the archive.
    std::uint64_t bytes_before() const noexcept { return bytes_before_; }
    std::uint64_t bytes_after() const noexcept { return bytes_after_; }

    bool contains(std::string_view part) const { return find(part) != nullptr; }

    /// The first part in the archive's order whose name passes, or an empty string.
    std::string first_part(FunctionRef<bool(std::string_view name)> passes) const;

    /// Hands the part to `take`, piece by piece, until it answers false; the rest is then only checked to be undamaged.
    /// Errors, which name the part: there is none of that name, it is damaged or encrypted, or it expands too far.
    Status read(std::string_view part, FunctionRef<bool(std::string_view piece)> take);

    Error error(ErrorCode code, std::string_view part, std::uint64_t line, const std::string& what) const {
        return error_in_part(*file_, code, part, line, what);
    }

private:
    struct Entry {
        std::string key;      // the name in lower case, without escapes
        std::uint64_t index;  // in the archive's directory
    };
    struct Closer {
        void operator()(zip* archive) const noexcept;
        void operator()(zip_file* part) const noexcept;
    };
    using OpenPart = std::unique_ptr<zip_file, Closer>;

    ZipArchive(const FileSource& file, std::uint64_t limit_bytes) : file_(&file), limit_bytes_(limit_bytes) {}

    Status list_parts();
    const Entry* find(std::string_view part) const;
    Result<OpenPart> open_part(std::string_view part, std::uint64_t& bytes) const;
    Error unreadable(zip_file* open, std::string_view part, std::uint64_t bytes, std::uint64_t stated_bytes) const;

    const FileSource* file_;
    std::uint64_t limit_bytes_;
    std::uint64_t expanded_bytes_ = 0;
    std::uint64_t bytes_before_ = 0;
    std::uint64_t bytes_after_ = 0;
    std::unique_ptr<zip, Closer> zip_;
    std::vector<Entry> entries_;  // sorted by key
};

}  // namespace lamella
