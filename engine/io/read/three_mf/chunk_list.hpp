// A list that grows without being copied, and whose memory can be released from the front while it is read: for elements of
// a text, whose number is not known beforehand.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "lamella/array.hpp"
#include "lamella/memory.hpp"

namespace lamella {

template <class T>
class ChunkList {
public:
    explicit ChunkList(const Memory* memory = nullptr) noexcept : memory_(memory) {}

    std::size_t size() const noexcept { return size_; }

    /// What the next push_back() allocates.
    std::size_t next_bytes() const noexcept { return room_ > 0 ? 0 : next_count() * sizeof(T); }

    void push_back(const T& item) {
        if (room_ == 0) {
            room_ = next_count();
            chunks_.emplace_back(memory_).resize_discarding(room_);
        }
        Array<T>& last = chunks_.back();
        last[last.size() - room_] = item;
        --room_;
        ++size_;
    }

    std::size_t chunk_count() const noexcept { return chunks_.size(); }
    std::span<const T> chunk(std::size_t index) const noexcept {
        const Array<T>& chunk = chunks_[index];
        return chunk.span().first(index + 1 < chunks_.size() ? chunk.size() : chunk.size() - room_);
    }
    /// Releases the memory of a chunk, which must not be read any more.
    void release(std::size_t index) noexcept { chunks_[index] = Array<T>(memory_); }

private:
    /// Chunks double at first, so that small lists take little memory; later ones have one size.
    std::size_t next_count() const noexcept {
        constexpr std::size_t smallest = 16;
        constexpr std::size_t largest = std::size_t{1} << 16;
        return std::clamp(size_, smallest, largest);
    }

    const Memory* memory_;
    std::vector<Array<T>> chunks_;
    std::size_t size_ = 0;
    std::size_t room_ = 0;  // of the last chunk
};

}  // namespace lamella
