// The XML stream: the same events however the text is cut, and no way to make it take memory or time. And the plain text of
// other formats by the eight characters: the same as one by one, wherever it ends.
#include <charconv>
#include <stdexcept>

#include <catch2/catch.hpp>

#include "io/text/text.hpp"
#include "io/xml/xml.hpp"

namespace lamella {
namespace {

/// Writes its events down, and fails, stops or throws at elements of that name.
class Recorder : public XmlReader {
public:
    std::string events;

private:
    void begin_element(const XmlName& name, const XmlAttributes& attributes) override {
        end_text();
        events += "<" + std::string(name.space) + ":" + std::string(name.local);
        for (const XmlName& known : {XmlName{"", "x"}, XmlName{"urn:p", "x"}}) {
            if (const auto value = attributes.find(known)) {
                events += " " + std::string(known.space) + ":x=" + std::string(*value);
            }
        }
        events += " " + std::to_string(event_line()) + " " + std::to_string(event_offset()) + ".." +
                  std::to_string(event_end()) + ">";
        if (name.local == "fail") {
            fail("failed");
        } else if (name.local == "stop") {
            stop();
        } else if (name.local == "throw") {
            throw std::runtime_error("thrown");
        }
    }
    void end_element(const XmlName& name) override {
        end_text();
        events += "</" + std::string(name.local) + ">";
    }
    void text(std::string_view piece) override { text_ += piece; }
    void end_text() {
        events += text_;
        text_.clear();
    }

    std::string text_;
};

/// The events of `text` fed in pieces of `piece` bytes; then "!", line and message of a failure, or "?", line, offset and
/// the warning of the first name whose prefix is not declared.
std::string events_of(const std::string& text, std::size_t piece) {
    Recorder recorder;
    bool wanted = true;
    for (std::size_t at = 0; wanted && at < text.size(); at += piece) {
        wanted = recorder.feed(std::string_view(text).substr(at, piece));
    }
    const bool whole = wanted && recorder.finish();
    CHECK(whole != recorder.failure().has_value());
    if (const auto& failure = recorder.failure()) {
        return recorder.events + "!" + std::to_string(failure->line) + " " + failure->what;
    }
    const auto& name = recorder.unbound_name();
    return recorder.events +
           (name ? "?" + std::to_string(name->line) + " " + std::to_string(name->offset) + " " + name->what : "");
}

TEST_CASE("XML gives the same events however it is cut", "[input][xml]") {
    const std::pair<std::string, std::string> cases[] = {
        {"<?xml version='1.0'?>\n<!-- a -->\r\n<a xmlns='urn:a' xmlns:p='urn:p' x=' 1\n&lt;' p:x='2'>t&amp;&#66;\r"
         "<p:b/><![CDATA[<c>]]><d xmlns=''><e x=\"3\"/></d></a>\n",
         "<urn:a:a :x= 1 < urn:p:x=2 3 34..87>t&B\n<urn:p:b 5 99..105></b><c>"
         "<:d 5 120..132><:e :x=3 5 132..142></e></d></a>"},
        {"", "!1 malformed XML: no element found"},
        {"<a>\n</b>", "<:a 1 0..3>!2 malformed XML: mismatched tag"},
        {"<a>\r\r\n", "<:a 1 0..3>!3 malformed XML: no element found"},
        {"<a x='1' x='2'/>", "!1 malformed XML: duplicate attribute"},
        {"<a>\n<fail/></a>", "<:a 1 0..3>\n<:fail 2 4..11>!2 failed"},
        {"<!DOCTYPE a><a/>", "!1 a document type declaration, which is refused"},
        {"<a>&b;</a>", "<:a 1 0..3>!1 malformed XML: undefined entity"},
        {"<p:a/>", "<:p:a 1 0..6></p:a>?1 0 ignored 'p:a', as its prefix is not declared"},
        {"<a>\n<b x='1' p:x='2'/><q:c/></a>",
         "<:a 1 0..3>\n<:b :x=1 2 4..22></b><:q:c 2 22..28></q:c></a>?2 4 ignored 'p:x', as its prefix is not declared"},
        {"<a xml:x='1'/>", "<:a 1 0..14></a>"},
        {"<a><b xmlns:p='urn:p'/><c p:x='1'/></a>",
         "<:a 1 0..3><:b 1 3..23></b><:c 1 23..35></c></a>?1 23 ignored 'p:x', as its prefix is not declared"},
        {"<a xmlns:p='urn:p'><b xmlns:p='' p:x='1'/><p:c/></a>",
         "<:a 1 0..19><:b 1 19..42></b><urn:p:c 1 42..48></c></a>?1 19 ignored 'p:x', as its prefix is not declared"}};
    for (const auto& [text, events] : cases) {
        for (std::size_t piece = 1; piece <= text.size() + 1; ++piece) {
            CHECK(events_of(text, piece) == events);
        }
    }
}

TEST_CASE("XML can be left before its end, and exceptions pass through the parser", "[input][xml]") {
    Recorder recorder;
    CHECK_FALSE(recorder.feed("<a><stop/>\x01 no XML at all"));
    CHECK(recorder.events == "<:a 1 0..3><:stop 1 3..10>");
    CHECK_FALSE(recorder.failure().has_value());
    CHECK_FALSE(recorder.feed("<"));
    CHECK_FALSE(recorder.finish());
    Recorder throwing;
    CHECK_THROWS_WITH(throwing.feed("<a><throw/><b/></a>"), "thrown");
    CHECK(throwing.events == "<:a 1 0..3><:throw 1 3..11>");
}

TEST_CASE("XML that is deeper, has longer tags, more names or namespaces than any real file is refused", "[input][xml]") {
    const auto is_refused = [](const std::string& before, std::size_t count, const auto& piece) {
        Recorder recorder;
        bool wanted = recorder.feed(before);
        for (std::size_t i = 0; wanted && i < count; ++i) {
            wanted = recorder.feed(piece(i));
            recorder.events.clear();
        }
        CHECK((!recorder.failure() ||
               recorder.failure()->what == "elements too deep, names too many or a tag too long to be real"));
        return recorder.failure().has_value();
    };
    const auto again = [](const std::string& text) { return [text](std::size_t) { return text; }; };
    const auto long_text = again(std::string(XmlReader::longest_tag_bytes / 8, 'x'));
    CHECK_FALSE(is_refused("", 1000, again("<a>")));
    CHECK(is_refused("", 1100, again("<a>")));
    // The parser keeps the name of each open element, equal ones too.
    const std::string long_name = "<" + std::string(std::size_t{300} << 10, 'n') + ">";
    CHECK_FALSE(is_refused("", 2, again(long_name)));
    CHECK(is_refused("", 3, again(long_name)));
    CHECK_FALSE(is_refused("<a>", 100, again(long_name + "</" + long_name.substr(1))));
    for (const std::string begin : {"<a x='", "<!--", "<a><!--", "<?a "}) {
        CHECK_FALSE(is_refused(begin, 7, long_text));
        CHECK(is_refused(begin, 8, long_text));
    }
    CHECK_FALSE(is_refused("<a>", 80, long_text));
    CHECK_FALSE(is_refused("<a>", 200'000, again("<b/>")));
    CHECK_FALSE(is_refused("<a>", 1000, again("<b xmlns:p='urn:p'/>")));
    CHECK(is_refused("<a>", 1'000'000, [](std::size_t i) { return "<a" + std::to_string(i) + "/>"; }));
    for (const std::string next : {" ", "><a "}) {  // in one element, and in nested ones
        for (const std::size_t length : {10U, 6000U}) {
            const std::size_t most = length == 10 ? 200 : 80;
            const auto closed = [&](std::size_t count) {
                return [&, count](std::size_t i) {
                    const std::string declaration = "xmlns:p" + std::to_string(i) + "='" + std::string(length, 'x') + "'";
                    return i == count ? ">" : (i > 0 ? next : "") + declaration;
                };
            };
            CHECK_FALSE(is_refused("<a ", most + 1, closed(most)));
            CHECK(is_refused("<a ", 2 * most, closed(2 * most - 1)));
        }
    }
}

TEST_CASE("events after skipped text have their place in the whole document", "[input][xml]") {
    const std::string before = "<a>\n<b>";
    const std::string plain = "\n1 2 3\n4\n";
    const std::string after = "</b>\n<c x=\"1\"/><fail/></a>";
    Recorder whole;
    CHECK_FALSE(whole.feed(before + plain + after));
    Recorder parts;
    CHECK(parts.feed(before));
    parts.skip(plain, 3);
    CHECK_FALSE(parts.feed(after));
    std::string expected = whole.events;
    expected.erase(expected.find(plain), plain.size());
    CHECK(parts.events == expected);
    REQUIRE(parts.failure());
    CHECK(parts.failure()->line == whole.failure()->line);
    CHECK(parts.failure()->offset == whole.failure()->offset);
}

// --- Text of other formats

TEST_CASE("digits are read up to the first other character, however many there are", "[input][text]") {
    const std::string digits = "9081726354091827364509182736";
    for (std::size_t count = 0; count <= digits.size(); ++count) {
        for (int next = 0; next < 256; ++next) {
            std::string text = digits.substr(0, count);
            const bool ends = is_digit(static_cast<char>(next));
            text += ends ? std::string() : static_cast<char>(next) + std::string("12345678");
            std::uint64_t number = 1;
            const char* const end = text.data() + text.size();
            CHECK(read_digits(text.data(), end, number) == text.data() + count);
            std::uint64_t exact = 0;
            std::from_chars(text.data(), text.data() + std::min<std::size_t>(count, 18), exact);
            CHECK((count <= 18 ? number == exact : number >= 1'000'000'000'000'000'000));
        }
    }
}

TEST_CASE("lines end at the first LF or CR", "[input][text]") {
    const std::string other = "\x0B\x0C \x8A\x8D\x09\x0E\xFF";  // one bit from a line end, or around it
    std::string line;
    for (std::size_t length = 0; length < 40; ++length) {
        for (const std::string end : {"", "\n", "\r", "\r\n", "\n\n", "\r\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n"}) {
            const std::string text = line + end;
            CHECK(skip_line(text.data(), text.data() + text.size()) == text.data() + length);
        }
        line += other[length % other.size()];
    }
}

}  // namespace
}  // namespace lamella
