// All of an archive but its columns: numbers and words, which lie in it as attributes of groups.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

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

/// What is the same in all parts of a slicing.
std::vector<Fact> facts_of(const SliceResult& result, const ArchiveInfo& info);

/// Facts that lie in a file.
class FactReader {
public:
    virtual bool has(const std::string& group, const std::string& name) = 0;
    /// So many numbers, or a text, in `value`, whose kind is the one looked for. Throws Refused.
    virtual void read(const std::string& group, const std::string& name, std::size_t count, FactValue& value) = 0;
    /// The fact is there, but cannot be.
    [[noreturn]] virtual void refuse(const std::string& group, const std::string& name) = 0;

protected:
    ~FactReader() = default;
};

/// Sets what facts_of() takes, and checks each. Heights and changes of the fill rule have their number only. Throws Refused.
void read_facts(FactReader& reader, SliceResult& result, ArchiveInfo& info);

}  // namespace lamella
