// Scratch that most calls never need.
#pragma once

#include <memory>
#include <new>
#include <type_traits>

#include "lamella/array.hpp"
#include "lamella/context.hpp"

namespace lamella {

/// Made at its first use, in the host's memory, and kept.
template <class T>
class OnDemand {
public:
    explicit OnDemand(const Memory* memory) noexcept : memory_(memory) {}
    OnDemand(const OnDemand&) = delete;
    OnDemand& operator=(const OnDemand&) = delete;
    ~OnDemand() {
        if (made_ != nullptr) {
            std::destroy_at(made_);
            detail::give_memory(memory_, made_, sizeof(T));
        }
    }

    /// The first call makes it of `arguments`. Throws std::bad_alloc.
    template <class... Arguments>
    T& get(Arguments&... arguments) {
        static_assert(std::is_nothrow_constructible_v<T, Arguments&...>);
        if (made_ == nullptr) {
            made_ = ::new (detail::take_memory(memory_, sizeof(T))) T(arguments...);
        }
        return *made_;
    }

private:
    const Memory* memory_;
    T* made_ = nullptr;
};

}  // namespace lamella
