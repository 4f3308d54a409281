#include "base/counted_memory.hpp"

#include <new>

#include "lamella/array.hpp"

namespace lamella {

CountedMemory::CountedMemory(const Memory* host) noexcept : host_(host) {
    counting_.context = this;
    counting_.allocate = [](void* context, std::size_t bytes, std::size_t alignment) noexcept -> void* {
        auto& self = *static_cast<CountedMemory*>(context);
        void* block = nullptr;
        if (self.host_ != nullptr) {
            block = self.host_->allocate(self.host_->context, bytes, alignment);
        } else {
            try {
                block = detail::take_memory(nullptr, bytes);
            } catch (const std::bad_alloc&) {
                return nullptr;
            }
        }
        self.bytes_.fetch_add(block != nullptr ? bytes : 0, std::memory_order_relaxed);
        return block;
    };
    counting_.release = [](void* context, void* block, std::size_t bytes, std::size_t alignment) noexcept {
        auto& self = *static_cast<CountedMemory*>(context);
        self.bytes_.fetch_sub(bytes, std::memory_order_relaxed);
        if (self.host_ != nullptr) {
            self.host_->release(self.host_->context, block, bytes, alignment);
        } else {
            detail::give_memory(nullptr, block, bytes);
        }
    };
}

}  // namespace lamella
