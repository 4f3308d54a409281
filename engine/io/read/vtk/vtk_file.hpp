// Shared by both formats of VTK: a file, its arrays of numbers as text, and points.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "io/read/memory_budget.hpp"
#include "io/read/reader.hpp"
#include "io/read/vtk/number_array.hpp"
#include "lamella/array.hpp"

namespace lamella {

/// The file that is being read, with what its parts need to report errors.
struct VtkFile {
    FileSource& source;
    std::string_view text;  ///< all of it
    MemoryBudget budget;

    std::uint64_t offset_of(const char* p) const noexcept { return static_cast<std::uint64_t>(p - text.data()); }

    /// An error at a place of the text.
    Error error_at(const char* p, const std::string& what) const { return source.error_in_text(text, offset_of(p), what); }
    /// An error at a number of an array.
    Error error_at(const NumberArray& numbers, std::uint64_t index, const std::string& what) const;
};

/// Reads `count` numbers from the words of [p, end), and moves `p` past them. `name` is theirs in messages. Value: what is
/// read of them; float and double for coordinates, std::uint32_t and std::uint64_t for integers.
template <class Value>
Result<NumberArray> read_text_array(VtkFile& file, const char*& p, const char* end, std::uint64_t count,
                                    std::string_view name, Array<std::byte>& storage);

/// Moves `p` past `count` words.
Status skip_text_array(const VtkFile& file, const char*& p, const char* end, std::uint64_t count, std::string_view name);

/// What coordinates of `type` are held as, without loss up to integers of 53 bits.
constexpr CoordinateType coordinates_of(NumberType type) noexcept {
    return type == NumberType::float32 || bytes_of(type) <= 2 ? CoordinateType::f32 : CoordinateType::f64;
}

constexpr std::size_t bytes_of(CoordinateType number) noexcept {
    return number == CoordinateType::f32 ? sizeof(float) : sizeof(double);
}

/// Converts all of `numbers` in parallel. `out` may be where they lie, if that is their type.
void convert_coordinates(const NumberArray& numbers, CoordinateType number, std::byte* out, const Parallel& parallel);

}  // namespace lamella
