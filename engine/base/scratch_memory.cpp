#include "base/scratch_memory.hpp"

#include <algorithm>
#include <functional>
#include <utility>

#include "base/system/machine.hpp"
#include "lamella/array.hpp"

namespace lamella {

namespace {

// Where addresses are plenty: so much that allocators take it from the system, and give it back, by itself. What is not
// touched costs nothing.
constexpr std::size_t chunk_bytes = std::size_t{1} << (sizeof(void*) == 8 ? 25 : 21);
constexpr std::size_t few_bytes = std::size_t{1} << 18;  // for so much no huge page is worth clearing

constexpr std::size_t in_lines(std::size_t bytes) noexcept {
    constexpr std::size_t cache_line = 64;
    return (bytes + cache_line - 1) / cache_line * cache_line;
}

}  // namespace

bool ScratchMemory::may_share(std::size_t bytes) const noexcept {
    return host_ == nullptr && bytes < chunk_bytes / 8 && !is_watched;
}

ScratchMemory::~ScratchMemory() {
    for (const Chunk& chunk : chunks_) {
        detail::give_memory(nullptr, chunk.begin, chunk_bytes);
    }
}

void* ScratchMemory::allocate(std::size_t bytes, std::size_t /*alignment*/) {
    if (may_share(bytes) && bytes_ >= few_bytes) {
        const std::lock_guard lock(mutex_);
        if (given_back_.capacity() <= given_back_.size() + live_) {
            given_back_.reserve(2 * (given_back_.size() + live_) + 64);
        }
        std::byte* const again = take_again(in_lines(bytes));
        std::byte* const block = again != nullptr ? again : take_new(in_lines(bytes));
        ++chunk_of(block)->live;
        ++live_;
        return block;
    }
    void* const block = detail::take_memory(host_, bytes);
    bytes_ += bytes;
    return block;
}

/// The smallest that was given back and is at most a quarter larger; null where there is none.
std::byte* ScratchMemory::take_again(std::size_t bytes) noexcept {
    auto best = given_back_.end();
    for (auto block = given_back_.begin(); block != given_back_.end(); ++block) {
        if (block->bytes >= bytes && block->bytes <= bytes + bytes / 4 &&
            (best == given_back_.end() || block->bytes < best->bytes)) {
            best = block;
        }
    }
    if (best == given_back_.end()) {
        return nullptr;
    }
    std::byte* const begin = best->begin;
    *best = given_back_.back();
    given_back_.pop_back();
    return begin;
}

std::byte* ScratchMemory::take_new(std::size_t bytes) {
    Chunk& chunk = chunk_for(bytes);
    bytes_ += bytes;
    return chunk.begin + std::exchange(chunk.used, chunk.used + bytes);
}

ScratchMemory::Chunk& ScratchMemory::chunk_for(std::size_t bytes) {
    if (chunks_.empty() || chunks_.back().used + bytes > chunk_bytes) {
        chunks_.reserve(chunks_.size() + 1);
        chunks_.push_back({static_cast<std::byte*>(detail::take_memory(nullptr, chunk_bytes))});
    }
    return chunks_.back();
}

std::span<std::byte> ScratchMemory::make_ahead(std::size_t bytes) {
    if (bytes == 0 || !may_share(1)) {
        return {};
    }
    const std::lock_guard lock(mutex_);
    const Chunk& chunk = chunk_for(0);
    return {chunk.begin + chunk.used, std::min(bytes, chunk_bytes - chunk.used)};
}

void ScratchMemory::deallocate(void* block, std::size_t bytes, std::size_t /*alignment*/) noexcept {
    if (!may_share(bytes) || !give_to_chunk({static_cast<std::byte*>(block), in_lines(bytes)})) {
        bytes_ -= bytes;
        detail::give_memory(host_, block, bytes);
    }
}

/// False where no chunk holds the block.
bool ScratchMemory::give_to_chunk(const Block& block) noexcept {
    const std::lock_guard lock(mutex_);
    const auto chunk = chunk_of(block.begin);
    if (chunk == chunks_.end()) {
        return false;
    }
    --live_;
    given_back_.push_back(block);
    if (--chunk->live == 0) {
        std::erase_if(given_back_, [&](const Block& other) { return chunk_of(other.begin) == chunk; });
        detail::give_memory(nullptr, chunk->begin, chunk_bytes);
        bytes_ -= chunk->used;
        chunks_.erase(chunk);
    }
    return true;
}

std::vector<ScratchMemory::Chunk>::iterator ScratchMemory::chunk_of(const std::byte* block) noexcept {
    return std::find_if(chunks_.begin(), chunks_.end(), [block](const Chunk& chunk) {
        return std::less_equal<>()(chunk.begin, block) && std::less<>()(block, chunk.begin + chunk_bytes);
    });
}

}  // namespace lamella
