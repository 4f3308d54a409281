// All of an archive but its columns: numbers and words, which lie in it as attributes of groups.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include <hdf5.h>

#include "io/read/input_file.hpp"
#include "lamella/medical/archive.hpp"

namespace lamella {

using FactValue = std::variant<std::string, std::vector<double>, std::vector<std::uint64_t>>;

struct Fact {
    std::string group;  ///< path, "/" first
    std::string name;
    FactValue value;
    friend bool operator==(const Fact&, const Fact&) = default;
};

/// An attribute of more numbers does not lie in the header of its group.
inline constexpr std::uint64_t most_uneven_slices = 8000;

/// Those that are the same in all parts of a slicing.
std::vector<Fact> facts_of(const SliceResult& result, const ArchiveInfo& info);

/// The attributes of an open archive. Throws Refused, with file and place, where one is missing or not as it should be.
class Attributes {
public:
    Attributes(const InputFile& file, hid_t tree) : file_(file), tree_(tree) {}
    bool has(const std::string& object, const std::string& name) const;
    std::string text(const std::string& object, const std::string& name) const;
    /// `count` of them.
    std::vector<double> doubles(const std::string& object, const std::string& name, std::size_t count) const;
    std::uint64_t whole(const std::string& object, const std::string& name) const;
    /// The attribute is there, but cannot be.
    [[noreturn]] void refuse(const std::string& object, const std::string& name) const;

private:
    template <class Number>
    std::vector<Number> numbers(const std::string& object, const std::string& name, std::size_t count) const;

    const InputFile& file_;
    hid_t tree_;
};

/// Sets what facts_of() takes, and checks each; heights and changes of the fill rule stand in columns. Throws Refused.
void read_facts(const Attributes& attributes, SliceResult& result, ArchiveInfo& info);

}  // namespace lamella
