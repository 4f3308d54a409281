#include <chrono>
#include <cstdint>
#include <limits>
#include <string>

#include <sys/stat.h>
#include <unistd.h>

#include "read.hpp"

namespace lamella::input_test {

using Catch::Contains;

TEST_CASE("a binary file is kept as its bytes, colours too", "[input]") {
    const std::vector<Facet> facets = numbered_facets(5);
    const auto path = dir.write("a.stl", binary_stl(facets, 5, "COLOR=abcd", "\xff\x7f"));
    CHECK(read_facets(path) == facets);
    const MeshFile mesh = read_one(path);
    CHECK_FALSE(mesh.text);
    CHECK(mesh.stride == 50);
    CHECK(mesh.first_offset == 96);
    CHECK(mesh.bytes.size() == 84 + 5 * 50);
    CHECK(mesh.warnings.empty());
}

TEST_CASE("a binary file of several read pieces arrives whole", "[input][threads]") {
    const std::vector<Facet> facets = numbered_facets(400'000);  // 20 MB
    CHECK(read_facets(dir.write("large.stl", binary_stl(facets))) == facets);
}

TEST_CASE("a binary header may begin with \"solid\"", "[input]") {
    const std::vector<Facet> facets = numbered_facets(3);
    const std::string header = GENERATE(as<std::string>(), "solid part", "SOLID facet normal 0 0 0\n", "solid",
                                        std::string("solid") + std::string(75, ' '));
    CHECK(read_facets(dir.write("a.stl", binary_stl(facets, 3, header))) == facets);
}

TEST_CASE("bytes after the last counted record are ignored with a warning", "[input]") {
    const std::vector<Facet> facets = numbered_facets(3);
    const std::string header = GENERATE(as<std::string>(), "", "solid part");
    const std::size_t extra = GENERATE(1U, 49U, 50U, 1234U);
    const auto path = dir.write("a.stl", binary_stl(facets, 3, header) + std::string(extra, 'x'));
    CHECK(read_facets(path) == facets);
    CHECK_THAT(warnings_of(path).at(0), Contains(std::to_string(extra) + (extra == 1 ? " byte " : " bytes ")));
}

TEST_CASE("a count that the file does not hold is refused", "[input]") {
    const std::string header = GENERATE(as<std::string>(), "", "solid part");
    const std::uint32_t counted = GENERATE(6U, 1U << 24, std::numeric_limits<std::uint32_t>::max());
    const auto path = dir.write("a.stl", binary_stl(numbered_facets(5), counted, header));
    const Error error = refuses(path, std::to_string(counted) + " triangles", "has 334");
    CHECK(error.code == ErrorCode::malformed_mesh);
    CHECK(error.byte_offset == 80);
}

TEST_CASE("a binary file cut anywhere is refused", "[input]") {
    const std::string whole = binary_stl(numbered_facets(3), 3, "solid part");
    for (std::size_t length = 1; length < whole.size(); ++length) {
        INFO(length);
        const Result<MeshFile> mesh = read_mesh(dir.write("a.stl", whole.substr(0, length)));
        REQUIRE_FALSE(mesh.ok());
        const bool reads_as_ascii = length >= 5 && length <= 10;  // what is left of the header is a solid without facets
        CHECK(mesh.error().code == (reads_as_ascii ? ErrorCode::empty_mesh : ErrorCode::malformed_mesh));
    }
}

TEST_CASE("a binary STL of no triangles is an empty mesh", "[input]") {
    CHECK(read_error(dir.write("a.stl", "")).code == ErrorCode::empty_mesh);
    CHECK(read_error(dir.write("b.stl", binary_stl({}))).code == ErrorCode::empty_mesh);
    const auto behind = dir.write("c.stl", binary_stl(numbered_facets(2), 0));
    CHECK(refuses(behind, "0 triangles", "100 bytes").code == ErrorCode::malformed_mesh);
}

TEST_CASE("missing files, directories, FIFOs and devices are refused without waiting", "[input]") {
    CHECK(refuses(dir / "missing.stl", "No such file").code == ErrorCode::unreadable_file);

    std::filesystem::create_directory(dir / "directory.stl");
    refuses(dir / "directory.stl", "is a directory");

    REQUIRE(::mkfifo((dir / "fifo.stl").c_str(), 0600) == 0);
    refuses(dir / "fifo.stl", "is a FIFO");

    CHECK(refuses("/dev/zero", "is a device").code == ErrorCode::unreadable_file);
}

TEST_CASE("a header of 2^32 - 1 triangles is refused at once", "[input]") {
    const auto path = dir.write("sparse.stl", binary_stl({}, std::numeric_limits<std::uint32_t>::max()));
    std::filesystem::resize_file(path, std::uintmax_t{100} << 30);  // sparse: takes no room
    const auto start = std::chrono::steady_clock::now();
    CHECK(read_error(path).code == ErrorCode::malformed_mesh);
    CHECK(std::chrono::steady_clock::now() - start < std::chrono::seconds(1));
}

TEST_CASE("control characters in a file's name stay out of the message", "[input]") {
    CHECK_THAT(error_of(read_mesh("no\nsuch\tfile.stl")).message, Contains("no?such?file.stl: "));
}

}  // namespace lamella::input_test
