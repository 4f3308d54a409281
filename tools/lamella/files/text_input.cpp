#include "files/text_input.hpp"

#include <cerrno>
#include <cstdio>
#include <memory>
#include <system_error>

#include "terminal/failure.hpp"

namespace lamella::cli {

std::string read_text(const std::string& path) {
    constexpr std::size_t most_bytes = std::size_t{1} << 30;
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), &std::fclose);
    std::string text;
    std::vector<char> piece(std::size_t{1} << 16);
    std::size_t count = 0;
    while (file && (count = std::fread(piece.data(), 1, piece.size(), file.get())) > 0) {
        text.append(piece.data(), count);
        if (text.size() > most_bytes) {
            throw Failure(bad_input, path + ": larger than 1 GiB, too large for such a file");
        }
    }
    if (!file || std::ferror(file.get()) != 0) {
        throw Failure(bad_input, "cannot read '" + path + "': " + std::generic_category().message(errno));
    }
    const std::string_view start = std::string_view(text).substr(0, 2);
    if (start == "\xff\xfe" || start == "\xfe\xff" || start.find('\0') != std::string_view::npos) {
        throw Failure(bad_input, path + ": is text in UTF-16: save it as UTF-8");
    }
    if (text.starts_with("\xef\xbb\xbf")) {
        text.erase(0, 3);
    }
    return text;
}

std::vector<std::string_view> split(std::string_view text, char separator) {
    std::vector<std::string_view> pieces;
    for (std::size_t end = text.find(separator); end != std::string_view::npos; end = text.find(separator)) {
        pieces.push_back(text.substr(0, end));
        text.remove_prefix(end + 1);
    }
    pieces.push_back(text);
    return pieces;
}

}  // namespace lamella::cli
