// The rows of one element of a PLY file, in either encoding.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "io/read/ply/ply_header.hpp"

namespace lamella {

/// What the lists of indices of an element will take, known before anything is allocated for them.
struct PlyLists {
    std::uint64_t triangles = 0;  ///< at most
    std::uint64_t longest = 0;

    void add(std::uint64_t length) noexcept {
        triangles += length < 3 ? 0 : length - 2;
        longest = length < longest ? longest : length;
    }
};

/// In a triangle strip: -1, after which the next strip begins.
inline constexpr std::uint32_t strip_end = std::numeric_limits<std::uint32_t>::max();

/// `Numbers` is BinaryNumbers or AsciiNumbers. Each call reads a row. False: at() and what() hold the error.
template <class Numbers>
class PlyRows {
public:
    PlyRows(Numbers numbers, const PlyElement& element, std::uint64_t first_row = 0)
        : numbers_(numbers), element_(element), row_(first_row) {}

    /// Skips it, and counts its list of indices.
    bool skip(PlyLists& lists) {
        for (const PlyProperty& property : element_.properties) {
            std::uint64_t count = 1;
            if (property.is_list && !list_count(property, count)) {
                return false;
            }
            if (property.use == PlyUse::indices) {
                lists.add(count);
            }
            if (!numbers_.skip(property.type, count)) {
                return fail(property, "expected a number, found " + numbers_.found(property.type));
            }
        }
        ++row_;
        return true;
    }

    template <class Value>
    bool vertex(Value* xyz) {
        for (const PlyProperty& property : element_.properties) {
            const auto axis = static_cast<std::size_t>(property.use);
            const bool read =
                axis < 3 ? numbers_.number(property.type, xyz[axis]) || no_number(property) : skip_property(property);
            if (!read) {
                return false;
            }
        }
        ++row_;
        return true;
    }

    /// The row's list of indices, each of one of `vertex_count` vertices or, in strips, strip_end.
    bool indices(std::uint64_t vertex_count, std::vector<std::uint32_t>& list) {
        list.clear();
        for (const PlyProperty& property : element_.properties) {
            const bool read =
                property.use == PlyUse::indices ? index_list(property, vertex_count, list) : skip_property(property);
            if (!read) {
                return false;
            }
        }
        ++row_;
        return true;
    }

    const Numbers& numbers() const { return numbers_; }
    const char* at() const { return at_; }
    const std::string& what() const { return what_; }

private:
    bool list_count(const PlyProperty& property, std::uint64_t& count) {
        numbers_.go_to_next();
        const Numbers before = numbers_;
        std::int64_t number = 0;
        if (!numbers_.integer(property.count_type, number)) {
            return fail(property, "expected the length of a list, found " + numbers_.found(property.count_type));
        }
        count = static_cast<std::uint64_t>(number);
        if (number < 0 || count > numbers_.most_left(property.type)) {
            numbers_ = before;
            return fail(property, number < 0 ? "a list of " + std::to_string(number) + " numbers"
                                             : "the file ends within its list of " + std::to_string(number) + " numbers");
        }
        return true;
    }

    bool skip_property(const PlyProperty& property) {
        std::uint64_t count = 1;
        return (!property.is_list || list_count(property, count)) &&
               (numbers_.skip(property.type, count) || no_number(property));
    }

    bool index_list(const PlyProperty& property, std::uint64_t vertex_count, std::vector<std::uint32_t>& list) {
        std::uint64_t count = 0;
        if (!list_count(property, count)) {
            return false;
        }
        list.resize(count);
        for (std::uint32_t& index : list) {
            numbers_.go_to_next();
            const Numbers before = numbers_;
            std::int64_t number = 0;
            if (!numbers_.integer(property.type, number)) {
                return fail(property, "expected an index, found " + numbers_.found(property.type));
            }
            const bool ends_strip = number == -1 && element_.role == PlyRole::strips;
            if (static_cast<std::uint64_t>(number) >= vertex_count && !ends_strip) {
                numbers_ = before;
                return fail(property, "index " + std::to_string(number) + ", but there are " + std::to_string(vertex_count) +
                                          " vertices");
            }
            index = static_cast<std::uint32_t>(number);
        }
        return true;
    }

    bool no_number(const PlyProperty& property) {
        return fail(property, "expected a finite number, found " + numbers_.found(property.type));
    }

    bool fail(const PlyProperty& property, const std::string& what) {
        at_ = numbers_.at();
        what_ = "property " + short_name(property.name) + " of " + short_name(element_.name) + " " + std::to_string(row_) +
                ": " + what;
        return false;
    }

    Numbers numbers_;
    const PlyElement& element_;
    std::uint64_t row_;
    const char* at_ = nullptr;
    std::string what_;
};

}  // namespace lamella
