#include "base/system/machine.hpp"
#include "base/system/windows.hpp"

namespace lamella {

std::uint64_t physical_memory_bytes() noexcept {
    MEMORYSTATUSEX memory{};
    memory.dwLength = sizeof memory;
    return ::GlobalMemoryStatusEx(&memory) != 0 ? memory.ullTotalPhys : 0;
}

void advise_huge_pages(void* /*block*/, std::size_t /*bytes*/) noexcept {}  // they need a privilege of the user's

std::uint64_t process_number() noexcept {
    return ::GetCurrentProcessId();
}

}  // namespace lamella
