#include <set>
#include <string>

#include <catch2/catch.hpp>

#include "lamella/io/name_text.hpp"

using namespace lamella;

TEST_CASE("names: any bytes become UTF-8 and come back", "[write]") {
    CHECK(text_of_name("l\xe4rm.stl") == "l\\xe4rm.stl");
    CHECK(text_of_name("l\xc3\xa4rm\\a.stl") == "l\xc3\xa4rm\\a.stl");
    CHECK(text_of_name("\\xe4") == "\\x5cxe4");
    CHECK(text_of_name("\\x5cxe4") == "\\x5cx5cxe4");
    CHECK(name_of_text("\\x41\\xE4\\xg0\\x5") == "\\x41\xe4\\xg0\\x5");
    const std::string parts[] = {"\\", "x", "e4", "5c", "\xe4", "\xc3\xa4", "4", "\xff", "-"};
    std::set<std::string> texts;
    std::set<std::string> names;
    for (int code = 0; code < 9 * 9 * 9 * 9; ++code) {
        const std::string name = parts[code % 9] + parts[code / 9 % 9] + parts[code / 81 % 9] + parts[code / 729];
        const std::string text = text_of_name(name);
        REQUIRE(name_of_text(text) == name);
        REQUIRE(utf8_text(text) == text);
        names.insert(name);
        texts.insert(text);
    }
    CHECK(texts.size() == names.size());
    CHECK(printable("a\n\xff\x7f\xc3\xa4") == "a?\\xff?\xc3\xa4");
}
