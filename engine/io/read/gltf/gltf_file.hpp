// A glTF file (2.0) and the numbers in its buffers, checked to be there.
#pragma once

#include <map>

#include "io/read/gltf/json_tree.hpp"
#include "io/read/number_type.hpp"

namespace lamella {

/// What an accessor lists: points of three floats, or integers. All of it lies in memory.
struct GltfNumbers {
    const JsonNode* accessor = nullptr;
    std::uint64_t count = 0;
    NumberType type = NumberType::float32;
    const std::byte* first = nullptr;
    std::uint64_t stride = 0;  ///< in bytes

    std::uint64_t integer(std::uint64_t index) const noexcept;
};

class GltfFile {
public:
    /// Throws TextErrors and Refused.
    explicit GltfFile(FileContents& file);

    const JsonNode& root() const noexcept { return tree_.root(); }
    /// The item of a list of the file by its index. Throws TextErrors.
    const JsonNode& item(std::string_view list, const JsonNode& index) const;
    /// An integer; `otherwise` where it is absent. Throws TextErrors.
    std::uint64_t integer(const JsonNode& value, std::uint64_t otherwise = 0) const;
    /// The points or integers of the accessor of that index. Throws TextErrors and Refused.
    GltfNumbers numbers(const JsonNode& index, bool points);
    /// After the end of a binary file.
    std::uint64_t ignored_bytes() const noexcept { return ignored_bytes_; }
    [[noreturn]] void fail(const JsonNode& place, const std::string& what) const;

    FileSource& source;
    MemoryBudget budget;

private:
    std::string_view find_json();
    std::string_view chunk(std::size_t at, std::string_view kind) const;
    std::string_view buffer(const JsonNode& index);
    std::string_view load_buffer(const JsonNode& own, std::uint64_t bytes);

    std::string_view whole_;
    bool is_binary_ = false;
    std::string_view chunk_;  // the second one of a binary file
    std::uint64_t ignored_bytes_ = 0;
    JsonTree tree_;
    std::map<const JsonNode*, std::string_view> buffers_;
    std::deque<Array<std::byte>> loaded_;
};

}  // namespace lamella
