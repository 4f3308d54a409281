// A value for each worker of a run, of which the first needs no memory: small work has one worker.
#pragma once

#include <cstddef>
#include <vector>

namespace lamella {

template <class T>
class PerWorker {
public:
    /// `workers` values, at least one. Throws std::bad_alloc.
    explicit PerWorker(std::size_t workers) : rest_(workers > 1 ? workers - 1 : 0) {}

    T& operator[](std::size_t worker) noexcept { return worker == 0 ? first_ : rest_[worker - 1]; }

    /// Calls use(value) for each.
    template <class Use>
    void for_each(Use&& use) const {
        use(first_);
        for (const T& value : rest_) {
            use(value);
        }
    }

private:
    T first_{};
    std::vector<T> rest_;
};

}  // namespace lamella
