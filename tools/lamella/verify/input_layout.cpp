#include "verify/input_layout.hpp"

#include <algorithm>
#include <cstddef>

#include "files/standard_streams.hpp"
#include "terminal/failure.hpp"

namespace lamella::cli::verify {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t deepest = 64;  ///< how far up a path of a record may lead

}  // namespace

InputLayout::InputLayout(const fs::path& top, const Record& record) : top_(top), work_(top) {
    std::size_t ups = 0;
    for (const FileSeal& input : record.inputs) {
        const fs::path path = fs::path(input.path).lexically_normal();
        ups = std::max(ups, static_cast<std::size_t>(std::count(path.begin(), path.end(), "..")));
    }
    if (ups > deepest) {
        throw Failure(bad_input, "a path of its record leads up by " + std::to_string(ups) + " folders");
    }
    for (std::size_t i = 0; i < ups; ++i) {
        work_ /= "folder";
    }
    fs::create_directories(work_);
}

std::string InputLayout::add(const std::string& recorded, const fs::path& actual) {
    fs::path name = fs::path(recorded).lexically_normal();
    if (name.is_absolute()) {
        if (name == actual.lexically_normal()) {
            return recorded;
        }
        name = fs::path("elsewhere") / std::to_string(++elsewhere_) / name.filename();
    } else if (is_standard(recorded)) {
        name = "mesh";  // as slice names what comes from standard input
    }
    const fs::path link = work_ / name;
    if (!(link.lexically_normal().string() + "/").starts_with(top_.lexically_normal().string() + "/") ||
        !name.has_filename()) {
        throw Failure(bad_input, "its record names the input '" + recorded + "'");
    }
    fs::create_directories(link.parent_path());
    if (!fs::is_symlink(link)) {
        fs::create_symlink(actual, link);
    } else if (fs::read_symlink(link) != actual) {
        throw Failure(bad_input, "its record names two inputs '" + recorded + "'");
    }
    return name.string().starts_with('-') ? "./" + name.string() : name.string();
}

}  // namespace lamella::cli::verify
