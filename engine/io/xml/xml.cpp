#include "io/xml/xml.hpp"

#include <expat.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <new>
#include <utility>

#include "io/read/input_file.hpp"
#include "lamella/memory.hpp"

namespace lamella {

namespace {

constexpr const char* unreal_names = "elements too deep, names too many or a tag too long to be real";

/// Bytes for one call of expat: its lengths are ints, and it copies tags that are cut in two.
constexpr std::size_t piece_bytes = std::size_t{1} << 20;

/// 1 for characters that may be markup or are not ASCII.
constexpr std::array<std::uint8_t, 256> is_other = [] {
    std::array<std::uint8_t, 256> table{};
    table.fill(1);
    for (unsigned char c = ' '; c <= '~'; ++c) {
        table[c] = c == '<' || c == '&' || c == ']' ? 1 : 0;
    }
    table['\t'] = table['\n'] = table['\r'] = 0;
    return table;
}();

/// The prefix that an attribute of that name declares; nothing if it declares none.
std::optional<std::string_view> declared_prefix(std::string_view name) {
    if (!name.starts_with("xmlns")) {
        return std::nullopt;
    }
    const std::string_view rest = name.substr(5);
    return rest.empty() ? std::optional(rest) : (rest[0] == ':' ? std::optional(rest.substr(1)) : std::nullopt);
}

XML_Parser as_parser(void* parser) {
    return static_cast<XML_Parser>(parser);
}

}  // namespace

// --- ParserMemory

/// What expat allocates, counted: it keeps every name that it has seen and a stack of open tags, both as the file likes.
class XmlReader::ParserMemory {
public:
    explicit ParserMemory(const Memory* memory) : memory_(memory) {}

    bool exhausted() const noexcept { return exhausted_; }

    /// While one of these lives, expat allocates from `memory` on this thread: its allocation functions take no context.
    class Scope {
    public:
        explicit Scope(ParserMemory& memory) noexcept : outer_(std::exchange(current_, &memory)) {}
        ~Scope() { current_ = outer_; }
        Scope(const Scope&) = delete;
        Scope& operator=(const Scope&) = delete;

    private:
        ParserMemory* outer_;
    };

    static const XML_Memory_Handling_Suite functions;

private:
    /// Before each block.
    struct alignas(std::max_align_t) Header {
        ParserMemory* owner;
        std::size_t bytes;  // of the block, and of this
    };

    static Header* header_of(void* block) noexcept { return static_cast<Header*>(block) - 1; }

    static void* allocate(std::size_t bytes) noexcept { return current_->take(bytes); }

    static void* reallocate(void* block, std::size_t bytes) noexcept {
        if (block == nullptr) {
            return allocate(bytes);
        }
        Header* const old = header_of(block);
        void* const fresh = old->owner->take(bytes);
        if (fresh != nullptr) {
            std::memcpy(fresh, block, std::min(bytes, old->bytes - sizeof(Header)));
            release(block);
        }
        return fresh;
    }

    static void release(void* block) noexcept {
        if (block != nullptr) {
            Header* const header = header_of(block);
            ParserMemory& owner = *header->owner;
            const std::size_t bytes = header->bytes;
            owner.in_use_ -= bytes;
            if (owner.memory_ != nullptr) {
                owner.memory_->release(owner.memory_->context, header, bytes, alignof(Header));
            } else {
                ::operator delete(header);
            }
        }
    }

    void* take(std::size_t block_bytes) noexcept {
        const std::size_t left = parser_memory_limit - in_use_;
        if (left < sizeof(Header) || block_bytes > left - sizeof(Header)) {
            exhausted_ = true;
            return nullptr;
        }
        const std::size_t bytes = sizeof(Header) + block_bytes;
        void* const raw = memory_ != nullptr ? memory_->allocate(memory_->context, bytes, alignof(Header))
                                             : ::operator new(bytes, std::nothrow);
        if (raw == nullptr) {
            return nullptr;  // expat then says that memory ran out
        }
        in_use_ += bytes;
        return new (raw) Header{this, bytes} + 1;
    }

    static thread_local ParserMemory* current_;
    const Memory* memory_;
    std::size_t in_use_ = 0;
    bool exhausted_ = false;  // the limit, and not the machine
};

thread_local XmlReader::ParserMemory* XmlReader::ParserMemory::current_ = nullptr;
const XML_Memory_Handling_Suite XmlReader::ParserMemory::functions = {allocate, reallocate, release};

std::string XmlUnboundName::words() const {
    constexpr std::size_t longest = 64;
    return "ignored '" + printable(name.substr(0, longest)) + "', as its prefix is not declared";
}

/// By a table and without branches: a few bytes in each nanosecond.
bool is_plain_xml_text(std::string_view text) noexcept {
    std::uint8_t other = 0;
    for (const char c : text) {
        other |= is_other[static_cast<unsigned char>(c)];
    }
    return other == 0;
}

// --- XmlAttributes

std::optional<std::string_view> XmlAttributes::find(const XmlName& name) const noexcept {
    for (const char* const* at = list_; *at != nullptr; at += 2) {
        // Most have no namespace and need not be split.
        if (name.space.empty()) {
            if (at[0] == name.local) {
                return at[1];
            }
            continue;
        }
        const XmlWrittenName written = split_name(at[0]);
        if (!written.prefix.empty() && written.local == name.local && namespaces_.find(written.prefix) == name.space) {
            return at[1];
        }
    }
    return std::nullopt;
}

std::string_view XmlAttributes::unbound(std::optional<std::string_view> local) const noexcept {
    for (const char* const* at = list_; *at != nullptr; at += 2) {
        const XmlWrittenName written = split_name(at[0]);
        if (!written.prefix.empty() && (!local || written.local == *local) && !declared_prefix(at[0]) &&
            !namespaces_.find(written.prefix)) {
            return at[0];
        }
    }
    return {};
}

// --- XmlReader

/// What expat calls.
struct XmlReader::Callbacks {
    static XmlReader& reader(void* user) { return *static_cast<XmlReader*>(user); }

    static void begin(void* user, const XML_Char* name, const XML_Char** attributes) {
        reader(user).deliver([&] { reader(user).begin(name, attributes); });
    }
    static void end(void* user, const XML_Char* name) {
        reader(user).deliver([&] {
            reader(user).end_element(reader(user).namespaces_.element(name));
            reader(user).namespaces_.close(reader(user).depth_--);
        });
    }
    static void text(void* user, const XML_Char* piece, int length) {
        reader(user).deliver([&] { reader(user).text({piece, static_cast<std::size_t>(length)}); });
    }
    static void doctype(void* user, const XML_Char*, const XML_Char*, const XML_Char*, int) {
        reader(user).deliver([&] { reader(user).fail("a document type declaration, which is refused"); });
    }
};

XmlReader::XmlReader(const Memory* memory) : memory_(std::make_unique<ParserMemory>(memory)) {
    const ParserMemory::Scope scope(*memory_);
    XML_Parser parser = XML_ParserCreate_MM(nullptr, &ParserMemory::functions, nullptr);
    if (parser == nullptr) {
        throw std::bad_alloc();
    }
    parser_ = parser;
    XML_SetUserData(parser, this);
    XML_SetElementHandler(parser, Callbacks::begin, Callbacks::end);
    XML_SetCharacterDataHandler(parser, Callbacks::text);
    XML_SetStartDoctypeDeclHandler(parser, Callbacks::doctype);
}

XmlReader::~XmlReader() {
    const ParserMemory::Scope scope(*memory_);
    XML_ParserFree(as_parser(parser_));
}

template <class Event>
void XmlReader::deliver(Event&& event) noexcept {
    if (stopped_) {
        return;  // expat still ends the empty element that was refused
    }
    try {
        event();
    } catch (...) {
        thrown_ = std::current_exception();
        stop();
    }
}

void XmlReader::begin(std::string_view name, const char* const* attributes) {
    ++depth_;
    if (!declare_namespaces(attributes)) {
        return;
    }
    const XmlAttributes list(attributes, namespaces_);
    note_unbound(name, list);
    begin_element(namespaces_.element(name), list);
}

bool XmlReader::declare_namespaces(const char* const* attributes) {
    for (const char* const* at = attributes; *at != nullptr && !stopped_; at += 2) {
        const std::optional<std::string_view> prefix = declared_prefix(at[0]);
        if (!prefix) {
            continue;
        }
        if (!namespaces_.declare(*prefix, at[1], depth_)) {
            fail(unreal_names);
            return false;
        }
        declare_namespace(*prefix, at[1]);
    }
    return !stopped_;
}

void XmlReader::note_unbound(std::string_view element, const XmlAttributes& attributes) {
    if (unbound_name_) {
        return;
    }
    const bool is_bound = namespaces_.find(split_name(element).prefix).has_value();
    if (const std::string_view name = is_bound ? attributes.unbound() : element; !name.empty()) {
        unbound_name_ = {event_line(), event_offset(), std::string(name)};
    }
}

bool XmlReader::feed(std::string_view bytes) {
    while (!stopped_ && !bytes.empty()) {
        const std::string_view piece = bytes.substr(0, piece_bytes);
        bytes.remove_prefix(piece.size());
        parse(piece, false);
    }
    return !stopped_;
}

bool XmlReader::finish() {
    return !stopped_ && parse({}, true);
}

bool XmlReader::parse(std::string_view bytes, bool last) {
    const ParserMemory::Scope scope(*memory_);
    XML_Parser parser = as_parser(parser_);
    const XML_Status answer = XML_Parse(parser, bytes.data(), static_cast<int>(bytes.size()), last ? 1 : 0);
    if (thrown_) {
        std::rethrow_exception(std::exchange(thrown_, nullptr));
    }
    if (answer == XML_STATUS_OK || stopped_) {
        return !stopped_;
    }
    const XML_Error error = XML_GetErrorCode(parser);
    if (error == XML_ERROR_NO_MEMORY && !memory_->exhausted()) {
        throw std::bad_alloc();
    }
    fail(error == XML_ERROR_NO_MEMORY ? std::string(unreal_names) : std::string("malformed XML: ") + XML_ErrorString(error));
    return false;
}

void XmlReader::fail(std::string what) {
    failure_ = {event_line(), event_offset(), std::move(what)};
    stop();
}

void XmlReader::stop() {
    stopped_ = true;
    XML_StopParser(as_parser(parser_), XML_FALSE);
}

std::uint64_t XmlReader::event_line() const noexcept {
    return skipped_lines_ + XML_GetCurrentLineNumber(as_parser(parser_));
}

std::uint64_t XmlReader::event_offset() const noexcept {
    const XML_Index parsed = std::max<XML_Index>(0, XML_GetCurrentByteIndex(as_parser(parser_)));
    return skipped_bytes_ + static_cast<std::uint64_t>(parsed);
}

std::uint64_t XmlReader::event_end() const noexcept {
    return event_offset() + static_cast<std::uint64_t>(XML_GetCurrentByteCount(as_parser(parser_)));
}

}  // namespace lamella
