#include "io/read/reader.hpp"

#include <zlib.h>

#include <memory>
#include <new>

#include "io/read/chunk_list.hpp"

namespace lamella {

namespace {

constexpr std::size_t chunk_bytes = std::size_t{4} << 20;
constexpr int gzip_window = 16 + MAX_WBITS;  // 16: the format is gzip, not zlib

}  // namespace

Array<std::byte> unzip(const FileSource& source, std::span<const std::byte> bytes, std::uint64_t& ignored_bytes) {
    const Parallel& parallel = source.parallel();
    z_stream stream{};
    if (inflateInit2(&stream, gzip_window) != Z_OK) {
        throw std::bad_alloc();
    }
    const std::unique_ptr<z_stream, int (*)(z_streamp)> ended(&stream, &inflateEnd);
    ChunkList<std::byte, chunk_bytes, chunk_bytes> chunks(source.memory());  // the size is known only at the end
    for (;;) {
        parallel.stop_if_asked();
        const std::span<std::byte> room = chunks.room();
        const std::size_t offered = std::min<std::size_t>(bytes.size(), chunk_bytes);
        stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(bytes.data()));  // zlib does not write there
        stream.avail_in = static_cast<uInt>(offered);
        stream.next_out = reinterpret_cast<Bytef*>(room.data());
        stream.avail_out = static_cast<uInt>(room.size());
        const int answer = inflate(&stream, Z_NO_FLUSH);
        bytes = bytes.subspan(offered - stream.avail_in);
        chunks.add(room.size() - stream.avail_out);
        MemoryBudget(source).take(chunks.size(), 1);
        if (answer == Z_STREAM_END && (!as_text(bytes).starts_with(gzip_magic) || inflateReset(&stream) != Z_OK)) {
            break;  // the last member
        }
        if (answer == Z_MEM_ERROR) {
            throw std::bad_alloc();
        }
        if (answer == Z_BUF_ERROR && bytes.empty()) {
            source.refuse(ErrorCode::malformed_mesh, "is truncated: its gzip data end too early");
        }
        if (answer != Z_OK && answer != Z_STREAM_END && answer != Z_BUF_ERROR) {
            source.refuse(ErrorCode::malformed_mesh,
                          "is damaged: no valid gzip data" + (stream.msg != nullptr ? std::string(": ") + stream.msg : ""));
        }
    }
    ignored_bytes = bytes.size();
    return chunks.joined([&parallel] { parallel.stop_if_asked(); });
}

}  // namespace lamella
