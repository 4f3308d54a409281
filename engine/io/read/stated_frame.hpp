// The patient frame that a file states.
#pragma once

#include <string>
#include <string_view>

#include "io/read/reader.hpp"

namespace lamella {

/// Collects statements as 3D Slicer writes them. The frame is never guessed: contradicting statements and
/// unknown frames are ignored.
class StatedFrame {
public:
    /// Any "SPACE=LPS" among the words of a header or comment.
    void read_header(std::string_view header);
    /// What the string SPACE among a file's data says, "LPS".
    void read_space(std::string_view space);

    /// Gives `mesh` the frame, or a warning where statements contradict each other.
    void give(const FileSource& source, MeshFile& mesh) const;

private:
    std::string first_;
    std::string other_;  ///< the first that differs
};

/// Gives `mesh` the frame that `header` alone states.
void give_stated_frame(std::string_view header, const FileSource& source, MeshFile& mesh);

}  // namespace lamella
