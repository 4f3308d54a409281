#include "io/read/stl/stl_ascii.hpp"

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <cstring>
#include <vector>

#include "io/read/stl/facet_parser.hpp"
#include "io/text/pieces.hpp"
#include "lamella/memory.hpp"

namespace lamella {

namespace {

constexpr std::size_t facet_floats = 9;
constexpr std::size_t facet_bytes = facet_floats * sizeof(float);
constexpr std::size_t shortest_facet = sizeof "facet vertex 0 0 0 vertex 0 0 0 vertex 0 0 0" - 1;

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
/// name reaches across it, so the search back stops there and all cuts together take O(text).
const char* next_facet(const char* known, const char* from, const char* end, const Parallel& parallel) {
    for (const char* p = from; p != end; ++p) {
        if ((p - from) % static_cast<std::ptrdiff_t>(text_piece_bytes) == 0) {
            parallel.stop_if_asked();
        }
        if (!may_begin_facet(p, end) || !is_space(p[-1])) {
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

/// Each piece begins with a facet (the first one: with the file) and ends where the next one begins.
std::vector<TextPiece> cut_at_facets(std::string_view text, const Parallel& parallel) {
    const char* const end = text.data() + text.size();
    return cut_text(text, text_piece_bytes, [end, &parallel](const char* begin, const char* from) {
        return next_facet(begin, from, end, parallel);
    });
}

/// Words in 'f': all facets and, at most, some words of names.
std::size_t most_facets(std::string_view piece) {
    const auto is_f = [](char c) { return (c | 0x20) == 'f'; };
    const std::size_t words = (is_f(piece[0]) ? 1 : 0) + count_in(piece, [is_f](char before, char c) {
                                  return static_cast<int>(is_f(c)) & static_cast<int>(is_space(before));
                              });
    return std::min(words, piece.size() / shortest_facet + 1);
}

/// Parses what begins within the piece, which has room for `piece.count` facets from `piece.first` on. Words are read to the
/// end of the text, so that a cut never looks like the end. `open_end`: after the last statement, if that is not `endsolid`.
TextFailure parse(const TextPiece& piece, const char* text_end, std::byte* coordinates, ItemRun& run, const char*& open_end,
                  StlDepartures& departures, PartMarks& solids, const Parallel& parallel) {
    FacetParser parser(piece.begin(), text_end, parallel);
    std::byte* out = coordinates + piece.first * facet_bytes;
    float facet[facet_floats];
    std::size_t count = 0;
    while (parser.next_facet(piece.end(), facet)) {
        assert(count < piece.count);
        std::memcpy(out + count++ * facet_bytes, facet, facet_bytes);
    }
    run = {piece.first, count};
    departures = parser.departures();
    solids = parser.solids();
    open_end = parser.solid_ended() ? nullptr : parser.last_end();
    return parser.failure();
}

}  // namespace

AsciiFacets parse_ascii_stl(std::string_view text, const Memory* memory, const Parallel& parallel) {
    AsciiFacets facets{Array<std::byte>(memory), 0, {}, {}, std::nullopt, {}};
    std::vector<TextPiece> pieces = cut_at_facets(text, parallel);
    parallel.run(pieces.size(), [&](std::size_t i, int) { pieces[i].count = most_facets(pieces[i].text); });
    facets.coordinates.resize_discarding(number_items(pieces) * facet_bytes);

    std::vector<ItemRun> runs(pieces.size());
    std::vector<const char*> open_ends(pieces.size());
    std::vector<StlDepartures> departures(pieces.size());
    std::vector<PartMarks> solids(pieces.size());
    facets.failure = parse_pieces<TextFailure>(pieces.size(), parallel, [&](std::size_t i, int) {
        return parse(pieces[i], text.data() + text.size(), facets.coordinates.data(), runs[i], open_ends[i], departures[i],
                     solids[i], parallel);
    });
    if (facets.failure.at != nullptr) {
        return facets;
    }
    if (!pieces.empty() && open_ends.back() != nullptr) {
        facets.open_end = static_cast<std::size_t>(open_ends.back() - text.data());
    }
    std::uint64_t first = 0;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
        add_marks(facets.solids, solids[i], first);
        first += runs[i].count;
    }
    for (const StlDepartures& departure : departures) {
        if (facets.departures.facets.count == 0) {
            facets.departures.first_facet = departure.first_facet;
        }
        facets.departures.facets.add(departure.facets);
        facets.departures.lines.add(departure.lines);
    }
    // Words of names in 'f' left gaps; there are none otherwise.
    facets.count = close_gaps(runs, facet_bytes, facets.coordinates.data());
    facets.coordinates.set_size(facets.count * facet_bytes);
    return facets;
}

}  // namespace lamella
