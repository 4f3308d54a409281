// A flat array of plain values, as results hold them.
//
//     lamella::Array<lamella::Point> points;
//     points.resize_discarding(2);  // two points of unspecified value
//     points[0] = {0, 0};
//     points[1] = {4, 2};
//     for (const lamella::Point& point : points) {
//         std::printf("%d %d\n", point.x, point.y);
//     }
//
// It differs from std::vector in two things. Its memory comes from the host where the host gives one (context.hpp), and a
// new size leaves the elements unwritten: writing fresh pages is the largest single cost of slicing.
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <new>
#include <span>
#include <type_traits>
#include <utility>

#include "lamella/context.hpp"

namespace lamella {

namespace detail {
/// From `memory`, or, when it is null, from operator new with large blocks aligned for and advised to use huge pages.
/// Throws std::bad_alloc.
void* take_memory(const Memory* memory, std::size_t bytes);
void give_memory(const Memory* memory, void* block, std::size_t bytes) noexcept;

/// Counts have 64 bits on every platform. One of what lies in memory fits a size.
template <class T>
constexpr std::span<T> span_of(T* first, std::uint64_t count) noexcept {
    return {first, static_cast<std::size_t>(count)};
}
}  // namespace detail

/// Move-only. Growing discards the contents unless said otherwise; shrinking keeps the memory, so that an array which is
/// used again costs no page faults.
template <class T>
class Array {
    static_assert(std::is_trivially_copyable_v<T>, "elements are left uninitialised and copied as bytes");

public:
    explicit Array(const Memory* memory = nullptr) noexcept : memory_(memory) {}
    Array(Array&& other) noexcept
        : memory_(other.memory_),
          data_(std::exchange(other.data_, nullptr)),
          size_(std::exchange(other.size_, 0)),
          capacity_(std::exchange(other.capacity_, 0)) {}
    Array& operator=(Array&& other) noexcept {
        std::swap(memory_, other.memory_);
        std::swap(data_, other.data_);
        std::swap(size_, other.size_);
        std::swap(capacity_, other.capacity_);
        return *this;
    }
    Array(const Array&) = delete;
    Array& operator=(const Array&) = delete;
    ~Array() { detail::give_memory(memory_, data_, capacity_ * sizeof(T)); }

    /// Size `count`, contents unspecified. O(1) where the capacity suffices. The one call of the public headers that throws:
    /// std::bad_alloc, after which the array is as it was.
    void resize_discarding(std::uint64_t count) {
        const auto size = static_cast<std::size_t>(count);
        if (count > capacity_) {
            if (count > std::numeric_limits<std::size_t>::max() / sizeof(T)) {
                throw std::bad_array_new_length();
            }
            T* fresh = static_cast<T*>(detail::take_memory(memory_, size * sizeof(T)));
            detail::give_memory(memory_, std::exchange(data_, fresh), std::exchange(capacity_, size) * sizeof(T));
        }
        size_ = size;
    }

    /// Sets the size within the capacity, keeping contents.
    void set_size(std::size_t count) noexcept {
        assert(count <= capacity_);
        size_ = count;
    }

    const Memory* memory() const noexcept { return memory_; }
    T* data() noexcept { return data_; }
    const T* data() const noexcept { return data_; }
    std::size_t size() const noexcept { return size_; }
    std::size_t capacity() const noexcept { return capacity_; }
    bool empty() const noexcept { return size_ == 0; }
    T* begin() noexcept { return data_; }
    T* end() noexcept { return data_ + size_; }
    const T* begin() const noexcept { return data_; }
    const T* end() const noexcept { return data_ + size_; }
    T& operator[](std::size_t i) noexcept {
        assert(i < size_);
        return data_[i];
    }
    const T& operator[](std::size_t i) const noexcept {
        assert(i < size_);
        return data_[i];
    }
    std::span<const T> span() const noexcept { return {data_, size_}; }
    std::span<T> span() noexcept { return {data_, size_}; }

private:
    const Memory* memory_ = nullptr;
    T* data_ = nullptr;
    std::size_t size_ = 0;
    std::size_t capacity_ = 0;
};

}  // namespace lamella
