#include "io/read/arrays/array_xml.hpp"

namespace lamella {

/// Feeds everything but the numbers of arrays: expat would take longer to pass over them than they take to be read.
void ArrayXml::parse_document() {
    constexpr std::size_t window = std::size_t{64} << 10;  // appended data, which end parsing, are not searched for tags
    std::string_view rest = file_.text;
    bool goes_on = true;
    while (goes_on && !rest.empty()) {
        file_.source.parallel().stop_if_asked();
        const std::string_view ahead = rest.substr(0, window);
        const std::size_t tag_end = ahead.find('>', ahead.find(array_tag_));
        const std::string_view head = ahead.substr(0, tag_end == std::string_view::npos ? tag_end : tag_end + 1);
        goes_on = feed(head);
        rest.remove_prefix(head.size());
        const bool has_begun = goes_on && file_.offset_of(rest.data()) == tag_end_;
        const std::string_view numbers = rest.substr(0, has_begun ? rest.find('<') : 0);
        skip(numbers);
        rest.remove_prefix(numbers.size());
    }
    if (goes_on) {
        finish();
    }
    if (failure()) {
        throw TextError{file_.text.data() + failure()->offset, failure()->what};
    }
}

void ArrayXml::begin_element(const XmlName& name, const XmlAttributes& attributes) {
    end_content();
    tag_end_ = event_end();
    path_.append(1, '/').append(name.space.empty() ? name.local : "other");
    if (path_.rfind('/') == 0 && path_ != root_path_) {
        refuse("expected the element " + root_path_.substr(1) + ", found " + in_quotes(name.local));
    }
    begin_path(attributes);
}

void ArrayXml::end_element(const XmlName& /*name*/) {
    end_content();
    end_path();
    path_.resize(path_.rfind('/'));
}

/// The content of an array ends with its element or where another one begins in it.
void ArrayXml::end_content() {
    if (std::string_view* const content = std::exchange(content_, nullptr);
        content != nullptr && event() > content->data()) {
        *content = {content->data(), static_cast<std::size_t>(event() - content->data())};
    }
}

std::uint64_t ArrayXml::count(const XmlAttributes& attributes, std::string_view name) const {
    const std::string_view digits = attributes.find(name).value_or("0");
    std::uint64_t count = 0;
    if (!read_integer(digits, count)) {
        refuse("expected a number as " + std::string(name) + ", found " + in_quotes(digits));
    }
    return count;
}

bool ArrayXml::is_second(const XmlAttributes& attributes, std::string_view name, std::string_view first,
                         std::string_view second) const {
    const std::string_view value = attributes.find(name).value_or(first);
    if (value != first && value != second) {
        refuse("expected " + std::string(name) + " " + std::string(first) + " or " + std::string(second) + ", found " +
               in_quotes(value));
    }
    return value == second;
}

void warn_unbound(const ArrayFile& file, const XmlReader& document, MeshFile& mesh) {
    if (const std::optional<XmlFault>& unbound = document.unbound_name()) {
        mesh.warnings.push_back(file.source.name() + ": line " + std::to_string(line_of(file.text, unbound->offset)) + ": " +
                                unbound->what);
    }
}

bool begins_as_xml(const FileSource& source, std::string_view tag) {
    const std::string_view sample = without_byte_order_mark(source.sample());
    const char* const end = sample.data() + sample.size();
    const char* const first = skip_space(sample.data(), end);
    return first != end && *first == '<' && sample.find(tag) != std::string_view::npos;
}

}  // namespace lamella
