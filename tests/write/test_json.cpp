// What reports are written with, read back by a library.
#include <limits>
#include <string>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "io/write/json.hpp"

using lamella::JsonText;
using nlohmann::json;

namespace {

template <class T>
std::string text_of(const T& value) {
    JsonText text;
    text.value(value);
    return std::move(text).take();
}

/// As JSON says it, and as the library reads it.
template <class T>
void check_value(const T& value, const std::string& expected) {
    CHECK(text_of(value) == expected + "\n");
    CHECK(json::parse(text_of(value)) == json::parse(expected));
}

}  // namespace

TEST_CASE("json: numbers and words", "[write][json]") {
    check_value(nullptr, "null");
    check_value(true, "true");
    check_value(false, "false");
    check_value(-3, "-3");
    check_value(std::numeric_limits<std::uint64_t>::max(), "18446744073709551615");
    check_value(std::numeric_limits<std::int64_t>::min(), "-9223372036854775808");
    check_value(0.0, "0.0");
    check_value(2.0, "2.0");
    check_value(-0.1, "-0.1");
    check_value(1e300, "1e+300");
    check_value(5e-324, "5e-324");
    check_value(std::numeric_limits<double>::infinity(), "null");
    check_value(std::numeric_limits<double>::quiet_NaN(), "null");
    check_value("word", "\"word\"");
    check_value(std::array{1.5, 2.0}, "[\n  1.5,\n  2.0\n]");
}

TEST_CASE("json: text is escaped, and always UTF-8", "[write][json]") {
    for (int c = 1; c < 0x80; ++c) {
        const std::string text = {'a', static_cast<char>(c), 'b'};
        CHECK(json::parse(text_of(text)) == text);
    }
    CHECK(json::parse(text_of(std::string_view("\0", 1))) == std::string(1, '\0'));
    for (const char* whole : {"\xc3\xa4", "\xe2\x82\xac", "\xf0\x9f\xa6\xb4", "\xed\x9f\xbf", "\xf4\x8f\xbf\xbf"}) {
        CHECK(json::parse(text_of(whole)) == whole);
    }
    CHECK(json::parse(text_of("a\xe2\x82")) == "a\\xe2\\x82");  // as utf8_text(), of which test_output_file tests more
    for (int first = 0x80; first < 0x100; ++first) {
        for (int second = 1; second < 0x100; ++second) {
            const std::string text = {static_cast<char>(first), static_cast<char>(second), '\x80', '\x80'};
            REQUIRE(json::accept(text_of(text)));
        }
    }
}

TEST_CASE("json: objects and lists nest, empty ones too", "[write][json]") {
    JsonText text;
    text.object([&] {
        text.member("a", 1);
        text.object("empty", [] {});
        text.member("none", std::vector<int>{});
        text.list("first", std::vector<int>{1, 2, 3}, 2, [&](int i) { text.object([&] { text.member("i", i); }); });
        text.member("all", std::vector<std::string>{"x", "[", "{"});
        text.member_if(false, "unknown", 5);
        text.member("last", std::array{std::array{1, 2}, std::array{3, 4}});
    });
    const std::string written = std::move(text).take();
    const auto expected = nlohmann::ordered_json::parse(
        R"({"a": 1, "empty": {}, "none": [], "first": [{"i": 1}, {"i": 2}], "all": ["x", "[", "{"], "unknown": null,
            "last": [[1, 2], [3, 4]]})");
    CHECK(written == expected.dump(2) + "\n");
}
