// Reading ahead of streams that the processor's own prefetchers do not keep up with.
#pragma once

#include <cstddef>

namespace lamella {

/// How far ahead: measured, and flat from 4 KiB on.
inline constexpr std::size_t prefetch_bytes = 4096;

/// Asks for [at + prefetch_bytes, at + prefetch_bytes + bytes), which need not exist.
inline void prefetch_ahead(const std::byte* at, std::size_t bytes) noexcept {
#ifdef __GNUC__
    constexpr std::size_t cache_line = 64;
    for (std::size_t offset = 0; offset < bytes; offset += cache_line) {
        __builtin_prefetch(at + prefetch_bytes + offset);
    }
#endif
}

}  // namespace lamella
