// SHA-256, by libcrypto.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <string>

struct evp_md_ctx_st;

namespace lamella {

class Sha256 {
public:
    /// Throws std::bad_alloc.
    Sha256();

    void add(const void* data, std::size_t bytes) noexcept;
    /// Once, at the end.
    std::array<unsigned char, 32> digest() noexcept;

private:
    std::unique_ptr<evp_md_ctx_st, void (*)(evp_md_ctx_st*)> context_;
};

/// 64 hexadecimal digits.
std::string hexadecimal(const std::array<unsigned char, 32>& digest);

}  // namespace lamella
