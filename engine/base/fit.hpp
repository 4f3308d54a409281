// Scratch cut down to its size.
#pragma once

#include <utility>

#include "base/vector.hpp"
#include "lamella/array.hpp"

namespace lamella {

/// Gives back what lies beyond the size; the elements are lost. Throws std::bad_alloc.
template <class T>
void fit(Array<T>& array) {
    if (array.capacity() > array.size()) {
        const std::size_t size = array.size();
        array = Array<T>(array.memory());  // first, so that both are never held at once
        array.resize_discarding(size);
    }
}

template <class T>
void fit(Vector<T>& array) {
    array.shrink_to_fit();
}

}  // namespace lamella
