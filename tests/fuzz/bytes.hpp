// What the fuzz targets share: choices and soups drawn from the fuzzer's bytes, and the report of a finding.
#pragma once

#include <algorithm>
#include <array>
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

// Soups, with corners on small integers, so that corners often coincide.

using Corner = std::array<double, 3>;
using Triangle = std::array<Corner, 3>;

inline Corner corner(Bytes& bytes, double step_mm) {
    const unsigned xy = bytes.next();
    const auto at = [step_mm](unsigned integer) { return step_mm * (static_cast<double>(integer) - 4); };
    return {at(xy % 9), at(xy / 16 % 9), at(bytes.below(9))};
}

/// Adds a triangle, or the four faces of a tetrahedron: single triangles rarely form closed contours.
inline void add_shape(Bytes& bytes, bool solid, double step_mm, std::vector<Triangle>& triangles) {
    const Corner a = corner(bytes, step_mm);
    const Corner b = corner(bytes, step_mm);
    const Corner c = corner(bytes, step_mm);
    triangles.push_back({a, b, c});
    if (solid) {
        const Corner d = corner(bytes, step_mm);
        triangles.insert(triangles.end(), {{a, c, d}, {c, b, d}, {b, a, d}});
    }
}

/// The same triangles in another order, each starting at another of its corners.
inline void shuffle_soup(std::vector<Triangle>& triangles, std::uint32_t seed) {
    shuffle(triangles, seed);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        Triangle& corners = triangles[t];
        std::rotate(corners.begin(), corners.begin() + static_cast<std::ptrdiff_t>(t % 3), corners.end());
    }
}

template <class Number>
std::vector<Number> soup_of(const std::vector<Triangle>& triangles) {
    std::vector<Number> soup;
    for (const Triangle& triangle : triangles) {
        for (const Corner& at : triangle) {
            soup.insert(soup.end(), {static_cast<Number>(at[0]), static_cast<Number>(at[1]), static_cast<Number>(at[2])});
        }
    }
    return soup;
}

}  // namespace fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
