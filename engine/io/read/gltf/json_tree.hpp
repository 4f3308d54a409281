// The values of a JSON text, each with its place there.
#pragma once

#include <deque>
#include <string>
#include <string_view>
#include <vector>

#include "io/read/reader.hpp"

namespace lamella {

struct JsonNode {
    enum class Kind : std::uint8_t { absent, other, number, text, list, object };

    explicit operator bool() const noexcept { return kind != Kind::absent; }
    /// The member of that name; one that is absent has nothing in it, and neither number nor text. O(log).
    const JsonNode& operator[](std::string_view name) const noexcept;

    Kind kind = Kind::absent;
    const char* at = nullptr;  ///< in the file
    std::string_view key{};    ///< of a member
    std::string_view text{};
    double number = 0;
    std::vector<JsonNode> items{};  ///< of a list, or members by ascending keys
};

class JsonTree {
public:
    /// Throws TextErrors, and Refused where it takes more than the budget.
    JsonTree(std::string_view text, MemoryBudget& budget, const Parallel& parallel);

    const JsonNode& root() const noexcept { return root_; }

private:
    JsonNode root_;
    std::deque<std::string> unescaped_;  // texts that stand otherwise in the file
};

}  // namespace lamella
