#include "io/xml/namespaces.hpp"

#include <algorithm>

namespace lamella {

namespace {

// Each name is looked for among all, so that their number bounds the time as well.
constexpr std::size_t most_bindings = 256;
constexpr std::size_t most_binding_bytes = std::size_t{1} << 16;

}  // namespace

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

}  // namespace lamella
