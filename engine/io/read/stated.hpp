// Statements of a file beside its triangles: the patient frame, and where parts begin in a text.
#pragma once

#include "io/read/reader.hpp"

namespace lamella {

/// Collects statements as 3D Slicer writes them. The frame is never guessed: contradicting statements and
/// unknown frames are ignored.
class StatedFrame {
public:
    /// Any "SPACE=LPS" among the words of a header or comment.
    void read_header(std::string_view header);
    /// The value of the string SPACE among a file's data, "LPS".
    void read_space(std::string_view space);

    /// Gives `mesh` the frame, or a warning where statements contradict each other.
    void give(const FileSource& source, MeshFile& mesh) const;

private:
    std::string first_;
    std::string other_;  ///< the first that differs
};

/// Gives `mesh` the frame that `header` alone states.
void give_stated_frame(std::string_view header, const FileSource& source, MeshFile& mesh);

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
