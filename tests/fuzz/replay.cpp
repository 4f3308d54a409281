// Runs a fuzz target on the named files and on the files in the named folders. The corpus of the fuzzers becomes a test
// for any compiler.
#include "bytes.hpp"
#include "temp_folder.hpp"

namespace {

namespace fs = std::filesystem;

std::vector<fs::path> files_in(const fs::path& path) {
    if (!fs::is_directory(path)) {
        return {path};
    }
    std::vector<fs::path> files(fs::directory_iterator(path), fs::directory_iterator{});
    std::sort(files.begin(), files.end());
    return files;
}

}  // namespace

int main(int count, char** words) {
    std::size_t replayed = 0;
    for (int i = 1; i < count; ++i) {
        for (const fs::path& file : files_in(words[i])) {
            // Printed before the run: after a failure, the last name is the input that failed.
            (void)std::fprintf(stderr, "%s\n", file.c_str());
            fuzz::require(fs::is_regular_file(file), "the corpus can be read");
            const std::string bytes = bytes_of(file);
            (void)LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
            ++replayed;
        }
    }
    fuzz::require(replayed > 0, "there is a corpus");
    std::printf("%zu inputs replayed\n", replayed);
    return 0;
}
