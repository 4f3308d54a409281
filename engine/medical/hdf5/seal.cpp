#include "medical/hdf5/seal.hpp"

#include <array>
#include <cstdio>
#include <cstring>
#include <string_view>

#include "base/guard.hpp"
#include "medical/hdf5/blocks.hpp"

namespace lamella {

namespace {

constexpr std::size_t text_bytes = seal_bytes - 8;
constexpr std::uint64_t most_tree_bytes = std::uint64_t{1} << 20;
constexpr std::string_view begin_of_seal = "lamella archive ";

/// Eight hexadecimal digits.
std::string digits(std::uint32_t sum) {
    std::array<char, 9> text{};
    (void)std::snprintf(text.data(), text.size(), "%08x", sum);
    return text.data();
}

/// What the seal of such a tree is, from its first byte to its last.
std::string seal_of(std::span<const std::byte> tree, std::uint64_t file_bytes) {
    std::string text(begin_of_seal);
    text += "1\ntree " + std::to_string(tree.size()) + " " + digits(checksum_of(tree.subspan(seal_bytes))) + "\nfile " +
            std::to_string(file_bytes) + "\n";
    text.resize(text_bytes, '.');
    return text + digits(checksum_of(std::as_bytes(std::span(text))));
}

[[noreturn]] void refuse(const InputFile& file, const std::string& why) {
    throw Refused{file.error(ErrorCode::malformed_mesh, why)};
}

void read_or_refuse(const InputFile& file, std::uint64_t offset, std::span<std::byte> into) {
    if (const Status read = file.read_at(offset, into); !read) {
        throw Refused{read.error()};
    }
}

/// HDF5 looks at the begin and behind user blocks.
bool is_hdf5(const InputFile& file) {
    constexpr std::string_view signature = "\x89HDF\r\n\x1a\n";
    for (std::uint64_t at = 0; at + signature.size() <= file.size(); at = at == 0 ? seal_bytes : 2 * at) {
        std::array<std::byte, signature.size()> found;
        read_or_refuse(file, at, found);
        if (std::memcmp(found.data(), signature.data(), signature.size()) == 0) {
            return true;
        }
    }
    return false;
}

struct SealNumbers {
    unsigned long long version = 0;
    unsigned long long tree_bytes = 0;
    unsigned long long file_bytes = 0;
};

SealNumbers numbers_of(const InputFile& file) {
    std::array<std::byte, seal_bytes> bytes{};
    if (file.size() >= seal_bytes) {
        read_or_refuse(file, 0, bytes);
    }
    const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (!text.starts_with(begin_of_seal)) {
        refuse(file, is_hdf5(file) ? "an HDF5 file, but no archive of lamella" : "no HDF5 file");
    }
    SealNumbers numbers;
    unsigned sum = 0;
    const int found = std::sscanf(text.c_str() + begin_of_seal.size(), "%llu\ntree %llu %8x\nfile %llu\n", &numbers.version,
                                  &numbers.tree_bytes, &sum, &numbers.file_bytes);
    if (text.substr(text_bytes) != digits(checksum_of(std::as_bytes(std::span(text)).first(text_bytes))) || found != 4) {
        refuse(file, "damaged: its first bytes do not have their checksum");
    }
    if (numbers.version != 1) {
        refuse(file, "written by a later version of lamella");
    }
    return numbers;
}

}  // namespace

void seal(std::span<std::byte> tree, std::uint64_t file_bytes) {
    const std::string text = seal_of(tree, file_bytes);
    std::memcpy(tree.data(), text.data(), text.size());
}

std::vector<std::byte> read_sealed(const InputFile& file) {
    const SealNumbers numbers = numbers_of(file);
    if (numbers.file_bytes != file.size()) {
        refuse(file, std::to_string(file.size()) + " bytes long, where " + std::to_string(numbers.file_bytes) +
                         " were written: it is cut off, or something was added");
    }
    if (numbers.tree_bytes < seal_bytes || numbers.tree_bytes > std::min<std::uint64_t>(file.size(), most_tree_bytes)) {
        refuse(file, "damaged: its first bytes contradict themselves");
    }
    std::vector<std::byte> tree(static_cast<std::size_t>(numbers.tree_bytes));
    read_or_refuse(file, 0, tree);
    const std::string expected = seal_of(tree, file.size());
    if (std::memcmp(tree.data(), expected.data(), expected.size()) != 0) {
        refuse(file, "damaged, or changed by another program: its groups and attributes do not have their checksum");
    }
    return tree;
}

}  // namespace lamella
