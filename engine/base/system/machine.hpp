// The machine and the process.
#pragma once

#include <cstddef>
#include <cstdint>

namespace lamella {

/// Of the machine; 0 where the system does not say.
std::uint64_t physical_memory_bytes() noexcept;

// Sanitizers find what lies beyond a block only where each is a block of theirs.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool is_watched = true;
#elif defined(__has_feature)
inline constexpr bool is_watched = __has_feature(address_sanitizer) || __has_feature(thread_sanitizer);
#else
inline constexpr bool is_watched = false;
#endif

/// Asks for huge pages under memory that is not touched yet. Advice only: where the system has none to give, small ones
/// serve.
void advise_huge_pages(void* block, std::size_t bytes) noexcept;

/// Differs between a process and its children.
std::uint64_t process_number() noexcept;

}  // namespace lamella
