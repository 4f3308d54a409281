// Shared by both formats of VTK: a file, and its arrays of numbers as text and bytes.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "base/guard.hpp"
#include "io/read/number_type.hpp"
#include "io/read/reader.hpp"
#include "lamella/array.hpp"

namespace lamella {

/// What a reader may still allocate. Counted before memory is taken, so that no count in a file can take more.
class MemoryBudget {
public:
    explicit MemoryBudget(const FileSource& source) : source_(source), left_(source.memory_limit()) {}

    /// Counts `count` elements of `element_bytes` each. False: they are too many. Precondition: element_bytes > 0.
    bool try_take(std::uint64_t count, std::uint64_t element_bytes) noexcept {
        const bool fits = count <= left_ / element_bytes;
        left_ -= fits ? count * element_bytes : 0;
        return fits;
    }

    /// The same, or throws an error.
    void take(std::uint64_t count, std::uint64_t element_bytes) {
        if (!try_take(count, element_bytes)) {
            throw Refused{source_.error(
                ErrorCode::out_of_memory,
                "expands to more than the " + std::to_string(source_.memory_limit()) + " bytes that reading it may take")};
        }
    }

    /// What was taken and is free again.
    void give_back(std::uint64_t bytes) noexcept { left_ += bytes; }

private:
    const FileSource& source_;
    std::uint64_t left_;
};

struct NumberArray {
    /// How the numbers stand in the file.
    enum class Form : std::uint8_t {
        text,    ///< as words
        bytes,   ///< as they are
        encoded  ///< in base64 or compressed
    };

    const std::byte* data = nullptr;
    std::uint64_t count = 0;
    NumberType type = NumberType::float32;
    bool big_endian = false;
    Form form = Form::bytes;
    const char* at = nullptr;    ///< in the file: the first of them, or the element of what is encoded
    Array<std::byte> storage{};  ///< of numbers that do not lie in the file as they are
};

/// The file that is being read.
struct VtkFile {
    explicit VtkFile(FileContents& file) : source(file.source), bytes(file.bytes), text(file.whole), budget(file.source) {}

    std::uint64_t offset_of(const char* p) const noexcept { return static_cast<std::uint64_t>(p - text.data()); }

    /// Throws a TextError at a number of an array.
    [[noreturn]] void fail_at(const NumberArray& numbers, std::uint64_t index, const std::string& what) const;

    FileSource& source;
    Array<std::byte>& bytes;  ///< from which the mesh may take points that stay where they are
    std::string_view text;    ///< all of the file
    MemoryBudget budget;
};

// Arrays as text, which are parsed in parallel. The words are counted first, so that memory is taken for what is there.

/// Reads `count` numbers from the words of [p, end), and moves `p` past them. `name` is theirs in messages. `type` is what
/// they are read as: a float or a double, or uint32 or uint64 for integers, which must not be negative.
NumberArray read_words(VtkFile& file, const char*& p, const char* end, std::uint64_t count, NumberType type,
                       std::string_view name);
/// Moves `p` past `count` words.
void skip_words(const VtkFile& file, const char*& p, const char* end, std::uint64_t count, std::string_view name);
/// The word of that index in [p, end), or `end`.
const char* find_word(const char* p, const char* end, std::uint64_t index);

// Arrays in memory.

/// The integers [first, first + count) in 64 bits; what is negative becomes more than 2^63.
/// Precondition: is_integer(numbers.type), and the range lies within.
void decode_integers(const NumberArray& numbers, std::uint64_t first, std::uint64_t count, std::uint64_t* out);

/// The same in 32 bits. Returns the largest in 64: if it does not fit, `out` does not hold what is in the array.
std::uint64_t decode_indices(const NumberArray& numbers, std::uint64_t first, std::uint64_t count, std::uint32_t* out);

/// What coordinates of `type` are held as, without loss up to integers of 53 bits.
constexpr CoordinateType coordinates_of(NumberType type) noexcept {
    return type == NumberType::float32 || size_of(type) <= 2 ? CoordinateType::f32 : CoordinateType::f64;
}

/// Converts all of `numbers` in parallel, without alignment. `out` may be where they lie, if that is their type.
void convert_coordinates(const NumberArray& numbers, CoordinateType type, std::byte* out, const Parallel& parallel);

}  // namespace lamella
