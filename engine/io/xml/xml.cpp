#include "io/xml/xml.hpp"

#include <expat.h>

#include <algorithm>
#include <new>

#include "io/read/input_file.hpp"

namespace lamella {

namespace {

constexpr const char* unreal = "elements too deep, names too many or a tag too long to be real";

// Bytes that these count as, besides their names'. Each prefix is looked for among all bindings, so that their number bounds
// the time as well.
constexpr std::size_t open_element_bytes = 1024;
constexpr std::size_t binding_bytes = 4096;
constexpr std::size_t name_bytes = 64;

/// Bytes for one call of expat: its lengths are ints, and it copies tags that are cut in two.
constexpr std::size_t call_bytes = std::size_t{1} << 20;

/// The prefix that an attribute of that name declares; nothing if it declares none.
std::optional<std::string_view> declared_prefix(std::string_view name) {
    if (!name.starts_with("xmlns")) {
        return std::nullopt;
    }
    const std::string_view rest = name.substr(5);
    return rest.empty() ? std::optional(rest) : (rest[0] == ':' ? std::optional(rest.substr(1)) : std::nullopt);
}

/// A name as it is written: "prefix:local" or "local".
struct WrittenName {
    std::string_view prefix;
    std::string_view local;
};

WrittenName split_name(std::string_view name) noexcept {
    const std::size_t colon = name.find(':');
    return colon == 0 || colon == std::string_view::npos ? WrittenName{{}, name}
                                                         : WrittenName{name.substr(0, colon), name.substr(colon + 1)};
}

}  // namespace

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
        const WrittenName written = split_name(at[0]);
        if (!written.prefix.empty() && written.local == name.local && reader_.namespace_of(written.prefix) == name.space) {
            return at[1];
        }
    }
    return std::nullopt;
}

std::string_view XmlAttributes::unbound(std::optional<std::string_view> local) const noexcept {
    for (const char* const* at = list_; *at != nullptr; at += 2) {
        const WrittenName written = split_name(at[0]);
        if (!written.prefix.empty() && (!local || written.local == *local) && !declared_prefix(at[0]) &&
            !reader_.namespace_of(written.prefix)) {
            return at[0];
        }
    }
    return {};
}

// --- XmlReader

void XmlReader::ParserDeleter::operator()(XML_ParserStruct* parser) const noexcept {
    XML_ParserFree(parser);
}

XmlReader::XmlReader(bool may_name_type) : parser_(XML_ParserCreate(nullptr)), may_name_type_(may_name_type) {
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
    XML_SetStartDoctypeDeclHandler(parser_.get(),
                                   [](void* user, const XML_Char*, const XML_Char*, const XML_Char*, int declares) {
                                       self(user).deliver([&] {
                                           if (declares != 0 || !self(user).may_name_type_) {
                                               self(user).fail("a document type declaration, which is refused");
                                           }
                                       });
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
    } catch (XmlFault& failure) {
        end_by(std::move(failure));
    } catch (...) {
        thrown_ = std::current_exception();
        stop();
    }
}

void XmlReader::begin(std::string_view name, const char* const* attributes) {
    ++depth_;
    bool real = keep(open_element_bytes + name.size()) && keep_name(name);  // expat keeps one for each open element
    for (const char* const* at = attributes; real && *at != nullptr; at += 2) {
        real = keep_name(at[0]);
        if (const std::optional<std::string_view> prefix = declared_prefix(at[0])) {
            bindings_.push_back({std::string(*prefix), at[1], depth_});
            real = keep(bindings_.back().bytes()) && real;
        }
    }
    if (!real) {
        fail(unreal);
    }
    const XmlAttributes list(attributes, *this);
    note_unbound(name, list);
    begin_element(element(name), list);
}

void XmlReader::end(std::string_view name) {
    end_element(element(name));
    for (; !bindings_.empty() && bindings_.back().depth == depth_; bindings_.pop_back()) {
        kept_bytes_ -= bindings_.back().bytes();
    }
    kept_bytes_ -= open_element_bytes + name.size();
    --depth_;
}

std::size_t XmlReader::Binding::bytes() const noexcept {
    return binding_bytes + prefix.size() + space.size();
}

std::optional<std::string_view> XmlReader::namespace_of(std::string_view prefix) const noexcept {
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

XmlName XmlReader::element(std::string_view name) const noexcept {
    const WrittenName written = split_name(name);
    const std::optional<std::string_view> space = namespace_of(written.prefix);
    return space ? XmlName{*space, written.local} : XmlName{{}, name};
}

bool XmlReader::keep_name(std::string_view name) {
    return names_.contains(name) || (names_.emplace(name), keep(name_bytes + name.size()));
}

void XmlReader::note_unbound(std::string_view element, const XmlAttributes& attributes) {
    if (unbound_name_) {
        return;
    }
    const bool is_bound = namespace_of(split_name(element).prefix).has_value();
    if (const std::string_view name = is_bound ? attributes.unbound() : element; !name.empty()) {
        constexpr std::size_t longest = 64;
        unbound_name_ = {event_line(), event_offset(),
                         "ignored '" + printable(name.substr(0, longest)) + "', as its prefix is not declared"};
    }
}

bool XmlReader::feed(std::string_view bytes) {
    while (!stopped_ && !bytes.empty()) {
        const std::string_view piece = bytes.substr(0, call_bytes);
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

void XmlReader::end_by(XmlFault failure) {
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
