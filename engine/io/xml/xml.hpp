// XML as a stream of elements and text. Nothing of the document is kept, so that its size does not matter. A document type
// declaration is refused, or skipped where it declares nothing itself: with it go entities, internal and external, and every
// way to make a short file long.
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

/// A name with its namespace: of elements always, of attributes only where they carry a prefix.
struct XmlName {
    std::string_view space;  ///< the namespace's address, or empty
    std::string_view local;
    friend bool operator==(const XmlName&, const XmlName&) = default;
};

class XmlReader;

/// The attributes of an element, as long as its event lasts.
class XmlAttributes {
public:
    XmlAttributes(const char* const* names_and_values, const XmlReader& reader) noexcept
        : list_(names_and_values), reader_(reader) {}

    /// The value of the attribute of that name, entities and white space resolved.
    std::optional<std::string_view> find(const XmlName& name) const noexcept;
    std::optional<std::string_view> find(std::string_view local) const noexcept { return find(XmlName{{}, local}); }

    /// The first attribute whose prefix is not declared, as it is written, of those with that local name or, without one, of
    /// all. Empty: there is none.
    std::string_view unbound(std::optional<std::string_view> local = std::nullopt) const noexcept;

private:
    const char* const* list_;  // name, value, name, value, ..., null
    const XmlReader& reader_;  // which knows the namespaces
};

/// What is wrong in a document, and where.
struct XmlFault {
    std::uint64_t line = 0;    ///< from 1
    std::uint64_t offset = 0;  ///< in bytes
    std::string what;
};

/// A parser of one document; readers of formats derive from it. Elements deeper, tags and comments longer and names and
/// namespaces more than any real file has are refused: expat keeps all that is open and every name, and reads what is cut in
/// two from its begin again.
class XmlReader {
public:
    /// A document type that only names a file, which is never read, may be allowed. Throws std::bad_alloc.
    explicit XmlReader(bool may_name_type = false);
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

    /// Why parsing ended before the document did.
    const std::optional<XmlFault>& failure() const noexcept { return failure_; }
    /// The first name whose prefix no element declares, as a warning: "ignored 'a:b', as its prefix is not declared".
    /// Elements of such a name have no namespace, attributes are not found.
    const std::optional<XmlFault>& unbound_name() const noexcept { return unbound_name_; }

    /// The namespace of a prefix that an open element declares, empty where it is the empty one; nothing if none does. They
    /// are resolved here and not by expat, which ends the document at a prefix that is not declared.
    std::optional<std::string_view> namespace_of(std::string_view prefix) const noexcept;

    static constexpr std::size_t most_kept_bytes = std::size_t{1} << 20;    ///< of names, and so counted
    static constexpr std::size_t longest_tag_bytes = std::size_t{4} << 20;  ///< or comment

protected:
    // The events. They may throw, by fail() too, or call stop(), after which no other event comes.
    virtual void begin_element(const XmlName& name, const XmlAttributes& attributes) = 0;
    virtual void end_element(const XmlName& /*name*/) {}
    /// A piece of the text between tags; a line of it may come in many.
    virtual void text(std::string_view /*piece*/) {}

    /// Ends parsing with a failure at the event at hand.
    [[noreturn]] void fail(std::string what) const { throw XmlFault{event_line(), event_offset(), std::move(what)}; }
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
    /// An element's name. One whose prefix is not declared keeps it in its name and has no namespace.
    XmlName element(std::string_view name) const noexcept;
    /// Counts what is kept of a document. False: more than of any real one.
    bool keep(std::size_t bytes) noexcept { return (kept_bytes_ += bytes) <= most_kept_bytes; }
    bool keep_name(std::string_view name);
    void note_unbound(std::string_view element, const XmlAttributes& attributes);
    bool parse(std::string_view bytes, bool last);
    void end_by(XmlFault failure);

    struct Binding {
        std::string prefix;
        std::string space;
        std::uint64_t depth;
        std::size_t bytes() const noexcept;
    };

    std::unique_ptr<XML_ParserStruct, ParserDeleter> parser_;  // expat.h stays out of the other readers
    std::uint64_t parsed_bytes_ = 0;
    std::set<std::string, std::less<>> names_;  // expat keeps each as long as it lives
    std::vector<Binding> bindings_;             // of outer elements first
    std::size_t kept_bytes_ = 0;
    std::uint64_t depth_ = 0;  // of open elements
    std::optional<XmlFault> unbound_name_;
    std::uint64_t skipped_bytes_ = 0;
    std::uint64_t skipped_lines_ = 0;
    bool may_name_type_;
    bool stopped_ = false;
    std::optional<XmlFault> failure_;
    std::exception_ptr thrown_;  // by an event: exceptions must not pass through expat, which is C
};

}  // namespace lamella
