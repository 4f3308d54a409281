// What the fuzz targets share: choices drawn from the fuzzer's bytes, and the report of a finding.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "lamella/audit.hpp"

namespace fuzz {

/// Reads byte by byte. Past the end it reads zeros, so that every input is valid.
class Bytes {
public:
    Bytes(const std::uint8_t* data, std::size_t size) : rest_(data, size) {}

    std::uint8_t next() {
        if (rest_.empty()) {
            return 0;
        }
        const std::uint8_t byte = rest_.front();
        rest_ = rest_.subspan(1);
        return byte;
    }
    /// A number below `end`, which is at most 256.
    unsigned below(unsigned end) { return next() % end; }
    bool empty() const { return rest_.empty(); }
    std::span<const std::uint8_t> rest() const { return rest_; }

private:
    std::span<const std::uint8_t> rest_;
};

/// Aborts if the condition is false. The fuzzers and the replay treat an abort as a finding.
inline void require(bool holds, const std::string& promise) {
    if (!holds) {
        (void)std::fprintf(stderr, "broken: %s\n", promise.c_str());
        std::abort();
    }
}

template <class T>
T value_of(lamella::Result<T> result) {
    require(result.ok(), result.ok() ? "" : result.error().message);
    return std::move(result).value();
}

inline void require_valid(const lamella::SliceResult& result) {
    const auto found = value_of(lamella::audit(
        result, lamella::MeshView{},
        {.open = false, .volume = false, .ledger = false, .crossings = false, .structure = true}, {.threads = 1}));
    require(found.structure->ok(), found.structure->ok() ? "" : found.structure->error().message);
}

/// An order that depends only on the seed.
template <class T>
void shuffle(std::vector<T>& items, std::uint32_t seed) {
    for (std::size_t i = items.size(); i > 1; --i) {
        seed = seed * 1664525U + 1013904223U;
        std::swap(items[i - 1], items[(seed >> 8) % i]);
    }
}

}  // namespace fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
