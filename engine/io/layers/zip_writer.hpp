// A zip archive, entry by entry as they come: libzip would hold all of them until the end.
#pragma once

#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>

#include "base/guard.hpp"
#include "base/little_endian.hpp"
#include "io/write/output_file.hpp"

namespace lamella {

/// Zip64 where there are more entries, or they lie farther on, than the old format can say. Memory: about 60 bytes an entry.
class ZipWriter {
public:
    static constexpr std::uint16_t stored = 0;
    static constexpr std::uint16_t deflated = 8;

    explicit ZipWriter(OutputFile& out) : out_(out) {}

    /// One that is stored.
    void add(std::string_view name, std::string_view bytes) {
        const auto* const begin_of_bytes = reinterpret_cast<const unsigned char*>(bytes.data());
        begin(name, stored, static_cast<std::uint32_t>(::crc32_z(0, begin_of_bytes, bytes.size())), bytes.size(),
              bytes.size());
        write(bytes);
    }

    /// One whose `packed` bytes follow by write(). Throws Refused.
    void begin(std::string_view name, std::uint16_t method, std::uint32_t checksum, std::uint64_t bytes,
               std::uint64_t packed) {
        if (std::max(bytes, packed) >= limit32) {
            throw Refused{{ErrorCode::invalid_argument, "'" + std::string(name) + "': 4 GiB or more, too large for a zip"}};
        }
        const bool is_far = at_ >= limit32;
        std::string head;
        put<std::uint16_t>(head, {0, method, 0, january_1980});  // no flags; time, date
        put<std::uint32_t>(head, {checksum, static_cast<std::uint32_t>(packed), static_cast<std::uint32_t>(bytes)});
        put<std::uint16_t>(head, {static_cast<std::uint16_t>(name.size())});
        std::string local = "PK\3\4";
        put<std::uint16_t>(local, {version_20});
        local += head;
        put<std::uint16_t>(local, {0});
        local += name;

        directory_ += "PK\1\2";
        put<std::uint16_t>(directory_, {version_20, is_far ? version_64 : version_20});
        directory_ += head;
        put<std::uint16_t>(directory_,
                           {static_cast<std::uint16_t>(is_far ? 12 : 0), 0, 0, 0});  // extra, comment, disk, attributes
        put<std::uint32_t>(directory_, {0, static_cast<std::uint32_t>(std::min(at_, limit32))});
        directory_ += name;
        if (is_far) {
            put<std::uint16_t>(directory_, {1, 8});
            put<std::uint64_t>(directory_, {at_});
        }
        ++entries_;
        write(local);
    }

    void write(std::string_view bytes) {
        out_.append(bytes);
        at_ += bytes.size();
    }

    void finish() {
        const std::uint64_t begin = at_;
        const std::uint64_t size = directory_.size();
        write(directory_);
        std::string end;
        if (entries_ >= limit16 || begin + size >= limit32) {
            end += "PK\6\6";
            put<std::uint64_t>(end, {44});
            put<std::uint16_t>(end, {version_64, version_64});
            put<std::uint32_t>(end, {0, 0});
            put<std::uint64_t>(end, {entries_, entries_, size, begin});
            end += "PK\6\7";
            put<std::uint32_t>(end, {0});
            put<std::uint64_t>(end, {begin + size});
            put<std::uint32_t>(end, {1});
        }
        end += "PK\5\6";
        const auto count = static_cast<std::uint16_t>(std::min(entries_, limit16));
        put<std::uint16_t>(end, {0, 0, count, count});
        put<std::uint32_t>(end, {static_cast<std::uint32_t>(std::min(size, limit32)),
                                 static_cast<std::uint32_t>(std::min(begin, limit32))});
        put<std::uint16_t>(end, {0});
        write(end);
    }

private:
    static constexpr std::uint64_t limit16 = 0xffff;
    static constexpr std::uint64_t limit32 = 0xffffffff;
    static constexpr std::uint16_t version_20 = 20;
    static constexpr std::uint16_t version_64 = 45;
    static constexpr std::uint16_t january_1980 = 1 << 5 | 1;  ///< the first day that there is

    template <class Number>
    static void put(std::string& to, std::initializer_list<Number> numbers) {
        to.append(reinterpret_cast<const char*>(numbers.begin()), numbers.size() * sizeof(Number));
    }

    OutputFile& out_;
    std::string directory_;
    std::uint64_t entries_ = 0;
    std::uint64_t at_ = 0;  ///< bytes written
};

}  // namespace lamella
