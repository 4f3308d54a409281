// Descriptors of the system, "-" in place of a path (standard input for a mesh, standard output for what is written), and
// checks of an output's path before the work for it is done.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "terminal/console.hpp"

namespace lamella::cli {

/// Closes its descriptor.
class Descriptor {
public:
    explicit Descriptor(int number) noexcept : number_(number) {}
    Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
    Descriptor& operator=(Descriptor&& other) noexcept {
        std::swap(number_, other.number_);
        return *this;
    }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    ~Descriptor();

    int number() const noexcept { return number_; }

private:
    int number_;  ///< below 0: none
};

/// 0 when all is written, else an error number.
int write_all(const Descriptor& to, std::string_view bytes) noexcept;

inline constexpr std::string_view standard_stream = "-";

inline bool is_standard(std::string_view path) noexcept {
    return path == standard_stream;
}

/// The names of an input and an output in messages.
inline std::string input_name(const std::string& path) {
    return is_standard(path) ? "standard input" : path;
}
inline std::string output_name(const std::string& path) {
    return is_standard(path) ? "standard output" : path;
}

/// The path under which the library writes to an output.
inline std::string output_path(const std::string& path) {
    return is_standard(path) ? "/dev/stdout" : path;
}

/// Writes a report. Throws Failure (bad_output).
void write_text(const std::string& path, const std::string& text);

/// $TMPDIR, else /tmp.
std::string temporary_folder();

/// All of standard input in a file that has no name, so that any of its bytes can be read in any order. The file is made in
/// the temporary folder. Throws Failure.
Descriptor spooled_input();

/// "cannot write 'PATH': REASON"
Failure unwritable(const std::string& path, int error_number);

/// Throws Failure (bad_output) where `path`, or standard output for -, plainly cannot be written; a full disk shows only
/// later.
void require_writable(const std::string& path);

/// Throws Failure (bad_usage) if the path ends in another extension, and is no device or pipe.
void require_extension(const std::string& path, const std::string& option, const std::string& extension);

/// Where a file lies or would lie, whatever links and spellings its path has.
std::string place_of(const std::string& path);

/// The files of a command, of which no output replaces an input or another output, by whatever path or link, and whether it
/// exists or not. An input and an output may both be -, which are different streams. Empty paths stand for no file.
class FilePlan {
public:
    /// `what`: as messages call it, "the mesh". Throws Failure (bad_usage).
    void reads(const std::string& path, const std::string& what) { add(path, "", what); }
    /// The same of a file that `option` names.
    void writes(const std::string& path, const std::string& option, const std::string& what) { add(path, option, what); }
    /// Throws Failure (bad_usage) where `path` could not be added.
    void require_free(const std::string& path, const std::string& option) const {
        require_free({path, place_of(path), option, ""});
    }

private:
    struct File {
        std::string path;
        std::string place;
        std::string option;  ///< empty: an input
        std::string what;
    };
    void require_free(const File& file) const;
    void add(const std::string& path, const std::string& option, const std::string& what);

    std::vector<File> files_;
};

}  // namespace lamella::cli
