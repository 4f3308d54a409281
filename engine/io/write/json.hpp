// JSON as text, written as it goes: numbers and strings by the library, one at a time. Its tree of values takes memory to be
// destroyed, which ends the process where there is none left; this fails by std::bad_alloc.
#pragma once

#include <concepts>
#include <cstddef>
#include <string>
#include <string_view>

#include "lamella/io/report.hpp"

namespace lamella {

/// Indented by two. Members and values come in the order in which they are written. Every call throws std::bad_alloc.
class JsonText {
public:
    /// {...}: `members` writes them by member(), object() and list().
    template <class Members>
    void object(Members&& members) {
        nest('{', '}', members);
    }
    template <class Members>
    void object(std::string_view name, Members&& members) {
        key(name);
        object(members);
    }

    /// [...]: the first `most` of `items`, each by one value() or object() of item(it).
    template <class Items, class Item>
    void list(std::string_view name, const Items& items, std::size_t most, Item&& item) {
        key(name);
        nest('[', ']', [&] {
            std::size_t left = most;
            for (const auto& one : items) {
                if (left-- == 0) {
                    break;
                }
                item(one);
            }
        });
    }
    /// The same, each item an object of members(it).
    template <class Items, class Members>
    void objects(std::string_view name, const Items& items, std::size_t most, Members&& members) {
        list(name, items, most, [&](const auto& item) { object([&] { members(item); }); });
    }
    template <class T>
    void member(std::string_view name, const T& content) {
        key(name);
        value(content);
    }
    /// null unless `known`.
    template <class T>
    void member_if(bool known, std::string_view name, const T& content) {
        key(name);
        known ? value(content) : value(nullptr);
    }

    void value(std::nullptr_t) { put("null"); }
    /// Shortest text that reads back the same, with a point or an exponent; null if not finite.
    void value(double number);
    /// As utf8_text(): file names may hold bytes that are not UTF-8.
    void value(std::string_view text);
    void value(const std::string& text) { value(std::string_view(text)); }
    void value(const char* text) { value(std::string_view(text)); }
    template <std::same_as<bool> T>
    void value(T truth) {
        put(truth ? "true" : "false");
    }
    template <std::integral T>
    requires(!std::same_as<T, bool>) void value(T number) { put(std::to_string(number)); }
    /// A list of all.
    template <class Items>
    requires requires(const Items& items) {
        items.front();
    } &&(!std::convertible_to<Items, std::string_view>)void value(const Items& items) {
        nest('[', ']', [&] {
            for (const auto& item : items) {
                value(item);
            }
        });
    }

    /// All that was written, with a final newline.
    std::string take() && { return std::move(text_ += '\n'); }

private:
    template <class Content>
    void nest(char open, char close, Content&& content) {
        put({&open, 1});
        const std::size_t begin = text_.size();
        ++depth_;
        content();
        --depth_;
        if (text_.size() != begin) {
            break_line();
        }
        text_ += close;
    }

    void break_line() { text_.append(1, '\n').append(2 * depth_, ' '); }
    void key(std::string_view name);
    void put(std::string_view word);

    std::string text_;
    std::size_t depth_ = 0;
    bool after_key_ = false;
};

// Members of every report: the mesh file, and what the program adds.

/// The program's members that belong in `place`.
void write_members(JsonText& json, const ReportParts& parts, ReportPlace place);

/// "mesh", then "file" if there is one.
void write_mesh(JsonText& json, const ReportParts& parts);

/// The member "box_mm".
void write_box(JsonText& json, const Box& box);

}  // namespace lamella
