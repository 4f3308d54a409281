// Base64 (RFC 4648), decoded as a stream.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

namespace lamella {

/// Reads bytes from text that may hold several runs, each padded by '=', and white space anywhere.
class Base64Reader {
public:
    explicit Base64Reader(std::string_view text) noexcept : p_(text.data()), end_(text.data() + text.size()) {}

    /// Fills `out`. False: the text ends before, or at() is no base64.
    bool read(std::span<std::byte> out) noexcept;

    /// Where the text has been read to.
    const char* at() const noexcept { return p_; }

    /// At least as many bytes as are left.
    std::size_t most_left() const noexcept {
        return static_cast<std::size_t>(end_ - p_) / 4 * 3 + 3 + (read_end_ - read_begin_);
    }

private:
    bool read_quad() noexcept;

    const char* p_;
    const char* end_;
    std::array<std::byte, 3> read_{};  ///< of the last four letters; [read_begin_, read_end_) are yet to be given out
    std::size_t read_begin_ = 0;
    std::size_t read_end_ = 0;
};

}  // namespace lamella
