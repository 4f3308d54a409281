#include "io/xml/xml.hpp"

#include <expat.h>

#include <algorithm>
#include <array>
#include <new>

#include "io/read/input_file.hpp"

namespace lamella {

namespace {

constexpr const char* unreal = "elements too deep, names too many or a tag too long to be real";

// Each name is looked for among all, so that their number bounds the time as well.
constexpr std::size_t most_bindings = 256;
constexpr std::size_t most_binding_bytes = std::size_t{1} << 16;

constexpr std::size_t most_names = 10'000;
constexpr std::size_t most_name_bytes = std::size_t{1} << 20;

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

}  // namespace

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

// --- XmlNamespaces

XmlWrittenName split_name(std::string_view name) noexcept {
    const std::size_t colon = name.find(':');
    return colon == 0 || colon == std::string_view::npos ? XmlWrittenName{{}, name}
                                                         : XmlWrittenName{name.substr(0, colon), name.substr(colon + 1)};
}

bool XmlNamespaces::declare(std::string_view prefix, std::string_view space, std::uint64_t depth) {
    bytes_ += prefix.size() + space.size();
    if (bindings_.size() == most_bindings || bytes_ > most_binding_bytes) {
        return false;
    }
    bindings_.push_back({std::string(prefix), std::string(space), depth});
    return true;
}

void XmlNamespaces::close(std::uint64_t depth) noexcept {
    for (; !bindings_.empty() && bindings_.back().depth == depth; bindings_.pop_back()) {
        bytes_ -= bindings_.back().prefix.size() + bindings_.back().space.size();
    }
}

std::optional<std::string_view> XmlNamespaces::find(std::string_view prefix) const noexcept {
    const auto found = std::find_if(bindings_.rbegin(), bindings_.rend(),
                                    [prefix](const Binding& binding) { return binding.prefix == prefix; });
    if (found != bindings_.rend() && (prefix.empty() || !found->space.empty())) {
        return found->space;
    }
    if (prefix == "xml") {
        return "http://www.w3.org/XML/1998/namespace";
    }
    return prefix.empty() ? std::optional<std::string_view>("") : std::nullopt;
}

XmlName XmlNamespaces::element(std::string_view name) const noexcept {
    const XmlWrittenName written = split_name(name);
    const std::optional<std::string_view> space = find(written.prefix);
    return space ? XmlName{*space, written.local} : XmlName{{}, name};
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

void XmlReader::ParserDeleter::operator()(XML_ParserStruct* parser) const noexcept {
    XML_ParserFree(parser);
}

XmlReader::XmlReader() : parser_(XML_ParserCreate(nullptr)) {
    if (parser_ == nullptr) {
        throw std::bad_alloc();
    }
    XML_SetUserData(parser_.get(), this);
    XML_SetElementHandler(
        parser_.get(),
        [](void* user, const XML_Char* name, const XML_Char** attributes) {
            self(user).deliver([&] { self(user).begin(name, attributes); });
        },
        [](void* user, const XML_Char* name) { self(user).deliver([&] { self(user).end(name); }); });
    XML_SetCharacterDataHandler(parser_.get(), [](void* user, const XML_Char* piece, int length) {
        self(user).deliver([&] { self(user).text({piece, static_cast<std::size_t>(length)}); });
    });
    XML_SetStartDoctypeDeclHandler(parser_.get(), [](void* user, const XML_Char*, const XML_Char*, const XML_Char*, int) {
        self(user).deliver([&] { self(user).fail("a document type declaration, which is refused"); });
    });
}

XmlReader::~XmlReader() = default;

template <class Event>
void XmlReader::deliver(Event&& event) noexcept {
    if (stopped_) {
        return;  // expat still ends the empty element that was refused
    }
    try {
        event();
    } catch (XmlFailure& failure) {
        end_by(std::move(failure));
    } catch (...) {
        thrown_ = std::current_exception();
        stop();
    }
}

void XmlReader::begin(std::string_view name, const char* const* attributes) {
    open_name_bytes_ += name.size();  // expat keeps one for each open element
    bool real = ++depth_ <= most_open_elements && open_name_bytes_ <= most_name_bytes && note_name(name);
    for (const char* const* at = attributes; real && *at != nullptr; at += 2) {
        const std::optional<std::string_view> prefix = declared_prefix(at[0]);
        real = note_name(at[0]) && (!prefix || namespaces_.declare(*prefix, at[1], depth_));
    }
    if (!real) {
        fail(unreal);
    }
    const XmlAttributes list(attributes, namespaces_);
    note_unbound(name, list);
    begin_element(namespaces_.element(name), list);
}

void XmlReader::end(std::string_view name) {
    end_element(namespaces_.element(name));
    namespaces_.close(depth_--);
    open_name_bytes_ -= name.size();
}

bool XmlReader::note_name(std::string_view name) {
    if (names_.find(name) == names_.end()) {
        names_.emplace(name);
        name_bytes_ += name.size();
    }
    return names_.size() <= most_names && name_bytes_ <= most_name_bytes;
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
    const XML_Status answer = XML_Parse(parser_.get(), bytes.data(), static_cast<int>(bytes.size()), last ? 1 : 0);
    if (thrown_) {
        std::rethrow_exception(std::exchange(thrown_, nullptr));
    }
    parsed_bytes_ += bytes.size();
    if (answer != XML_STATUS_OK && !stopped_) {
        const XML_Error error = XML_GetErrorCode(parser_.get());
        if (error == XML_ERROR_NO_MEMORY) {
            throw std::bad_alloc();
        }
        end_by({event_line(), event_offset(), std::string("malformed XML: ") + XML_ErrorString(error)});
    } else if (!stopped_ && !last && parsed_bytes_ + skipped_bytes_ - event_offset() > longest_tag_bytes) {
        end_by({event_line(), event_offset(), unreal});
    }
    return !stopped_;
}

void XmlReader::end_by(XmlFailure failure) {
    failure_ = std::move(failure);
    stop();
}

void XmlReader::stop() {
    stopped_ = true;
    XML_StopParser(parser_.get(), XML_FALSE);
}

std::uint64_t XmlReader::event_line() const noexcept {
    return skipped_lines_ + XML_GetCurrentLineNumber(parser_.get());
}

std::uint64_t XmlReader::event_offset() const noexcept {
    const XML_Index parsed = std::max<XML_Index>(0, XML_GetCurrentByteIndex(parser_.get()));
    return skipped_bytes_ + static_cast<std::uint64_t>(parsed);
}

std::uint64_t XmlReader::event_end() const noexcept {
    return event_offset() + static_cast<std::uint64_t>(XML_GetCurrentByteCount(parser_.get()));
}

}  // namespace lamella
