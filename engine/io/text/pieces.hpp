// Text on several threads, the same way for all readers of text:
//
//     cut_text()       pieces of about one size, each ending where the format lets it end
//     Parallel::run()  counts the items of each piece: vertices, lines, words or facets
//     number_items()   so that each piece knows where its items go among all
//     parse_pieces()   of the failures, the first in the text is reported
//     close_gaps()     where pieces had more room than items
//
// Cuts depend on the text alone, so that neither results nor errors depend on threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/parallel.hpp"

namespace lamella {

/// A piece of text, and which of the items of the whole text are in it.
struct TextPiece {
    std::string_view text;
    std::size_t first = 0;
    std::size_t count = 0;

    const char* begin() const noexcept { return text.data(); }
    const char* end() const noexcept { return text.data() + text.size(); }
    std::size_t end_item() const noexcept { return first + count; }
};

/// Large enough to hide the cost of a task, small enough to share out.
inline constexpr std::size_t text_piece_bytes = std::size_t{1} << 20;

/// Pieces of `piece_bytes` or little more; only the last may be shorter. end_of_piece(begin, from) is where the piece from
/// `begin` ends: at `from` or after.
std::vector<TextPiece> cut_text(std::string_view text, std::size_t piece_bytes,
                                FunctionRef<const char*(const char* begin, const char* from)> end_of_piece);

/// Sets each piece's `first` by what the pieces before count. Returns how many items there are in all.
std::size_t number_items(std::span<TextPiece> pieces);

/// How many characters, all but the first, are counted by counts(character before, character): 1 or 0. In blocks whose sum
/// fits a byte, so that compilers make vectors of it and it runs at the speed of memory.
template <class Counts>
std::size_t count_in(std::string_view text, Counts counts) {
    constexpr std::size_t block = 240;
    std::size_t sum = 0;
    for (std::size_t begin = 1; begin < text.size(); begin += block) {
        const char* const before = text.data() + begin - 1;
        const std::size_t length = std::min(block, text.size() - begin);
        std::uint8_t own = 0;
        for (std::size_t i = 0; i < length; ++i) {
            own = static_cast<std::uint8_t>(own + static_cast<std::uint8_t>(counts(before[i], before[i + 1])));
        }
        sum += own;
    }
    return sum;
}

/// Words in `text`, at whose beginning a word may begin.
std::size_t count_words(std::string_view text);

struct TextFailure {
    const char* at = nullptr;  ///< null: none
    std::string what;
};

/// Calls parse(piece, worker) for pieces in [0, count), in parallel. It returns a `Failure`, whose `at` is null where there
/// is none. Returns that of the first piece that fails; pieces after one that has failed may be left out.
template <class Failure, class Parse>
Failure parse_pieces(std::size_t count, const Parallel& parallel, Parse parse) {
    std::vector<Failure> failures(count);
    std::atomic<std::size_t> first_failed{count};
    parallel.run(count, [&](std::size_t i, int worker) {
        if (i > first_failed.load(std::memory_order_relaxed)) {
            return;
        }
        failures[i] = parse(i, worker);
        if (failures[i].at != nullptr) {
            std::size_t first = first_failed.load();
            while (i < first && !first_failed.compare_exchange_weak(first, i)) {
            }
        }
    });
    const std::size_t first = first_failed.load();
    return first == count ? Failure() : std::move(failures[first]);
}

/// Items that a piece wrote, from `first` on.
struct ItemRun {
    std::size_t first = 0;
    std::size_t count = 0;
};

/// Moves the items of all runs, which ascend, to follow each other. Returns how many there are.
std::size_t close_gaps(std::span<const ItemRun> runs, std::size_t item_bytes, std::byte* items);

}  // namespace lamella
