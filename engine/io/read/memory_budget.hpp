// What a reader may still allocate. Counted before memory is taken, so that no count in a file can take more.
#pragma once

#include <cstdint>
#include <string>

#include "io/read/reader.hpp"

namespace lamella {

class MemoryBudget {
public:
    explicit MemoryBudget(const FileSource& source) : source_(source), left_(source.memory_limit()) {}

    /// Counts `count` elements of `element_bytes` each. False: they are too many. Precondition: element_bytes > 0.
    bool try_take(std::uint64_t count, std::uint64_t element_bytes) noexcept {
        const bool fits = count <= left_ / element_bytes;
        left_ -= fits ? count * element_bytes : 0;
        return fits;
    }

    /// The same, or an error.
    Status take(std::uint64_t count, std::uint64_t element_bytes) {
        if (!try_take(count, element_bytes)) {
            return source_.error(
                ErrorCode::out_of_memory,
                "expands to more than the " + std::to_string(source_.memory_limit()) + " bytes that reading it may take");
        }
        return {};
    }

    std::uint64_t limit_bytes() const noexcept { return source_.memory_limit(); }

    /// What was taken and is free again.
    void give_back(std::uint64_t bytes) noexcept { left_ += bytes; }

private:
    const FileSource& source_;
    std::uint64_t left_;
};

}  // namespace lamella
