#include <filesystem>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "files.hpp"
#include "io/read/input_file.hpp"

namespace lamella::input_test {

using Catch::Contains;

TEST_CASE("a file that shrinks while it is read is an error", "[input]") {
    const TempFolder dir;
    const auto path = dir.write("a.stl", std::string(1000, 'x'));
    const InputFile file = value_of(InputFile::open(path));
    std::filesystem::resize_file(path, 10);
    std::vector<std::byte> bytes(file.size());
    const Error error = error_of(file.read(bytes, Parallel({.threads = 2})));
    CHECK(error.code == ErrorCode::unreadable_file);
    CHECK_THAT(error.message, Contains("shrank"));
}

TEST_CASE("a file that changes after it was opened is an error", "[input]") {
    const TempFolder dir;
    const auto path = dir.write("a.stl", std::string(1000, 'x'));
    const InputFile file = value_of(InputFile::open(path));
    CHECK(file.unchanged().ok());
    SECTION("grown") {
        std::filesystem::resize_file(path, 2000);
    }
    SECTION("shrunk") {
        std::filesystem::resize_file(path, 10);
    }
    SECTION("written") {
        std::filesystem::last_write_time(path, std::filesystem::last_write_time(path) + std::chrono::seconds(1));
    }
    CHECK(code_of(file.unchanged()) == ErrorCode::unreadable_file);
}

}  // namespace lamella::input_test
