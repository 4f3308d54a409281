// Files that are written appear whole or not at all, any name as UTF-8, and meshes come back as they were.
#include <set>

#include <fcntl.h>
#include <unistd.h>

#include "engine/slicing.hpp"
#include "input/read.hpp"
#include "io/write/output_file.hpp"
#include "lamella/io/layer_file.hpp"
#include "lamella/io/mesh_writer.hpp"
#include "lamella/io/name_text.hpp"
#include "lamella/io/text_file.hpp"
#include "temp_folder.hpp"

using namespace lamella;
using input_test::triangles_of;

namespace {

using Names = std::vector<std::string>;

void require_unwritable(const Status& status, const std::filesystem::path& path, const std::string& reason) {
    CHECK(error_of(status).code == ErrorCode::unwritable_file);
    CHECK(status.error().message == "cannot write '" + path.string() + "': " + reason);
}

MeshFile read_back(const std::filesystem::path& path) {
    MeshFile mesh = input_test::read_one(path);
    CHECK(mesh.warnings.empty());
    return mesh;
}

/// A tetrahedron of doubles with a vertex that may be no float, in a patient frame.
MeshFile tetrahedron(const TempFolder& folder, const std::string& number) {
    return read_back(folder.write(
        "a.off", "# SPACE=RAS\nOFF\n4 4 0\n0 0 0\n" + number + " 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n"));
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
    require_unwritable(done(write_layers(SliceResult(), "/dev/full", {.format = "svg"})), "/dev/full",
                       "No space left on device");
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

TEST_CASE("a mesh written as PLY keeps its vertices, indices and doubles, and soup gets three vertices a triangle",
          "[write][mesh_writer]") {
    const TempFolder folder;
    const MeshFile mesh = tetrahedron(folder, "1.1");
    CHECK_FALSE(value_of(write_mesh(mesh, folder / "b.PLY")).rounded);
    const MeshFile back = read_back(folder / "b.PLY");
    CHECK(back.vertex_type == Number::f64);
    CHECK(back.vertex_count == 4);
    CHECK(back.patient_frame == PatientFrame::ras);
    CHECK(std::equal(back.indices.begin(), back.indices.end(), mesh.indices.begin(), mesh.indices.end()));
    CHECK(triangles_of(back) == triangles_of(mesh));
    REQUIRE(write_mesh(mesh, folder / "soup.stl").ok());
    const MeshFile soup = read_back(folder / "soup.stl");
    REQUIRE(write_mesh(soup, folder / "c.ply").ok());
    CHECK(read_back(folder / "c.ply").vertex_count == 12);
    CHECK(triangles_of(read_back(folder / "c.ply")) == triangles_of(soup));
}

TEST_CASE("a mesh written as STL is one of floats, and says whether that rounded it", "[write][mesh_writer]") {
    const TempFolder folder;
    const std::string number = GENERATE("1.5", "1.1");
    const MeshFile mesh = tetrahedron(folder, number);
    CHECK(value_of(write_mesh(mesh, folder / "b.stl")).rounded == (number == "1.1"));
    input_test::Triangles expected = triangles_of(mesh);
    for (auto& triangle : expected) {
        for (double& coordinate : triangle) {
            coordinate = static_cast<double>(static_cast<float>(coordinate));
        }
    }
    CHECK(triangles_of(read_back(folder / "b.stl")) == expected);
    CHECK(read_back(folder / "b.stl").patient_frame == PatientFrame::ras);
}

TEST_CASE("a mesh that cannot be written leaves no file", "[write][mesh_writer]") {
    const TempFolder folder;
    const MeshFile mesh = tetrahedron(folder, "1e39");
    const Error beyond = write_mesh(mesh, folder / "b.stl").error();
    CHECK(beyond.code == ErrorCode::invalid_argument);
    CHECK(beyond.message == "cannot write '" + (folder / "b.stl").string() +
                                "': a coordinate is too large for the floats of STL; PLY takes it");
    CHECK(write_mesh(mesh, folder / "b.obj").error().code == ErrorCode::invalid_argument);
    CHECK(write_mesh(mesh, folder / "none" / "b.ply").error().code == ErrorCode::unwritable_file);
    auto stop = []() noexcept { return true; };
    CHECK(write_mesh(mesh, folder / "b.ply", {.stop = stop}).error().code == ErrorCode::cancelled);
    CHECK(folder.names() == std::vector<std::string>{"a.off"});
}
