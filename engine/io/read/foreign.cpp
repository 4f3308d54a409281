#include "io/read/foreign.hpp"

#include <algorithm>

#include "io/read/reader.hpp"
#include "io/text/text.hpp"

namespace lamella {

namespace {

/// Whether `text` begins with `start`, given in lower case, in any case.
bool begins_with(std::string_view text, std::string_view start) {
    return text.size() >= start.size() && std::equal(start.begin(), start.end(), text.begin(), [](char wanted, char c) {
               return c == wanted || (c >= 'A' && c <= 'Z' && c - 'A' + 'a' == wanted);
           });
}

bool is_html(std::string_view text) {
    while (!text.empty() && is_space(text.front())) {
        text.remove_prefix(1);
    }
    return begins_with(text, "<!doctype html") || begins_with(text, "<html");
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
