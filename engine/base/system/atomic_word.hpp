// An integer of an array that several threads change at once.
#pragma once

#include <atomic>
#include <type_traits>

namespace lamella {

#ifdef __cpp_lib_atomic_ref
template <class Word>
using AtomicRef = std::atomic_ref<Word>;
#else
/// The same by the compiler's own functions: libc++ 14 has none.
template <class Word>
class AtomicRef {
public:
    static constexpr bool is_always_lock_free = __atomic_always_lock_free(sizeof(Word), nullptr);

    explicit AtomicRef(Word& word) noexcept : word_(&word) {}
    Word load(std::memory_order /*relaxed*/) const noexcept { return __atomic_load_n(word_, __ATOMIC_RELAXED); }
    void store(Word value, std::memory_order /*relaxed*/) const noexcept {
        __atomic_store_n(word_, value, __ATOMIC_RELAXED);
    }
    bool compare_exchange_strong(Word& expected, Word desired, std::memory_order /*relaxed*/) const noexcept {
        return __atomic_compare_exchange_n(word_, &expected, desired, false, __ATOMIC_RELAXED, __ATOMIC_RELAXED);
    }
    void fetch_add(Word value, std::memory_order /*relaxed*/) const noexcept {
        __atomic_fetch_add(word_, value, __ATOMIC_RELAXED);
    }
    void fetch_and(Word bits, std::memory_order /*relaxed*/) const noexcept {
        __atomic_fetch_and(word_, bits, __ATOMIC_RELAXED);
    }

private:
    Word* word_;
};
#endif

/// Relaxed throughout: the word alone is shared, and nothing is read because of its value that another thread wrote before.
template <class Word>
class AtomicWord {
    static_assert(std::is_integral_v<Word> && AtomicRef<Word>::is_always_lock_free, "without a lock");

public:
    explicit AtomicWord(Word& word) noexcept : word_(word) {}

    Word load() const noexcept { return word_.load(std::memory_order_relaxed); }

    void store(Word value) const noexcept { word_.store(value, std::memory_order_relaxed); }

    /// Writes `desired` where the word is `expected`. Elsewhere `expected` becomes what the word is, and false comes back.
    bool replace(Word& expected, Word desired) const noexcept {
        return word_.compare_exchange_strong(expected, desired, std::memory_order_relaxed);
    }

    void add(Word value) const noexcept { word_.fetch_add(value, std::memory_order_relaxed); }

    /// Clears the bits that are not among `bits`. Most often none is set: then nothing is written.
    void keep(Word bits) const noexcept {
        if ((load() & ~bits) != 0) {
            word_.fetch_and(bits, std::memory_order_relaxed);
        }
    }

private:
    AtomicRef<Word> word_;
};

}  // namespace lamella
