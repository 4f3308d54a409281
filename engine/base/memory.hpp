// The caller's memory resource, where there is none: operator new. Arrays take null for that and ask for huge pages then.
#pragma once

#include <memory_resource>

namespace lamella {

inline std::pmr::memory_resource* resource_or_default(std::pmr::memory_resource* memory) noexcept {
    return memory != nullptr ? memory : std::pmr::new_delete_resource();
}

}  // namespace lamella
