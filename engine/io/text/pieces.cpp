#include "io/text/pieces.hpp"

#include <cstring>
#include <utility>

#include "io/text/text.hpp"

namespace lamella {

std::vector<TextPiece> cut_text(std::string_view text, std::size_t piece_bytes,
                                FunctionRef<const char*(const char* begin, const char* from)> end_of_piece) {
    std::vector<TextPiece> pieces;
    const char* const end = text.data() + text.size();
    for (const char* begin = text.data(); begin != end;) {
        const auto left = static_cast<std::size_t>(end - begin);
        const char* const cut = left > piece_bytes ? end_of_piece(begin, begin + piece_bytes) : end;
        pieces.push_back({.text = {begin, static_cast<std::size_t>(cut - begin)}});
        begin = cut;
    }
    return pieces;
}

std::size_t number_items(std::span<TextPiece> pieces) {
    std::size_t all = 0;
    for (TextPiece& piece : pieces) {
        piece.first = std::exchange(all, all + piece.count);
    }
    return all;
}

std::size_t count_words(std::string_view text) {
    const bool begins = !text.empty() && !is_space(text[0]);
    return (begins ? 1 : 0) + count_in(text, [](char before, char c) {
               return static_cast<int>(is_space(before)) & static_cast<int>(!is_space(c));
           });
}

std::size_t close_gaps(std::span<const ItemRun> runs, std::size_t item_bytes, std::byte* items) {
    std::size_t all = 0;
    for (const ItemRun& run : runs) {
        if (run.count > 0 && run.first != all) {
            std::memmove(items + all * item_bytes, items + run.first * item_bytes, run.count * item_bytes);
        }
        all += run.count;
    }
    return all;
}

}  // namespace lamella
