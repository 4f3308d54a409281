#include "io/read/gzip.hpp"

#include <zlib.h>

#include <algorithm>
#include <cstring>

#include "io/read/chunk_list.hpp"

namespace lamella {

namespace {

constexpr std::size_t chunk_bytes = std::size_t{4} << 20;
constexpr int gzip_window = 16 + MAX_WBITS;  // 16: the format is gzip, not zlib

/// The bytes decompressed so far: the size is known only at the end.
using Chunks = ChunkList<std::byte, chunk_bytes, chunk_bytes>;

class Inflater {
public:
    explicit Inflater(std::span<const std::byte> file) : left_(file) {
        if (inflateInit2(&stream_, gzip_window) != Z_OK) {
            throw std::bad_alloc();
        }
    }
    ~Inflater() { inflateEnd(&stream_); }
    Inflater(const Inflater&) = delete;
    Inflater& operator=(const Inflater&) = delete;

    /// Decompresses one step into `chunks`; zlib's answer.
    int step(Chunks& chunks) {
        const std::span<std::byte> room = chunks.room();
        const std::size_t offered = std::min<std::size_t>(left_.size(), chunk_bytes);
        stream_.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(left_.data()));  // zlib does not write there
        stream_.avail_in = static_cast<uInt>(offered);
        stream_.next_out = reinterpret_cast<Bytef*>(room.data());
        stream_.avail_out = static_cast<uInt>(room.size());
        const int answer = inflate(&stream_, Z_NO_FLUSH);
        left_ = left_.subspan(offered - stream_.avail_in);
        chunks.add(room.size() - stream_.avail_out);
        return answer;
    }

    /// After a member's end: whether another one follows, which the next step() begins.
    bool next_member() {
        if (left_.size() < gzip_magic.size() || std::memcmp(left_.data(), gzip_magic.data(), gzip_magic.size()) != 0) {
            return false;
        }
        return inflateReset(&stream_) == Z_OK;
    }

    std::uint64_t left() const noexcept { return left_.size(); }
    std::string complaint() const { return stream_.msg != nullptr ? std::string(": ") + stream_.msg : std::string(); }

private:
    z_stream stream_{};
    std::span<const std::byte> left_;
};

}  // namespace

Unzipped unzip(std::span<const std::byte> file, std::uint64_t limit_bytes, const Memory* memory, const Parallel& parallel) {
    Unzipped result{Array<std::byte>(memory), 0, {}, ErrorCode::malformed_mesh};
    Inflater inflater(file);
    Chunks chunks(memory);
    for (;;) {
        parallel.stop_if_asked();
        const int answer = inflater.step(chunks);
        if (chunks.size() > limit_bytes) {
            result.problem = "expands to more than the " + std::to_string(limit_bytes) + " bytes that reading it may take";
            result.code = ErrorCode::out_of_memory;
            return result;
        }
        if (answer == Z_STREAM_END && !inflater.next_member()) {
            break;
        }
        if (answer == Z_MEM_ERROR) {
            throw std::bad_alloc();
        }
        if (answer == Z_BUF_ERROR && inflater.left() == 0) {
            result.problem = "is truncated: its gzip data end too early";
            return result;
        }
        if (answer != Z_OK && answer != Z_STREAM_END && answer != Z_BUF_ERROR) {
            result.problem = "is damaged: no valid gzip data" + inflater.complaint();
            return result;
        }
    }
    result.ignored_bytes = inflater.left();
    result.contents = chunks.joined([&parallel] { parallel.stop_if_asked(); });
    return result;
}

}  // namespace lamella
