#include "io/read/foreign.hpp"

#include "io/read/reader.hpp"
#include "io/text/text.hpp"

namespace lamella {

namespace {

bool is_html(std::string_view text) {
    text.remove_prefix(static_cast<std::size_t>(skip_space(text.begin(), text.end()) - text.begin()));
    return begins_in_any_case(text, "<!doctype html") || begins_in_any_case(text, "<html");
}

}  // namespace

std::string foreign_content(std::string_view sample) {
    if (sample.starts_with("\xFF\xFE") || sample.starts_with("\xFE\xFF")) {
        return "is text in UTF-16; only ASCII and UTF-8 are read";
    }
    if (sample.starts_with("version https://git-lfs.github.com/spec/")) {
        return "is a Git LFS pointer in place of the mesh, which 'git lfs pull' fetches";
    }
    if (is_html(without_byte_order_mark(sample))) {
        return "is an HTML page, as a failed download leaves it";
    }
    return {};
}

}  // namespace lamella
