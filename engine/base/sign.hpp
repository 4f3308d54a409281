// The sign of any number.
#pragma once

namespace lamella {

/// 1, 0 or -1; 0 of what is not a number.
template <class Number>
constexpr int sign_of(Number value) noexcept {
    return static_cast<int>(value > 0) - static_cast<int>(value < 0);
}

}  // namespace lamella
