#include "io/xml/xml.hpp"

#include <expat.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <new>
#include <utility>

#include "lamella/memory.hpp"

namespace lamella {

namespace {

/// Between a namespace's address and the local name in what expat calls a name. It refuses addresses that contain it.
constexpr char name_separator = '\n';

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

XmlName split_name(const char* name) {
    const std::string_view whole(name);
    const std::size_t separator = whole.rfind(name_separator);
    return separator == std::string_view::npos ? XmlName{{}, whole}
                                               : XmlName{whole.substr(0, separator), whole.substr(separator + 1)};
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
        if (name.space.empty() ? at[0] == name.local : split_name(at[0]) == name) {
            return at[1];
        }
    }
    return std::nullopt;
}

// --- XmlReader

/// What expat calls.
struct XmlReader::Callbacks {
    static XmlReader& reader(void* user) { return *static_cast<XmlReader*>(user); }

    static void begin(void* user, const XML_Char* name, const XML_Char** attributes) {
        reader(user).deliver([&] { reader(user).begin_element(split_name(name), XmlAttributes(attributes)); });
    }
    static void end(void* user, const XML_Char* name) {
        reader(user).deliver([&] { reader(user).end_element(split_name(name)); });
    }
    static void text(void* user, const XML_Char* piece, int length) {
        reader(user).deliver([&] { reader(user).text({piece, static_cast<std::size_t>(length)}); });
    }
    static void declare(void* user, const XML_Char* prefix, const XML_Char* space) {
        const auto view = [](const XML_Char* text) { return text != nullptr ? std::string_view(text) : std::string_view(); };
        reader(user).deliver([&] { reader(user).declare_namespace(view(prefix), view(space)); });
    }
    static void doctype(void* user, const XML_Char*, const XML_Char*, const XML_Char*, int) {
        reader(user).deliver([&] { reader(user).fail("a document type declaration, which is refused"); });
    }
};

XmlReader::XmlReader(const Memory* memory) : memory_(std::make_unique<ParserMemory>(memory)) {
    const ParserMemory::Scope scope(*memory_);
    const XML_Char separator[] = {name_separator, '\0'};
    XML_Parser parser = XML_ParserCreate_MM(nullptr, &ParserMemory::functions, separator);
    if (parser == nullptr) {
        throw std::bad_alloc();
    }
    parser_ = parser;
    XML_SetUserData(parser, this);
    XML_SetElementHandler(parser, Callbacks::begin, Callbacks::end);
    XML_SetCharacterDataHandler(parser, Callbacks::text);
    XML_SetStartNamespaceDeclHandler(parser, Callbacks::declare);
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
    fail(error == XML_ERROR_NO_MEMORY ? std::string("elements too deep, names too many or a tag too long to be real")
                                      : std::string("malformed XML: ") + XML_ErrorString(error));
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
