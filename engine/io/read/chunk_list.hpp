// A list that grows without being copied, and whose memory can be released from the front while it is read: for what a text
// or compressed data hold, whose number is not known beforehand.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "base/function_ref.hpp"
#include "lamella/array.hpp"
#include "lamella/context.hpp"

namespace lamella {

/// Chunks double at first, so that small lists take little memory; later ones have one size.
template <class T, std::size_t smallest = 16, std::size_t largest = std::size_t{1} << 16>
class ChunkList {
public:
    explicit ChunkList(const Memory* memory = nullptr) noexcept : memory_(memory) {}

    std::size_t size() const noexcept { return size_; }

    /// Bytes that the next push_back() allocates.
    std::size_t next_bytes() const noexcept { return room_ > 0 ? 0 : next_count() * sizeof(T); }

    void push_back(const T& item) {
        room().front() = item;
        add(1);
    }

    /// Where the next elements go, at least one; add() says how many of them were written.
    std::span<T> room() {
        if (room_ == 0) {
            room_ = next_count();
            chunks_.emplace_back(memory_).resize_discarding(room_);
        }
        return chunks_.back().span().last(room_);
    }
    void add(std::size_t count) noexcept {
        room_ -= count;
        size_ += count;
    }

    std::size_t chunk_count() const noexcept { return chunks_.size(); }
    std::span<const T> chunk(std::size_t index) const noexcept {
        const Array<T>& chunk = chunks_[index];
        return chunk.span().first(index + 1 < chunks_.size() ? chunk.size() : chunk.size() - room_);
    }
    /// Releases the memory of a chunk, which must not be read any more.
    void release(std::size_t index) noexcept { chunks_[index] = Array<T>(memory_); }

    /// Copies all to `to` and empties the list: each chunk is released once it is copied. Calls `before_chunk` before that.
    void move_to(
        T* to, FunctionRef<void()> before_chunk = [] {}) {
        for (std::size_t c = 0; c < chunks_.size(); ++c) {
            before_chunk();
            to = std::copy(chunk(c).begin(), chunk(c).end(), to);
            release(c);
        }
        *this = ChunkList(memory_);
    }
    /// The same, to an array.
    Array<T> joined(FunctionRef<void()> before_chunk = [] {}) {
        Array<T> whole(memory_);
        whole.resize_discarding(size_);
        move_to(whole.data(), before_chunk);
        return whole;
    }

private:
    std::size_t next_count() const noexcept { return std::clamp(size_, smallest, largest); }

    const Memory* memory_;
    std::vector<Array<T>> chunks_;
    std::size_t size_ = 0;
    std::size_t room_ = 0;  // of the last chunk
};

}  // namespace lamella
