#include "medical/provenance/sha256.hpp"

#include <new>
#include <string_view>

#include <openssl/evp.h>

namespace lamella {

Sha256::Sha256() : context_(EVP_MD_CTX_new(), &EVP_MD_CTX_free) {
    if (!context_ || EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) != 1) {
        throw std::bad_alloc();
    }
}

void Sha256::add(const void* data, std::size_t bytes) noexcept {
    EVP_DigestUpdate(context_.get(), data, bytes);
}

std::array<unsigned char, 32> Sha256::digest() noexcept {
    std::array<unsigned char, 32> sum{};
    unsigned length = 0;
    EVP_DigestFinal_ex(context_.get(), sum.data(), &length);
    return sum;
}

std::string hexadecimal(const std::array<unsigned char, 32>& digest) {
    constexpr std::string_view digits = "0123456789abcdef";
    std::string text;
    for (const unsigned char byte : digest) {
        text += digits[byte >> 4];
        text += digits[byte & 15];
    }
    return text;
}

}  // namespace lamella
