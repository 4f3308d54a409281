// The XML stream: the same events however the text is cut, and no way to make it take memory or time.
#include <stdexcept>

#include <catch2/catch.hpp>

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

/// The events of `text` fed in pieces of `piece` bytes.
std::string events_of(const std::string& text, std::size_t piece) {
    Recorder recorder;
    bool wanted = true;
    for (std::size_t at = 0; wanted && at < text.size(); at += piece) {
        wanted = recorder.feed(std::string_view(text).substr(at, piece));
    }
    const bool whole = wanted && recorder.finish();
    CHECK(whole != recorder.failure().has_value());
    if (recorder.failure()) {
        const XmlFailure& failure = *recorder.failure();
        return recorder.events + "!" + std::to_string(failure.line) + " " + failure.what;
    }
    return recorder.events;
}

TEST_CASE("XML gives the same events however it is cut", "[input][xml]") {
    const std::string text =
        "<?xml version='1.0'?>\n<!-- a -->\r\n<a xmlns='urn:a' xmlns:p='urn:p' x=' 1\n&lt;' p:x='2'>t&amp;&#66;\r"
        "<p:b/><![CDATA[<c>]]><d xmlns=''><e x=\"3\"/></d></a>\n";
    for (std::size_t piece = 1; piece <= text.size(); ++piece) {
        CHECK(events_of(text, piece) ==
              "<urn:a:a :x= 1 < urn:p:x=2 3 34..87>t&B\n<urn:p:b 5 99..105></b><c>"
              "<:d 5 120..132><:e :x=3 5 132..142></e></d></a>");
    }
}

TEST_CASE("malformed XML is reported with its line", "[input][xml]") {
    CHECK(events_of("", 1) == "!1 malformed XML: no element found");
    CHECK(events_of("<a>\n</b>", 3) == "<:a 1 0..3>!2 malformed XML: mismatched tag");
    CHECK(events_of("<a>\r\r\n", 1) == "<:a 1 0..3>!3 malformed XML: no element found");
    CHECK(events_of("<a x='1' x='2'/>", 1) == "!1 malformed XML: duplicate attribute");
    CHECK(events_of("<a>\n<fail/></a>", 1) == "<:a 1 0..3>\n<:fail 2 4..11>!2 failed");
    CHECK(events_of("<!DOCTYPE a><a/>", 1) == "!1 a document type declaration, which is refused");
    CHECK(events_of("<a>&b;</a>", 1) == "<:a 1 0..3>!1 malformed XML: undefined entity");
}

TEST_CASE("an XML prefix that is not declared is noted, and parsing goes on", "[input][xml]") {
    const auto unbound_in = [](const std::string& text, const std::string& events) {
        Recorder recorder;
        CHECK(recorder.feed(text));
        CHECK(recorder.finish());
        CHECK(recorder.events == events);
        const std::optional<XmlUnboundName>& name = recorder.unbound_name();
        return name ? std::to_string(name->line) + " " + std::to_string(name->offset) + " " + name->name : "none";
    };
    CHECK(unbound_in("<p:a/>", "<:p:a 1 0..6></p:a>") == "1 0 p:a");
    CHECK(unbound_in("<a>\n<b x='1' p:x='2'/><q:c/></a>", "<:a 1 0..3>\n<:b :x=1 2 4..22></b><:q:c 2 22..28></q:c></a>") ==
          "2 4 p:x");
    CHECK(unbound_in("<a xml:x='1'/>", "<:a 1 0..14></a>") == "none");
    CHECK(unbound_in("<a><b xmlns:p='urn:p'/><c p:x='1'/></a>", "<:a 1 0..3><:b 1 3..23></b><:c 1 23..35></c></a>") ==
          "1 23 p:x");
    CHECK(unbound_in("<a xmlns:p='urn:p'><b xmlns:p='' p:x='1'/><p:c/></a>",
                     "<:a 1 0..19><:b 1 19..42></b><urn:p:c 1 42..48></c></a>") == "1 19 p:x");
}

constexpr const char* not_real = "elements too deep, names too many or a tag too long to be real";

TEST_CASE("XML that declares more namespaces than any real file is refused", "[input][xml]") {
    const auto refused = [](int count, std::size_t length, bool nested) {
        std::string text = "<a";
        for (int i = 0; i < count; ++i) {
            text +=
                (nested && i > 0 ? "><a" : "") + (" xmlns:p" + std::to_string(i) + "='") + std::string(length, 'x') + "'";
        }
        Recorder recorder;
        return !recorder.feed(text + ">") && recorder.failure()->what == not_real;
    };
    for (const bool nested : {false, true}) {
        CHECK_FALSE(refused(256, 10, nested));
        CHECK(refused(257, 10, nested));
        CHECK_FALSE(refused(10, 6000, nested));
        CHECK(refused(11, 6000, nested));
    }
    Recorder recorder;
    CHECK(recorder.feed("<a>"));
    for (int i = 0; i < 1000; ++i) {
        CHECK(recorder.feed("<b xmlns:p='urn:p'/>"));
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

TEST_CASE("XML that is deeper, has longer tags or more names than any real file is refused", "[input][xml]") {
    const auto answer = [](const std::string& before, std::size_t count, const auto& piece) {
        Recorder recorder;
        bool wanted = recorder.feed(before);
        for (std::size_t i = 0; wanted && i < count; ++i) {
            wanted = recorder.feed(piece(i));
            recorder.events.clear();
        }
        return recorder.failure() ? recorder.failure()->what : "read";
    };
    const auto again = [](const std::string& text) { return [text](std::size_t) { return text; }; };
    const auto long_text = again(std::string(XmlReader::longest_tag_bytes / 8, 'x'));
    CHECK(answer("", XmlReader::most_open_elements, again("<a>")) == "read");
    CHECK(answer("", XmlReader::most_open_elements + 1, again("<a>")) == not_real);
    for (const std::string begin : {"<a x='", "<!--", "<a><!--", "<?a "}) {
        CHECK(answer(begin, 7, long_text) == "read");
        CHECK(answer(begin, 8, long_text) == not_real);
    }
    CHECK(answer("<a>", 80, long_text) == "read");
    CHECK(answer("<a>", 200'000, again("<b/>")) == "read");
    CHECK(answer("<a>", 1'000'000, [](std::size_t i) { return "<a" + std::to_string(i) + "/>"; }) == not_real);
}

TEST_CASE("XML text is plain if it is ASCII without characters of markup", "[input][xml]") {
    for (int code = 0; code < 256; ++code) {
        const char c = static_cast<char>(code);
        const bool white = c == '\t' || c == '\n' || c == '\r';
        const bool plain = white || (code >= ' ' && code <= '~' && c != '<' && c != '&' && c != ']');
        for (const std::size_t at : {0U, 7U, 40U}) {
            std::string text(41, '1');
            text[at] = c;
            INFO(code << " at " << at);
            CHECK(is_plain_xml_text(text) == plain);
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

}  // namespace
}  // namespace lamella
