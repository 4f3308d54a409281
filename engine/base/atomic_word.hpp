// An integer of an array that several threads change at once. std::atomic_ref would be it, but libc++ 14 has none.
#pragma once

#include <type_traits>

namespace lamella {

/// Relaxed throughout: the word alone is shared, and nothing is read because of its value that another thread wrote before.
template <class Word>
class AtomicWord {
    static_assert(std::is_integral_v<Word> && __atomic_always_lock_free(sizeof(Word), nullptr));

public:
    explicit AtomicWord(Word& word) noexcept : word_(&word) {}

    Word load() const noexcept { return __atomic_load_n(word_, __ATOMIC_RELAXED); }

    void store(Word value) const noexcept { __atomic_store_n(word_, value, __ATOMIC_RELAXED); }

    /// Writes `desired` where the word is `expected`. Elsewhere `expected` becomes what the word is, and false comes back.
    bool replace(Word& expected, Word desired) const noexcept {
        return __atomic_compare_exchange_n(word_, &expected, desired, false, __ATOMIC_RELAXED, __ATOMIC_RELAXED);
    }

    void add(Word value) const noexcept { __atomic_fetch_add(word_, value, __ATOMIC_RELAXED); }

    /// Clears the bits that are not among `bits`. Most often none is set: then nothing is written.
    void keep(Word bits) const noexcept {
        if ((load() & ~bits) != 0) {
            __atomic_fetch_and(word_, bits, __ATOMIC_RELAXED);
        }
    }

private:
    Word* word_;
};

}  // namespace lamella
