// Where the parts of a text file begin.
#pragma once

#include <string_view>
#include <vector>

#include "lamella/io/mesh_file.hpp"

namespace lamella {

/// A line that names the triangles from there on.
struct PartMark {
    std::uint64_t triangle = 0;
    bool group = false;  ///< within what another kind of line names
    std::string_view name;
};
using PartMarks = std::vector<PartMark>;

/// Adds a mark whose name is [begin, end) without white space around it. So many are kept that what they take is bounded.
void add_mark(PartMarks& marks, std::uint64_t triangle, bool group, const char* begin, const char* end);
/// Those of the next piece of the text, whose triangles begin at `first`.
void add_marks(PartMarks& marks, const PartMarks& next, std::uint64_t first);

/// Gives the mesh its parts, or warns that they are too many: those of groups where all else has one name. What comes before
/// the first mark is a part of its own, marks without a triangle are none. `go_on`: a mark of the same name as the one
/// before goes on with its part.
void give_parts(const PartMarks& marks, bool go_on, const std::string& file, MeshFile& mesh);

}  // namespace lamella
