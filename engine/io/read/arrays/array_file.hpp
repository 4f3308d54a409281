// Shared by formats whose meshes are arrays of numbers: a file, and its arrays as text and bytes.
#pragma once

#include "base/function_ref.hpp"
#include "io/read/number_type.hpp"
#include "io/read/reader.hpp"

namespace lamella {

/// Names of types in the order of NumberType.
inline constexpr std::array<std::string_view, 10> number_type_names = {"Int8",   "UInt8", "Int16",  "UInt16",  "Int32",
                                                                       "UInt32", "Int64", "UInt64", "Float32", "Float64"};

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

/// zlib compresses by a factor of 1032 at most.
inline constexpr std::uint64_t most_expansion = 1032;

/// The file that is being read.
struct ArrayFile {
    explicit ArrayFile(FileContents& file) : source(file.source), bytes(file.bytes), text(file.whole), budget(file.source) {}

    std::uint64_t offset_of(const char* p) const noexcept { return static_cast<std::uint64_t>(p - text.data()); }

    /// An error at a number of an array.
    TextError error_at(const NumberArray& numbers, std::uint64_t index, const std::string& what) const;

    FileSource& source;
    Array<std::byte>& bytes;  ///< from which the mesh may take points that stay where they are
    std::string_view text;    ///< all of the file
    MemoryBudget budget;
    bool takes_nan = false;  ///< text may say "nan" and "inf", as at vertices that have no value
};

// Arrays as text, which are parsed in parallel. The words are counted first, so that memory is taken for what is there.

/// Reads `count` numbers from the words of [p, end), and moves `p` past them. `name` is theirs in messages. `type` is what
/// they are read as: a float or a double, or uint32 or uint64 for integers, which must not be negative.
NumberArray read_words(ArrayFile& file, const char*& p, const char* end, std::uint64_t count, NumberType type,
                       std::string_view name);
/// The same of `text`, which must hold no more.
NumberArray read_all_words(ArrayFile& file, std::string_view text, std::uint64_t count, NumberType type,
                           std::string_view name);
/// Moves `p` past `count` words.
void skip_words(const ArrayFile& file, const char*& p, const char* end, std::uint64_t count, std::string_view name);
/// The word of that index in [p, end), or `end`.
const char* find_word(const char* p, const char* end, std::uint64_t index);

// Arrays in memory.

/// Calls use(number), where number(i) is that of index first + i, in its type.
template <class Use>
auto use_numbers(const NumberArray& numbers, std::uint64_t first, const Use& use) {
    return with_type(numbers.type, [&](auto sample) {
        using T = decltype(sample);
        const std::byte* const data = numbers.data + first * sizeof(T);
        return numbers.big_endian && sizeof(T) > 1
                   ? use([data](std::uint64_t i) { return load_number<T>(data + i * sizeof(T), true); })
                   : use([data](std::uint64_t i) { return load_number<T>(data + i * sizeof(T), false); });
    });
}

/// In 64 bits; what is negative becomes more than 2^63.
constexpr std::uint64_t to_integer(auto number) {
    return static_cast<std::uint64_t>(number);  // NOLINT(bugprone-signed-char-misuse): -1 is too large
}

inline std::uint64_t integer_at(const NumberArray& numbers, std::uint64_t index) {
    return use_numbers(numbers, index, [](auto number) { return to_integer(number(0)); });
}

/// Gives `mesh` the vertices of all `arrays`, in their order; those of one may stay where they are in the file.
void give_points(ArrayFile& file, std::span<NumberArray> arrays, MeshFile& mesh);

/// Gives `mesh` the numbers at its vertices that load() returns, in arrays one after the other. Where it
/// throws a TextError, they are left out with a warning.
void give_scalars(ArrayFile& file, VertexScalars scalars, FunctionRef<std::vector<NumberArray>()> load, MeshFile& mesh);

// --- Triangles of cells, which are polygons and triangle strips

enum class CellKind : std::uint8_t { polygons, strips };

/// Cells of one kind, in one of two layouts:
///
///     counted:  corners 3 a b c 4 d e f g         each cell's corners after their number, in 32 bits
///     else:     corners a b c d e f g, ends 3 7   all corners, and where each cell's end among them; no ends: triangles
struct CellArray {
    std::string_view name;  ///< for messages
    CellKind kind = CellKind::polygons;
    bool counted = false;
    std::uint64_t cells = 0;
    NumberArray corners{};
    NumberArray ends{};
    std::uint32_t first_point = 0;  ///< of those that the corners count from, in the mesh
    std::uint32_t point_count = 0;
};

/// Gives `mesh`, which has its vertices, the triangles of all `arrays`, in their order. Warns of cells without an area.
/// Throws errors. Memory: the indices, and little else unless there are polygons of millions of corners.
void cut_cells(ArrayFile& file, std::span<const CellArray> arrays, MeshFile& mesh);

}  // namespace lamella
