// Namespaces of XML names. They are resolved here and not by expat, which ends the document at a prefix that is not
// declared.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace lamella {

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

/// The namespaces that the open elements declare.
class XmlNamespaces {
public:
    /// Of the next element, which is at `depth`. False: more are declared than any real file needs.
    bool declare(std::string_view prefix, std::string_view space, std::uint64_t depth);
    /// Forgets what elements at `depth` declared.
    void close(std::uint64_t depth) noexcept;

    /// The namespace of that prefix, empty where it is the empty one; nothing if it is not declared.
    std::optional<std::string_view> find(std::string_view prefix) const noexcept;
    /// Of an element. One whose prefix is not declared keeps it in its name and has no namespace.
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

}  // namespace lamella
