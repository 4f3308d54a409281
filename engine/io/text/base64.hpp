// Base64 (RFC 4648) in texts, decoded as a stream.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "base/parallel.hpp"

namespace lamella {

/// Fills `out` from the begin of `text`, which may hold several runs, each padded by '=', and white space anywhere. False:
/// it ends before, or is no base64.
bool decode_base64(std::string_view text, std::span<std::byte> out, const Parallel& parallel);

/// How many bytes all of `text` is, if it is one run of base64.
std::uint64_t base64_bytes(std::string_view text, const Parallel& parallel);

}  // namespace lamella
