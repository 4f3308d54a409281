// Data of zlib and gzip, expanded a megabyte at a time, so that a stop comes soon.
#pragma once

#include <algorithm>
#include <cstddef>
#include <new>
#include <span>

#include <zlib.h>

namespace lamella {

class Inflater {
public:
    /// `window` is as zlib takes it. Throws std::bad_alloc.
    explicit Inflater(int window) {
        if (inflateInit2(&stream, window) != Z_OK) {
            throw std::bad_alloc();
        }
    }
    ~Inflater() { inflateEnd(&stream); }
    Inflater(const Inflater&) = delete;
    Inflater& operator=(const Inflater&) = delete;

    /// Expands some of `packed` to `room`; both lose what has been used. Returns zlib's answer. Throws std::bad_alloc.
    int step(std::span<const std::byte>& packed, std::span<std::byte>& room) {
        constexpr std::size_t most = std::size_t{1} << 20;
        const std::size_t offered = std::min(packed.size(), most);
        const std::size_t usable = std::min(room.size(), most);
        stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(packed.data()));  // zlib does not write there
        stream.avail_in = static_cast<uInt>(offered);
        stream.next_out = reinterpret_cast<Bytef*>(room.data());
        stream.avail_out = static_cast<uInt>(usable);
        const int answer = inflate(&stream, Z_NO_FLUSH);
        if (answer == Z_MEM_ERROR) {
            throw std::bad_alloc();
        }
        packed = packed.subspan(offered - stream.avail_in);
        room = room.subspan(usable - stream.avail_out);
        return answer;
    }

    z_stream stream{};
};

}  // namespace lamella
