// SHA-256, by libcrypto.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <new>

#include <openssl/evp.h>

namespace lamella {

class Sha256 {
public:
    using Digest = std::array<unsigned char, 32>;

    /// Throws std::bad_alloc.
    Sha256() : context_(EVP_MD_CTX_new(), &EVP_MD_CTX_free) {
        if (!context_ || EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) != 1) {
            throw std::bad_alloc();
        }
    }

    void add(const void* data, std::size_t bytes) noexcept { EVP_DigestUpdate(context_.get(), data, bytes); }
    /// Once, at the end.
    Digest digest() noexcept {
        Digest sum{};
        unsigned length = 0;
        EVP_DigestFinal_ex(context_.get(), sum.data(), &length);
        return sum;
    }

private:
    std::unique_ptr<EVP_MD_CTX, void (*)(EVP_MD_CTX*)> context_;
};

}  // namespace lamella
