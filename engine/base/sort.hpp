// Sorting where a page shall be small.
#pragma once

#include <algorithm>
#include <functional>

#include "base/system/processor.hpp"

namespace lamella {

/// As std::sort(). A page sorts by a heap instead: a sixth of the code for each kind of item, for longer sorting.
template <class Iterator, class Less = std::less<>>
void sort_briefly(Iterator first, Iterator last, Less less = {}) {
    if constexpr (small_code) {
        std::make_heap(first, last, less);
        std::sort_heap(first, last, less);
    } else {
        std::sort(first, last, less);
    }
}

}  // namespace lamella
