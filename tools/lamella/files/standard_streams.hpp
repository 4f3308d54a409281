// "-" in place of a path: standard input for a mesh, standard output for what is written.
#pragma once

#include <string>
#include <string_view>

namespace lamella::cli {

inline constexpr std::string_view standard_stream = "-";

inline bool is_standard(std::string_view path) noexcept {
    return path == standard_stream;
}

/// What messages call an input or an output.
std::string input_name(const std::string& path);
std::string output_name(const std::string& path);

/// The path under which the library writes to an output.
std::string output_path(const std::string& path);

/// All of standard input in a file that has no name, so that any of its bytes can be read in any order.
class SpooledInput {
public:
    /// Reads until the end. The file is made in $TMPDIR, else in /tmp. Throws Failure.
    SpooledInput();
    ~SpooledInput();
    SpooledInput(const SpooledInput&) = delete;
    SpooledInput& operator=(const SpooledInput&) = delete;

    std::string path() const { return "/dev/fd/" + std::to_string(descriptor_); }  ///< while this lives

private:
    int descriptor_ = -1;
};

}  // namespace lamella::cli
