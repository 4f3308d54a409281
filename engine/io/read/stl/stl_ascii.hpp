// ASCII STL as text in memory, parsed in parallel.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "base/parallel.hpp"
#include "io/read/stl/facet_parser.hpp"
#include "lamella/array.hpp"
#include "lamella/memory.hpp"

namespace lamella {

struct AsciiFacets {
    Array<std::byte> coordinates;  ///< nine floats a facet
    std::size_t count = 0;
    StlDepartures departures;
    PartMarks solids;
    std::optional<std::size_t> open_end;  ///< byte of `text` after the last statement, if that is not `endsolid`
    TextFailure failure;                  ///< the first in the text, whatever the number of threads
};

/// Grammar: any number of `solid NAME-TO-END-OF-LINE`, `endsolid NAME-TO-END-OF-LINE` and
///
///     facet normal N N N  outer loop  vertex X Y Z  vertex X Y Z  vertex X Y Z  endloop  endfacet
///
/// in any case and with any white space between words. A name ends before its line does where a facet begins. Normals are
/// skipped. Departures from the grammar that leave no doubt about the vertices are read too. O(text). Allocates at most 36
/// bytes for each 44 of text.
AsciiFacets parse_ascii_stl(std::string_view text, const Memory* memory, const Parallel& parallel);

}  // namespace lamella
