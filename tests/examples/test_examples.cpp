// The examples of headers and pages, run. What they print is kept in printed.txt, which LAMELLA_UPDATE_GOLDEN=1 writes anew.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <string>

#include <fcntl.h>
#include <unistd.h>
#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "examples/examples.hpp"
#include "input/files.hpp"
#include "lamella/io.hpp"
#include "temp_folder.hpp"

namespace {

/// In a folder of its own, with standard output going to a file there.
class Stage {
public:
    Stage() : before_(std::filesystem::current_path()) {
        std::filesystem::current_path(folder_.path());
        std::fflush(stdout);
        terminal_ = ::dup(STDOUT_FILENO);
        const int file = ::open("printed.txt", O_CREAT | O_WRONLY | O_TRUNC, 0600);
        ::dup2(file, STDOUT_FILENO);
        ::close(file);
    }
    ~Stage() { close(); }
    const TempFolder& folder() const { return folder_; }
    Stage(const Stage&) = delete;
    Stage& operator=(const Stage&) = delete;

    std::string close() {
        if (terminal_ >= 0) {
            std::fflush(stdout);
            ::dup2(terminal_, STDOUT_FILENO);
            ::close(terminal_);
            terminal_ = -1;
            printed_ = bytes_of("printed.txt");
            std::filesystem::current_path(before_);
        }
        return printed_;
    }

private:
    std::filesystem::path before_;
    TempFolder folder_;
    int terminal_ = -1;
    std::string printed_;
};

/// Without what differs from run to run and from machine to machine: times, and bytes that depend on the threads.
std::string what_lasts(std::string printed) {
    for (const char* passing : {"(\n    \"(bucket|sweep|contours|nesting|fill|report)\": )[-0-9.e]+",
                                "(\"threads\": )[0-9]+", "()[0-9]+(?= bytes)"}) {
        printed = std::regex_replace(printed, std::regex(passing), "$1*");
    }
    return printed;
}

}  // namespace

TEST_CASE("the examples of headers and pages print what is kept", "[examples]") {
    const shapes::Soup soup =
        shapes::joined({shapes::box({0, 0, 0}, {8, 7, 6}), shapes::flipped(shapes::box({2, 2, 2}, {6, 5, 4}))});
    const lamella::SliceResult result = sliced(soup, uniform(1));
    Stage stage;
    for (const char* name : {"liver.stl", "one.stl"}) {
        stage.folder().write(name, lamella::input_test::text_stl(soup, "box"));
    }
    for (const Example& example : all_examples()) {
        std::printf("== %s\n", example.place.c_str());
        lamella::SliceOptions options = uniform(1);
        example.run(view_of(soup), result, options);
    }
    const std::string printed = what_lasts(stage.close());
    const std::filesystem::path kept = LAMELLA_EXAMPLES_PRINT;
    if (std::getenv("LAMELLA_UPDATE_GOLDEN") != nullptr) {
        std::ofstream(kept, std::ios::binary) << printed;
    }
    CHECK(printed == bytes_of(kept));
}
