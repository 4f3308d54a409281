// XML as a stream of elements and text. Nothing of the document is kept, so that its size does not matter. A document type
// declaration is refused: with it go entities, internal and external, and every way to make a short file long.
#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

struct XML_ParserStruct;

namespace lamella {

/// True if `text` is plain text at any place of an XML document: ASCII, with no character that markup consists of.
bool is_plain_xml_text(std::string_view text) noexcept;

/// A name with its namespace: of elements always, of attributes only where they carry a prefix.
struct XmlName {
    std::string_view space;  ///< the namespace's address, or empty
    std::string_view local;
    friend bool operator==(const XmlName&, const XmlName&) = default;
};

/// A name as it is written: "prefix:local" or "local".
struct XmlWrittenName {
    std::string_view prefix;
    std::string_view local;
};
XmlWrittenName split_name(std::string_view name) noexcept;

/// The namespaces that the open elements declare. They are resolved here and not by expat, which ends the document at a
/// prefix that is not declared.
class XmlNamespaces {
public:
    /// Declares one of the next element, which is at `depth`. False: more are declared than any real file needs.
    bool declare(std::string_view prefix, std::string_view space, std::uint64_t depth);
    /// Forgets what elements at `depth` declared.
    void close(std::uint64_t depth) noexcept;

    /// The namespace of that prefix, empty where it is the empty one; nothing if it is not declared.
    std::optional<std::string_view> find(std::string_view prefix) const noexcept;
    /// An element's name. One whose prefix is not declared keeps it in its name and has no namespace.
    XmlName element(std::string_view name) const noexcept;

private:
    struct Binding {
        std::string prefix;
        std::string space;
        std::uint64_t depth;
    };
    std::vector<Binding> bindings_;  // of outer elements first
    std::size_t bytes_ = 0;
};

/// The attributes of an element, as long as its event lasts.
class XmlAttributes {
public:
    XmlAttributes(const char* const* names_and_values, const XmlNamespaces& namespaces) noexcept
        : list_(names_and_values), namespaces_(namespaces) {}

    /// The value of the attribute of that name, entities and white space resolved.
    std::optional<std::string_view> find(const XmlName& name) const noexcept;
    std::optional<std::string_view> find(std::string_view local) const noexcept { return find(XmlName{{}, local}); }

    /// The first attribute whose prefix is not declared, as it is written, of those with that local name or, without one, of
    /// all. Empty: there is none.
    std::string_view unbound(std::optional<std::string_view> local = std::nullopt) const noexcept;

private:
    const char* const* list_;  // name, value, name, value, ..., null
    const XmlNamespaces& namespaces_;
};

/// Where parsing ended before the document did, and why.
struct XmlFailure {
    std::uint64_t line = 0;    ///< from 1
    std::uint64_t offset = 0;  ///< in bytes
    std::string what;
};

/// A name whose prefix no element declares.
struct XmlUnboundName {
    std::uint64_t line = 0;    ///< from 1
    std::uint64_t offset = 0;  ///< in bytes, of its tag
    std::string name;          ///< with the prefix

    /// For a warning: "ignored 'a:b', as its prefix is not declared".
    std::string words() const;
};

/// A parser of one document; readers of formats derive from it. Elements deeper, tags and comments longer and names and
/// namespaces more than any real file has are refused: expat keeps all that is open and every name, and reads what is cut in
/// two from its begin again.
class XmlReader {
public:
    /// Throws std::bad_alloc.
    XmlReader();
    virtual ~XmlReader();
    XmlReader(const XmlReader&) = delete;
    XmlReader& operator=(const XmlReader&) = delete;

    /// Parses what comes next. False: no more is wanted, because of a failure() or of a stop(). Throws what an event throws.
    bool feed(std::string_view bytes);
    /// Skips what comes next without parsing it. Its bytes count for offsets, and `lines` for lines. Precondition: all
    /// before it has been parsed, and parsing it too could only succeed and would change nothing that is open.
    void skip(std::string_view plain, std::uint64_t lines = 0) noexcept {
        skipped_bytes_ += plain.size();
        skipped_lines_ += lines;
    }
    /// Ends the document. False: a failure() or a stop().
    bool finish();

    const std::optional<XmlFailure>& failure() const noexcept { return failure_; }
    /// The first such name. Elements of one have no namespace, attributes of one are not found.
    const std::optional<XmlUnboundName>& unbound_name() const noexcept { return unbound_name_; }

    static constexpr std::uint64_t most_open_elements = 1000;
    static constexpr std::size_t longest_tag_bytes = std::size_t{4} << 20;  ///< or comment

protected:
    // The events. They may throw, by fail() too, or call stop(), after which no other event comes.
    virtual void begin_element(const XmlName& name, const XmlAttributes& attributes) = 0;
    virtual void end_element(const XmlName& /*name*/) {}
    /// A piece of the text between tags; a line of it may come in many.
    virtual void text(std::string_view /*piece*/) {}

    /// The namespace of a prefix that the current element or one around it declares; nothing if none does.
    std::optional<std::string_view> namespace_of(std::string_view prefix) const noexcept { return namespaces_.find(prefix); }

    /// Ends parsing with a failure at the event at hand.
    [[noreturn]] void fail(std::string what) const { throw XmlFailure{event_line(), event_offset(), std::move(what)}; }
    /// Ends parsing without one.
    void stop();

    /// Where in the document the current tag or text is: its line, from 1, and the bytes where it begins and ends.
    std::uint64_t event_line() const noexcept;
    std::uint64_t event_offset() const noexcept;
    std::uint64_t event_end() const noexcept;

private:
    struct ParserDeleter {
        void operator()(XML_ParserStruct* parser) const noexcept;
    };

    template <class Event>
    void deliver(Event&& event) noexcept;
    static XmlReader& self(void* user) noexcept { return *static_cast<XmlReader*>(user); }
    void begin(std::string_view name, const char* const* attributes);
    void end(std::string_view name);
    /// False: there are more than any real file has. expat keeps each as long as it lives.
    bool note_name(std::string_view name);
    void note_unbound(std::string_view element, const XmlAttributes& attributes);
    bool parse(std::string_view bytes, bool last);
    void end_by(XmlFailure failure);

    std::unique_ptr<XML_ParserStruct, ParserDeleter> parser_;  // expat.h stays out of the other readers
    std::uint64_t parsed_bytes_ = 0;
    std::set<std::string, std::less<>> names_;
    std::size_t name_bytes_ = 0;
    std::size_t open_name_bytes_ = 0;  // of the elements that are open
    XmlNamespaces namespaces_;
    std::uint64_t depth_ = 0;  // of open elements
    std::optional<XmlUnboundName> unbound_name_;
    std::uint64_t skipped_bytes_ = 0;
    std::uint64_t skipped_lines_ = 0;
    bool stopped_ = false;
    std::optional<XmlFailure> failure_;
    std::exception_ptr thrown_;  // by an event: exceptions must not pass through expat, which is C
};

}  // namespace lamella
