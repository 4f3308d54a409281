#include "io/read/gltf/json_tree.hpp"

#include <nlohmann/json.hpp>

namespace lamella {

namespace {

/// Where the parser is.
struct JsonCursor {
    const char* begin;
    const char* end;
    StopPace pace;
    const char* p = begin;
};

struct JsonBytes {
    using iterator_category = std::input_iterator_tag;
    using value_type = char;
    using difference_type = std::ptrdiff_t;
    using pointer = const char*;
    using reference = const char&;

    JsonCursor* cursor;  ///< null: the end of any
    const char& operator*() const noexcept { return *cursor->p; }
    JsonBytes& operator++() {
        cursor->pace.spend(1);
        ++cursor->p;
        return *this;
    }
    bool operator==(const JsonBytes&) const noexcept { return cursor->p == cursor->end; }
};

/// Takes the events of the parser, whose own tree of values needs memory to be destroyed.
class JsonBuilder : public nlohmann::json_sax<nlohmann::json> {
public:
    JsonBuilder(JsonCursor& cursor, MemoryBudget& budget, JsonNode& root, std::deque<std::string>& unescaped)
        : cursor_(cursor), budget_(budget), root_(root), unescaped_(unescaped) {}

    bool null() override { return add({.kind = JsonNode::Kind::other}); }
    bool boolean(bool /*value*/) override { return null(); }
    bool number_integer(std::int64_t value) override { return number_float(static_cast<double>(value), {}); }
    bool number_unsigned(std::uint64_t value) override { return number_float(static_cast<double>(value), {}); }
    bool number_float(double value, const std::string& /*text*/) override {
        return add({.kind = JsonNode::Kind::number, .number = value});
    }
    bool string(std::string& value) override { return add({.kind = JsonNode::Kind::text, .text = kept(value)}); }
    bool binary(nlohmann::json::binary_t& /*value*/) override { return false; }
    bool start_object(std::size_t /*count*/) override { return open(JsonNode::Kind::object); }
    bool start_array(std::size_t /*count*/) override { return open(JsonNode::Kind::list); }
    bool end_object() override {
        std::vector<JsonNode>& members = open_.back()->items;
        std::stable_sort(members.begin(), members.end(), [](auto& a, auto& b) { return a.key < b.key; });
        return end_array();
    }
    bool end_array() override {
        open_.pop_back();
        return true;
    }
    bool key(std::string& name) override {
        key_ = kept(name);
        return true;
    }
    bool parse_error(std::size_t /*position*/, const std::string& token, const nlohmann::json::exception& /*why*/) override {
        fail(cursor_.p == cursor_.end ? "is truncated: its JSON ends too early" : "malformed JSON near " + in_quotes(token));
    }

private:
    [[noreturn]] void fail(const std::string& what) const { throw TextError{cursor_.p, what}; }

    bool add(JsonNode node) {
        budget_.take(1, 2 * sizeof(JsonNode));  // lists grow by copying
        node.at = cursor_.p - 1;
        node.key = std::exchange(key_, {});
        (open_.empty() ? root_ : open_.back()->items.emplace_back()) = std::move(node);
        return true;
    }
    bool open(JsonNode::Kind kind) {
        constexpr std::size_t deepest = 128;
        if (open_.size() == deepest) {
            fail("nests JSON too deep to be real");
        }
        add({.kind = kind});
        open_.push_back(open_.empty() ? &root_ : &open_.back()->items.back());
        return true;
    }

    /// The text that has just been read, where it stands in the file if it stands there as it is.
    std::string_view kept(std::string& text) {
        const char* const end = cursor_.p - 1;  // before the quote
        if (std::string_view(cursor_.begin, static_cast<std::size_t>(end - cursor_.begin)).ends_with(text)) {
            return {end - text.size(), text.size()};
        }
        budget_.take(2 * text.size(), 1);
        return unescaped_.emplace_back(std::move(text));
    }

    JsonCursor& cursor_;
    MemoryBudget& budget_;
    JsonNode& root_;
    std::deque<std::string>& unescaped_;
    std::vector<JsonNode*> open_;  // lists and objects
    std::string_view key_;
};

}  // namespace

const JsonNode& JsonNode::operator[](std::string_view name) const noexcept {
    static const JsonNode absent;
    const auto found =
        std::lower_bound(items.begin(), items.end(), name, [](auto& item, auto& key) { return item.key < key; });
    return kind == Kind::object && found != items.end() && found->key == name ? *found : absent;
}

JsonTree::JsonTree(std::string_view text, MemoryBudget& budget, const Parallel& parallel) {
    JsonCursor cursor{text.data(), text.data() + text.size(), pace_of(parallel)};
    budget.take(text.size(), 3);  // the parser copies a text twice, in memory that grows
    JsonBuilder builder(cursor, budget, root_, unescaped_);
    nlohmann::json::sax_parse(JsonBytes{&cursor}, JsonBytes{nullptr}, &builder);
    budget.give_back(3 * text.size());
}

}  // namespace lamella
