// 3MF packages by how their zip archive lists the parts. With ZIP64 fields: tests/sloppy and the fuzzer's corpus.
#include "cpu_time.hpp"
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

TEST_CASE("a zip directory that counts more than the file holds is refused", "[input][3mf]") {
    const std::string bytes = zip(cube_parts());
    const std::size_t record = bytes.rfind("PK\5\6");
    for (const auto& [at, lie] : {std::pair{8U, little_endian(60'000U << 16 | 60'000U)},  // parts
                                  {12U, little_endian(100'000'000)},                      // bytes of the directory
                                  {16U, little_endian(100'000'000)}}) {                   // where it begins
        std::string damaged = bytes;
        damaged.replace(record + at, lie.size(), lie);
        const char* const says = ": is damaged: its zip directory, which the end record at byte ";
        CHECK(refuses(dir.write("a.3mf", damaged), says).code == ErrorCode::malformed_mesh);
    }
}

TEST_CASE("zip archives that would take libzip long are refused, and those at the limit do not take long", "[input][3mf]") {
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
