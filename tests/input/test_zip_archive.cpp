// 3MF packages by how their zip archive lists the parts.
#include <catch2/catch.hpp>

#include "cpu_time.hpp"
#include "files.hpp"
#include "lamella/io/mesh_file.hpp"
#include "read.hpp"
#include "zip.hpp"

namespace lamella {
namespace {

using namespace input_test;

const std::vector<ZipPart>& cube_parts() {
    static const std::vector<ZipPart> parts = {
        content_types(), relationships(), {"3D/3dmodel.model", model_text(object(1, cube_mesh()), item(1))}};
    return parts;
}

std::string little_endian64(std::uint64_t value) {
    return little_endian(static_cast<std::uint32_t>(value)) + little_endian(static_cast<std::uint32_t>(value >> 32));
}

/// An archive whose sizes, offsets and counts all stand in ZIP64 fields.
std::string zip64(const std::vector<ZipPart>& parts) {
    const std::string elsewhere = little_endian(0xFFFFFFFF);
    const auto fields = [&](const ZipPart& part, const std::string& extra) {
        const std::string usual =
            zip_fields(part, 0);  // version, flags, method, time, checksum; two sizes; lengths of names
        return usual.substr(0, 14) + elsewhere + elsewhere + usual.substr(22, 2) +
               little_endian16(static_cast<std::uint16_t>(extra.size()));
    };
    const auto extra_field = [](const std::string& numbers) {
        return little_endian16(1) + little_endian16(static_cast<std::uint16_t>(numbers.size())) + numbers;
    };
    std::string archive;
    std::string directory;
    for (const ZipPart& part : parts) {
        const std::string packed = deflated(part.contents);
        const std::string sizes = little_endian64(part.contents.size()) + little_endian64(packed.size());
        const std::string known = extra_field(sizes);
        const std::string listed = extra_field(sizes + little_endian64(archive.size()));
        directory +=
            "PK\1\2" + little_endian16(45) + fields(part, listed) + std::string(10, '\0') + elsewhere + part.name + listed;
        archive += "PK\3\4" + fields(part, known) + part.name + known + packed;
    }
    const std::string count = little_endian64(parts.size());
    const std::string every = little_endian16(0xFFFF);
    return archive + directory + "PK\6\6" + little_endian64(44) + little_endian16(45) + little_endian16(45) +
           std::string(8, '\0') + count + count + little_endian64(directory.size()) + little_endian64(archive.size()) +
           "PK\6\7" + little_endian(0) + little_endian64(archive.size() + directory.size()) + little_endian(1) + "PK\5\6" +
           std::string(4, '\0') + every + every + elsewhere + elsewhere + little_endian16(0);
}

TEST_CASE("3MF packages with ZIP64 fields are read, between other bytes too", "[input][3mf]") {
    const TempFolder dir;
    const std::string bytes = zip64(cube_parts());
    const Result<MeshFile> mesh = read_mesh(dir.write("a.3mf", bytes));
    INFO((mesh ? std::string() : mesh.error().message));
    REQUIRE(mesh.ok());
    CHECK(mesh->triangle_count == 12);
    CHECK(mesh->warnings.empty());
    const Result<MeshFile> between = read_mesh(dir.write("a.3mf", "before" + bytes + "after"));
    REQUIRE(between.ok());
    const std::string name = (dir / "a.3mf").string();
    CHECK(between->warnings == std::vector<std::string>{name + ": ignored 6 bytes before the zip archive",
                                                        name + ": ignored 5 bytes after the zip archive"});
}

TEST_CASE("a zip directory that counts more than the file holds is refused", "[input][3mf]") {
    const TempFolder dir;
    const std::string bytes = zip64(cube_parts());
    const std::size_t record = bytes.rfind("PK\6\6");
    for (const std::uint64_t number : {~std::uint64_t{0}, std::uint64_t{1} << 40, std::uint64_t{100'000'000}}) {
        const std::string lie = little_endian64(number);
        const auto check = [&](std::size_t at, const std::string& lies) {
            std::string damaged = bytes;
            damaged.replace(record + at, lies.size(), lies);
            const Error error = read_error(dir.write("a.3mf", damaged));
            INFO(at << " " << number << " " << error.message);
            CHECK(error.code == ErrorCode::malformed_mesh);
            CHECK(error.message.find(": is damaged: its zip directory, which the end record at byte ") != std::string::npos);
        };
        check(24, lie + lie);  // parts
        check(40, lie);        // bytes of the directory
        check(48, lie);        // where it begins
    }
}

TEST_CASE("zip archives that would take libzip long are refused, and those at the limit do not take long", "[input][3mf]") {
    const TempFolder dir;
    const std::string refusal = ": is a zip archive of more than the 10000 parts or 16 directories that are read";
    std::vector<ZipPart> parts = cube_parts();
    // libzip's hash of a text is 33 times that of what precedes the last letter, and the letter: of "Ez" and "FY" the same.
    for (unsigned i = 0; parts.size() < 10'000; ++i) {
        std::string name;
        for (unsigned bit = 0; bit < 14; ++bit) {
            name += (i >> bit & 1U) != 0 ? "Ez" : "FY";
        }
        parts.push_back({name, "", false});
    }
    std::string bytes = zip(parts);
    const std::string end_record = bytes.substr(bytes.rfind("PK\5\6"));
    for (int i = 1; i < 16; ++i) {
        bytes += end_record;
    }
    const double start = cpu_ms();
    CHECK(read_mesh(dir.write("a.3mf", bytes)).ok());
    CHECK(cpu_ms() - start < 10'000);
    CHECK(read_error(dir.write("a.3mf", bytes + end_record)).message == (dir / "a.3mf").string() + refusal);
    parts.push_back({"x", "", false});
    CHECK(read_error(dir.write("a.3mf", zip(parts))).message == (dir / "a.3mf").string() + refusal);
}

}  // namespace
}  // namespace lamella
