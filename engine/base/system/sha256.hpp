// SHA-256: by libcrypto, and by the system on Windows and macOS.
#pragma once

#include <array>
#include <cstddef>
#include <new>

#ifdef _WIN32
#include "base/system/windows.hpp"

#include <bcrypt.h>
#elif defined(__APPLE__)
#include <CommonCrypto/CommonDigest.h>
#else
// Of a static libcrypto these link 10 kB; what OpenSSL recommends instead links all of it, which is 4 MB.
#define OPENSSL_SUPPRESS_DEPRECATED
#include <openssl/sha.h>
#endif

namespace lamella {

#ifdef _WIN32
class Sha256 {
public:
    using Digest = std::array<unsigned char, 32>;

    /// Throws std::bad_alloc.
    Sha256() {
        static const BCRYPT_ALG_HANDLE algorithm = [] {
            BCRYPT_ALG_HANDLE opened = nullptr;
            return BCryptOpenAlgorithmProvider(&opened, BCRYPT_SHA256_ALGORITHM, nullptr, 0) == 0 ? opened : nullptr;
        }();
        if (BCryptCreateHash(algorithm, &hash_, nullptr, 0, nullptr, 0, 0) != 0) {
            throw std::bad_alloc();
        }
    }
    ~Sha256() { BCryptDestroyHash(hash_); }
    Sha256(const Sha256&) = delete;
    Sha256& operator=(const Sha256&) = delete;

    /// Precondition: less than 4 GiB.
    void add(const void* data, std::size_t bytes) noexcept {
        auto* const begin = static_cast<unsigned char*>(const_cast<void*>(data));  // which is only read
        BCryptHashData(hash_, begin, static_cast<ULONG>(bytes), 0);
    }
    /// Once, at the end.
    Digest digest() noexcept {
        Digest sum{};
        BCryptFinishHash(hash_, sum.data(), sum.size(), 0);
        return sum;
    }

private:
    BCRYPT_HASH_HANDLE hash_ = nullptr;
};
#elif defined(__APPLE__)
class Sha256 {
public:
    using Digest = std::array<unsigned char, 32>;

    Sha256() noexcept { CC_SHA256_Init(&state_); }

    /// Precondition: less than 4 GiB.
    void add(const void* data, std::size_t bytes) noexcept { CC_SHA256_Update(&state_, data, static_cast<CC_LONG>(bytes)); }
    /// Once, at the end.
    Digest digest() noexcept {
        Digest sum{};
        CC_SHA256_Final(sum.data(), &state_);
        return sum;
    }

private:
    CC_SHA256_CTX state_{};
};
#else
class Sha256 {
public:
    using Digest = std::array<unsigned char, 32>;

    Sha256() noexcept { SHA256_Init(&state_); }

    void add(const void* data, std::size_t bytes) noexcept { SHA256_Update(&state_, data, bytes); }
    /// Once, at the end.
    Digest digest() noexcept {
        Digest sum{};
        SHA256_Final(sum.data(), &state_);
        return sum;
    }

private:
    SHA256_CTX state_{};
};
#endif

}  // namespace lamella
