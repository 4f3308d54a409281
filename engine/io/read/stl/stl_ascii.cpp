#include "io/read/stl/stl_ascii.hpp"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cstdint>
#include <cstring>
#include <vector>

#include "io/read/stl/facet_parser.hpp"
#include "lamella/memory.hpp"

namespace lamella {

namespace {

constexpr std::size_t facets_bytes = std::size_t{1} << 20;
constexpr std::size_t facet_floats = 9;
constexpr std::size_t facet_bytes = facet_floats * sizeof(float);
constexpr std::size_t shortest_facet =
    sizeof "facet normal 0 0 0 outer loop vertex 0 0 0 vertex 0 0 0 vertex 0 0 0 endloop endfacet" - 1;

/// Text that begins with a facet (the first piece: with the file) and ends where the next one begins.
struct Piece {
    const char* begin = nullptr;
    const char* end = nullptr;
    std::size_t first = 0;     ///< where its facets go, with room for `capacity`
    std::size_t capacity = 0;  ///< at least as many as the piece holds
    std::size_t count = 0;
    const char* open_end = nullptr;  ///< behind its last statement, if that is not `endsolid`
    FacetParser::Failure failure;
};

/// Whether [line, p) holds `solid` or `endsolid` as a word: what follows on the line is then a name.
bool names_something(const char* line, const char* p) {
    while ((line = skip_space(line, p)) != p) {
        if (is_word<"solid">(line, p) || is_word<"endsolid">(line, p)) {
            return true;
        }
        line = skip_word(line, p);
    }
    return false;
}

/// The first facet that begins at or after `from`, or `end`. `known` < from is the beginning of a facet or of the text: no
/// name reaches across it, so that looking back stops there and all cuts together take O(text).
const char* next_facet(const char* known, const char* from, const char* end) {
    for (const char* p = from; p != end; ++p) {
        if (!is_word<"facet">(p, end) || !is_space(p[-1])) {
            continue;
        }
        const char* line = p;
        while (line != known && !ends_line(line[-1])) {
            --line;
        }
        if (!names_something(line, p)) {
            return p;
        }
        p = std::find_if(p, end, ends_line);
        if (p == end) {
            break;
        }
    }
    return end;
}

/// Cuts that depend on the text alone, so that errors do not depend on threads.
std::vector<Piece> cut(std::string_view text) {
    const char* end = text.data() + text.size();
    std::vector<Piece> pieces;
    for (const char* begin = text.data(); begin != end;) {
        Piece& piece = pieces.emplace_back();
        piece.begin = begin;
        const auto left = static_cast<std::size_t>(end - begin);
        piece.end = left > facets_bytes ? next_facet(begin, begin + facets_bytes, end) : end;
        begin = piece.end;
    }
    return pieces;
}

/// Words in 'f': all facets and, at most, some words of names. Without branches, so that it runs at the speed of memory.
std::size_t most_facets(const Piece& piece) {
    const auto length = static_cast<std::size_t>(piece.end - piece.begin);
    std::size_t words = (piece.begin[0] | 0x20) == 'f' ? 1 : 0;
    for (std::size_t i = 1; i < length; ++i) {
        words += static_cast<std::size_t>((piece.begin[i] | 0x20) == 'f') &
                 static_cast<std::size_t>(is_space(piece.begin[i - 1]));
    }
    return std::min(words, length / shortest_facet + 1);
}

/// Parses what begins within the piece; words are read to the end of the text, so that a cut never looks like the end.
void parse(Piece& piece, const char* end, std::byte* coordinates) {
    FacetParser parser(piece.begin, end);
    std::byte* out = coordinates + piece.first * facet_bytes;
    float facet[facet_floats];
    while (parser.next_facet(piece.end, facet)) {
        assert(piece.count < piece.capacity);
        std::memcpy(out + piece.count++ * facet_bytes, facet, facet_bytes);
    }
    piece.open_end = parser.solid_ended() ? nullptr : parser.last_end();
    piece.failure = parser.failure();
}

/// Closes the gaps that words of names in 'f' left; there are none otherwise.
std::size_t close_gaps(const std::vector<Piece>& pieces, std::byte* coordinates) {
    std::size_t count = 0;
    for (const Piece& piece : pieces) {
        if (piece.first != count) {
            std::memmove(coordinates + count * facet_bytes, coordinates + piece.first * facet_bytes,
                         piece.count * facet_bytes);
        }
        count += piece.count;
    }
    return count;
}

void parse_all(std::vector<Piece>& pieces, const char* end, std::byte* coordinates, const Parallel& parallel) {
    std::atomic<std::size_t> failed{pieces.size()};
    parallel.run(pieces.size(), [&](std::size_t i, int) {
        if (i > failed.load(std::memory_order_relaxed)) {
            return;  // an earlier piece fails, and only the first failure is told
        }
        parse(pieces[i], end, coordinates);
        if (pieces[i].failure.at != nullptr) {
            std::size_t first = failed.load();
            while (i < first && !failed.compare_exchange_weak(first, i)) {
            }
        }
    });
}

}  // namespace

AsciiFacets parse_ascii_stl(std::string_view text, const Memory* memory, const Parallel& parallel) {
    AsciiFacets facets{Array<std::byte>(memory), 0, std::nullopt, std::nullopt};
    std::vector<Piece> pieces = cut(text);
    parallel.run(pieces.size(), [&](std::size_t i, int) { pieces[i].capacity = most_facets(pieces[i]); });
    std::size_t room = 0;
    for (Piece& piece : pieces) {
        piece.first = room;
        room += piece.capacity;
    }
    facets.coordinates.resize_discarding(room * facet_bytes);
    parse_all(pieces, text.data() + text.size(), facets.coordinates.data(), parallel);

    const auto failed = std::find_if(pieces.begin(), pieces.end(), [](const Piece& p) { return p.failure.at != nullptr; });
    if (failed != pieces.end()) {
        const auto offset = static_cast<std::size_t>(failed->failure.at - text.data());
        facets.error = AsciiError{offset, failed->failure.what};
        return facets;
    }
    if (!pieces.empty() && pieces.back().open_end != nullptr) {
        facets.open_end = static_cast<std::size_t>(pieces.back().open_end - text.data());
    }
    facets.count = close_gaps(pieces, facets.coordinates.data());
    facets.coordinates.set_size(facets.count * facet_bytes);
    return facets;
}

}  // namespace lamella
