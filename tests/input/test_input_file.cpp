#include <filesystem>
#include <vector>

#include <catch2/catch.hpp>

#include "files.hpp"
#include "io/read/input_file.hpp"

namespace lamella::input_test {

using Catch::Contains;

TEST_CASE("a file that shrinks while it is read is an error", "[input]") {
    const TempFolder dir;
    const auto path = dir.write("a.stl", std::string(1000, 'x'));
    const Result<InputFile> file = InputFile::open(path);
    REQUIRE(file.ok());
    std::filesystem::resize_file(path, 10);
    std::vector<std::byte> bytes(file.value().size());
    const Status status = file.value().read(bytes, Parallel({.threads = 2}));
    REQUIRE_FALSE(status.ok());
    CHECK(status.error().code == ErrorCode::unreadable_file);
    CHECK_THAT(status.error().message, Contains("shrank"));
}

TEST_CASE("a file that changes after it was opened is an error", "[input]") {
    const TempFolder dir;
    const auto path = dir.write("a.stl", std::string(1000, 'x'));
    const Result<InputFile> file = InputFile::open(path);
    CHECK(file.value().unchanged().ok());
    SECTION("grown") {
        std::filesystem::resize_file(path, 2000);
    }
    SECTION("shrunk") {
        std::filesystem::resize_file(path, 10);
    }
    SECTION("written") {
        std::filesystem::last_write_time(path, std::filesystem::last_write_time(path) + std::chrono::seconds(1));
    }
    REQUIRE_FALSE(file.value().unchanged().ok());
    CHECK(file.value().unchanged().error().code == ErrorCode::unreadable_file);
}

}  // namespace lamella::input_test
