// Files that are written appear whole or not at all; and any name as UTF-8.
#include <set>

#include <fcntl.h>
#include <unistd.h>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "io/write/output_file.hpp"
#include "lamella/io/name_text.hpp"
#include "lamella/io/svg.hpp"
#include "lamella/io/text_file.hpp"
#include "temp_folder.hpp"

using namespace lamella;

namespace {

using Names = std::vector<std::string>;

void require_unwritable(const Status& status, const std::filesystem::path& path, const std::string& reason) {
    CHECK(error_of(status).code == ErrorCode::unwritable_file);
    CHECK(status.error().message == "cannot write '" + path.string() + "': " + reason);
}

}  // namespace

TEST_CASE("output: until it is committed the old file stands, and an abandoned one leaves no trace", "[write]") {
    const TempFolder folder;
    const std::string text(3 * OutputFile::buffer_bytes + 17, 'x');
    REQUIRE(write_text_file(folder / "a", text).ok());
    {
        OutputFile file = value_of(OutputFile::create(folder / "a"));
        file.append("new");
        CHECK(folder.names().size() == 2);
        CHECK(bytes_of(folder / "a") == text);
    }
    CHECK(folder.names() == Names{"a"});
    CHECK(bytes_of(folder / "a") == text);
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
    CHECK(folder.names() == Names{".a.1-2.part", "a", "link"});
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
    CHECK(folder.names() == Names{"a"});
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
    CHECK(folder.names() == Names{"a"});
    require_unwritable(write_text_file(path, "x"), path, "Bad file descriptor");
}

TEST_CASE("output: what cannot be written is known before the end, with the file and the reason", "[write]") {
    OutputFile full = value_of(OutputFile::create("/dev/full"));
    const std::string text(OutputFile::buffer_bytes, 'x');
    full.append(text);
    CHECK_FALSE(full.failed());
    full.append(text);
    CHECK(full.failed());
    const TempFolder folder;
    require_ok(write_text_file(folder / "a", "x"));
    for (const auto& [path, reason] :
         {std::pair<std::filesystem::path, const char*>{folder / "none" / "a", "No such file or directory"},
          {folder.path(), "Is a directory"},
          {folder / "a" / "b", "Not a directory"},
          {"/dev/full", "No space left on device"}}) {
        require_unwritable(write_text_file(path, "x"), path, reason);
    }
    require_unwritable(write_svg(SliceResult(), "/dev/full"), "/dev/full", "No space left on device");
    CHECK(std::filesystem::is_character_file("/dev/full"));
    // The folder goes away meanwhile.
    const auto path = folder / "gone" / "a";
    std::filesystem::create_directory(path.parent_path());
    OutputFile file = value_of(OutputFile::create(path));
    std::filesystem::remove_all(path.parent_path());
    require_unwritable(file.commit(), path, "No such file or directory");
    CHECK(folder.names() == Names{"a"});
}

TEST_CASE("names: any bytes become UTF-8 and come back", "[write]") {
    CHECK(text_of_name("l\xe4rm.stl") == "l\\xe4rm.stl");
    CHECK(text_of_name("l\xc3\xa4rm\\a.stl") == "l\xc3\xa4rm\\a.stl");
    CHECK(text_of_name("\\xe4") == "\\x5cxe4");
    CHECK(text_of_name("\\x5cxe4") == "\\x5cx5cxe4");
    CHECK(name_of_text("\\x41\\xE4\\xg0\\x5") == "\\x41\xe4\\xg0\\x5");
    const std::string parts[] = {"\\", "x", "e4", "5c", "\xe4", "\xc3\xa4", "4", "\xff", "-"};
    std::set<std::string> texts;
    std::set<std::string> names;
    for (int code = 0; code < 9 * 9 * 9 * 9; ++code) {
        const std::string name = parts[code % 9] + parts[code / 9 % 9] + parts[code / 81 % 9] + parts[code / 729];
        const std::string text = text_of_name(name);
        REQUIRE(name_of_text(text) == name);
        REQUIRE(utf8_text(text) == text);
        names.insert(name);
        texts.insert(text);
    }
    CHECK(texts.size() == names.size());
    CHECK(printable("a\n\xff\x7f\xc3\xa4") == "a?\\xff?\xc3\xa4");
}
