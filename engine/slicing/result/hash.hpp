// hash_result() of a result that comes in parts.
#pragma once

#include <cstdint>

#include "lamella/result.hpp"

namespace lamella {

/// FNV-1a with a whole 64-bit word where the original takes a byte: one multiplication a point.
class WordHash {
public:
    void add(std::uint64_t word) noexcept { state_ = (state_ ^ word) * 0x100000001b3U; }
    void add_signed(std::int64_t word) noexcept { add(static_cast<std::uint64_t>(word)); }
    std::uint64_t value() const noexcept { return state_; }

private:
    std::uint64_t state_ = 0xcbf29ce484222325U;
};

class ResultHash {
public:
    /// For so many layers.
    explicit ResultHash(std::uint64_t layers) noexcept { words_.add(layers); }
    /// The next ones, in their order.
    void add_layers(const SliceResult& result) noexcept;
    std::uint64_t value() const noexcept { return words_.value(); }

private:
    WordHash words_;
};

}  // namespace lamella
