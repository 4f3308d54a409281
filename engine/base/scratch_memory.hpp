// Scratch that is kept from call to call: from the host, or from operator new, with a count of what is taken.
#pragma once

#include <atomic>
#include <cstddef>
#include <mutex>
#include <span>
#include <vector>

#include "lamella/context.hpp"

namespace lamella {

/// Small blocks of operator new share huge pages, once there are many: a page of 4 KB that is touched first costs 2 to 15
/// us, and a first slice took 600 of them.
///
///     chunk of 32 MB   [ block | block | given back | block |  rest ]
///
/// A block that was given back serves the next that is nearly as large: arrays of many threads and bands grow in the same
/// steps. A chunk of which all blocks were given back goes itself.
class ScratchMemory {
public:
    /// `host`: null for operator new.
    explicit ScratchMemory(const Memory* host) noexcept : host_(host) {}
    ~ScratchMemory();
    ScratchMemory(const ScratchMemory&) = delete;  // referred to by what takes memory
    ScratchMemory& operator=(const ScratchMemory&) = delete;

    const Memory* host() const noexcept { return host_; }
    const Memory* memory() const noexcept { return &own_; }
    /// Taken from the host and not given back, but for what no block was taken of.
    std::size_t bytes() const noexcept { return bytes_; }

    /// For memory_of(), from several threads at once. Arrays ask for no other alignment than what the host is asked for.
    /// Throws std::bad_alloc.
    void* allocate(std::size_t bytes, std::size_t alignment);
    void deallocate(void* block, std::size_t bytes, std::size_t alignment) noexcept;
    /// At most so many bytes of what small blocks will be taken of next. Nothing where each comes from the host.
    std::span<std::byte> make_ahead(std::size_t bytes);

private:
    struct Chunk {
        std::byte* begin;
        std::size_t used = 0;  ///< the rest was never given
        std::size_t live = 0;  ///< blocks not given back
    };
    struct Block {
        std::byte* begin;
        std::size_t bytes;
    };

    /// Blocks of an eighth of a chunk and more have huge pages of their own.
    bool may_share(std::size_t bytes) const noexcept;
    std::byte* take_again(std::size_t bytes) noexcept;
    std::byte* take_new(std::size_t bytes);
    Chunk& chunk_for(std::size_t bytes);
    bool give_to_chunk(const Block& block) noexcept;
    std::vector<Chunk>::iterator chunk_of(const std::byte* block) noexcept;

    const Memory* host_;
    std::atomic<std::size_t> bytes_ = 0;
    std::mutex mutex_;
    std::vector<Chunk> chunks_;      // new blocks come from the last
    std::vector<Block> given_back_;  // with room for all that may be
    std::size_t live_ = 0;           // blocks of all chunks
    const Memory own_ = memory_of(*this);
};

}  // namespace lamella
