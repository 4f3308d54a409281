// The machine and the process.
#pragma once

#include <cstddef>
#include <cstdint>

namespace lamella {

/// Of the machine; 0 where the system does not say.
std::uint64_t physical_memory_bytes() noexcept;

/// Asks for huge pages under memory that is not touched yet. Advice only: where the system has none to give, small ones
/// serve.
void advise_huge_pages(void* block, std::size_t bytes) noexcept;

/// Differs between a process and its children.
std::uint64_t process_number() noexcept;

}  // namespace lamella
