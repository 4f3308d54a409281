#include <filesystem>
#include <string>

#include <fcntl.h>
#include <unistd.h>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "io/write/output_file.hpp"
#include "lamella/io/svg.hpp"
#include "lamella/io/text_file.hpp"
#include "temp_folder.hpp"
#include "write/samples.hpp"

using namespace lamella;

namespace {

void require_unwritable(const Status& status, const std::filesystem::path& path, const std::string& reason) {
    CHECK(error_of(status).code == ErrorCode::unwritable_file);
    CHECK(status.error().message == "cannot write '" + path.string() + "': " + reason);
}

}  // namespace

TEST_CASE("output: the file holds the text, and no other file is left", "[write]") {
    const TempFolder folder;
    const std::string text(3 * OutputFile::buffer_bytes + 17, 'x');
    REQUIRE(write_text_file(folder / "a", text).ok());
    CHECK(bytes_of(folder / "a") == text);
    CHECK(folder.names() == std::vector<std::string>{"a"});
}

TEST_CASE("output: until it is committed the old file stands, and an abandoned one leaves no trace", "[write]") {
    const TempFolder folder;
    REQUIRE(write_text_file(folder / "a", "old").ok());
    {
        OutputFile file = value_of(OutputFile::create(folder / "a"));
        file.append("new");
        CHECK(folder.names().size() == 2);
        CHECK(bytes_of(folder / "a") == "old");
    }
    CHECK(folder.names() == std::vector<std::string>{"a"});
    CHECK(bytes_of(folder / "a") == "old");
}

TEST_CASE("output: what is unfinished of one file can be removed, and nothing else", "[write]") {
    const TempFolder folder;
    REQUIRE(write_text_file(folder / "a", "old").ok());
    REQUIRE(write_text_file(folder / ".a.1-2.part", "another process's").ok());
    std::filesystem::create_symlink("a", folder / "link");
    const OutputFile through_link = value_of(OutputFile::create(folder / "link"));
    const OutputFile other = value_of(OutputFile::create(folder / "b"));
    REQUIRE(folder.names().size() == 5);
    remove_unfinished(folder / "link");
    CHECK(folder.names().size() == 4);
    remove_unfinished(folder / "b");
    remove_unfinished(folder / "none" / "c");
    remove_unfinished("");
    CHECK(folder.names() == std::vector<std::string>{".a.1-2.part", "a", "link"});
    CHECK(bytes_of(folder / "a") == "old");
}

TEST_CASE("output: two writers of one file do not disturb each other", "[write]") {
    const TempFolder folder;
    OutputFile one = value_of(OutputFile::create(folder / "a"));
    OutputFile two = value_of(OutputFile::create(folder / "a"));
    one.append("one");
    two.append("two");
    require_ok(one.commit());
    CHECK(bytes_of(folder / "a") == "one");
    require_ok(two.commit());
    CHECK(bytes_of(folder / "a") == "two");
    CHECK(folder.names() == std::vector<std::string>{"a"});
}

TEST_CASE("output: a replaced file keeps its mode, a link keeps pointing", "[write]") {
    const TempFolder folder;
    REQUIRE(write_text_file(folder / "a", "old").ok());
    std::filesystem::permissions(folder / "a", std::filesystem::perms(0640));
    std::filesystem::create_symlink("a", folder / "link");
    REQUIRE(write_text_file(folder / "link", "new").ok());
    CHECK(std::filesystem::is_symlink(folder / "link"));
    CHECK(bytes_of(folder / "a") == "new");
    CHECK(std::filesystem::status(folder / "a").permissions() == std::filesystem::perms(0640));
}

TEST_CASE("output: an open descriptor is written on from where it stands, and stays open", "[write]") {
    const TempFolder folder;
    const int descriptor = ::open((folder / "a").c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
    REQUIRE(descriptor >= 0);
    REQUIRE(::write(descriptor, "before ", 7) == 7);
    const std::filesystem::path path = "/dev/fd/" + std::to_string(descriptor);
    REQUIRE(write_text_file(path, "written ").ok());
    REQUIRE(::write(descriptor, "after", 5) == 5);
    ::close(descriptor);
    CHECK(bytes_of(folder / "a") == "before written after");
    CHECK(folder.names() == std::vector<std::string>{"a"});
    require_unwritable(write_text_file(path, "x"), path, "Bad file descriptor");
}

TEST_CASE("output: what cannot be written is known before the end", "[write]") {
    OutputFile file = value_of(OutputFile::create("/dev/full"));
    const std::string text(OutputFile::buffer_bytes, 'x');
    file.append(text);
    CHECK_FALSE(file.failed());
    file.append(text);
    CHECK(file.failed());
}

TEST_CASE("output: errors name the file and the reason", "[write]") {
    const TempFolder folder;
    const auto refused = [](const std::filesystem::path& path, const std::string& reason) {
        require_unwritable(write_text_file(path, "x"), path, reason);
    };
    SECTION("a folder that is none") {
        refused(folder / "none" / "a", "No such file or directory");
        refused(folder.path(), "Is a directory");
        require_ok(write_text_file(folder / "a", "x"));
        refused(folder / "a" / "b", "Not a directory");
    }
    SECTION("a full disk, in the SVG writer too") {
        refused("/dev/full", "No space left on device");
        require_unwritable(write_svg(write_test::square_with_hole(), "/dev/full"), "/dev/full", "No space left on device");
        CHECK(std::filesystem::is_character_file("/dev/full"));
    }
    SECTION("the folder goes away meanwhile") {
        const auto path = folder / "gone" / "a";
        std::filesystem::create_directory(path.parent_path());
        OutputFile file = value_of(OutputFile::create(path));
        std::filesystem::remove_all(path.parent_path());
        require_unwritable(file.commit(), path, "No such file or directory");
    }
    CHECK(folder.names().size() <= 1);
}
