// 3MF packages that are damaged or made to harm are refused. How archives list parts with ZIP64 fields: tests/sloppy and the
// fuzzer.
#include "cpu_time.hpp"
#include "engine/counting_memory.hpp"
#include "read.hpp"
#include "zip.hpp"

namespace lamella {
namespace {

using namespace input_test;

std::string good_model() {
    return model_text(object(1, cube_mesh()), item(1));
}

void refused(const std::string& bytes, const std::string& says, ErrorCode code = ErrorCode::malformed_mesh) {
    refuses(dir.write("a.3mf", bytes), ": " + says, code);
}

/// The root part is this one.
void root_refused(ZipPart root, const std::string& says) {
    refused(zip({content_types(), relationships(), std::move(root)}), "part '3D/3dmodel.model' " + says);
}

TEST_CASE("a 3MF file that ends anywhere but at its end is refused", "[input][3mf]") {
    const std::string bytes = package(good_model());
    refuses_cuts("a.3mf", bytes, 4, bytes.size());
    refused(bytes.substr(0, bytes.size() - 1), "is truncated or no zip archive");
}

TEST_CASE("a 3MF file with any byte changed is read alike or refused", "[input][3mf]") {
    const std::string bytes = package(good_model());
    std::size_t refused = 0;
    for (std::size_t at = 0; at < bytes.size(); ++at) {
        std::string damaged = bytes;
        damaged[at] = static_cast<char>(damaged[at] ^ (1 << at % 8));
        const Result<MeshFile> mesh = read_mesh(dir.write("a.3mf", damaged), {}, {.threads = 1});
        refused += mesh.ok() ? 0U : 1U;
        CHECK((!mesh.ok() || mesh->triangle_count == 12));
    }
    CHECK(refused > bytes.size() / 2);
}

TEST_CASE("damaged archives and malformed parts have different messages", "[input][3mf]") {
    const std::string name = "3D/3dmodel.model";
    const std::string good = good_model();
    root_refused({.name = name, .contents = good, .false_crc = 1}, "is damaged: its checksum differs");
    root_refused({.name = name, .contents = "not XML", .false_crc = 1}, "is damaged: its checksum differs");
    root_refused({.name = name, .contents = good, .excess_bytes = 10},
                 "is damaged: " + std::to_string(good.size()) + " bytes, of which");
    root_refused({.name = name, .contents = good, .flags = 1}, "is encrypted");
    root_refused({.name = name, .contents = good, .method = 12}, "is compressed by method 12, which is not deflate");
    root_refused({.name = name, .contents = good, .deflated = false, .method = 8}, "is damaged: no valid deflate data");
}

TEST_CASE("archives that are no 3MF packages are refused", "[input][3mf]") {
    refused("PK\3\4" + zip({}), "is a zip archive without any part");
    refused(zip({{"readme.txt", "a mesh"}}), "part '_rels/.rels' is missing");
    for (const std::string name : {"mesh.stl", "a/mesh.OBJ", "mesh.ply.gz", "mesh.3mf"}) {
        refused(zip({{"readme.txt", "a mesh"}, {name, ascii_stl(numbered_facets(3))}, {"b.stl", ""}}),
                "part '" + name + "' is a mesh in a zip archive that is no 3MF package: unpack it first");
    }
    refused(zip({content_types(), relationships()}), "part '3D/3dmodel.model' is missing");
    refused(zip({relationships(), relationships()}), "part '_rels/.rels' is there twice");
    refused(zip({{"_rels/.rels", "<a/>"}}), "part '_rels/.rels' names no model: is no 3MF package");
    refused(zip({{"_rels/.rels", ""}}), "part '_rels/.rels', line 1: malformed XML: no element found");
    const std::string second =
        "\n<Relationship Target=\"b\" Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/>";
    refused(zip({relationships("a", second)}), "part '_rels/.rels', line 2: a second model");
    for (const std::string path :
         {"../a.model", "/3D/../../a.model", "3D//a", "/", "", ".", "C:/a", "3D\\a", "file:///a", "a/"}) {
        refused(zip({relationships(path), {path, good_model()}}),
                "part '_rels/.rels', line 1: the model is no part of the package");
    }
}

TEST_CASE("a zip directory that counts more than the file holds is refused", "[input][3mf]") {
    const std::string bytes = package(good_model());
    const std::size_t record = bytes.rfind("PK\5\6");
    for (const auto& [at, lie] : {std::pair{8U, little_endian(60'000U << 16 | 60'000U)},  // parts
                                  {12U, little_endian(100'000'000)},                      // bytes of the directory
                                  {16U, little_endian(100'000'000)}}) {                   // where it begins
        std::string damaged = bytes;
        damaged.replace(record + at, lie.size(), lie);
        refused(damaged, "is damaged: its zip directory, which the end record at byte ");
    }
}

TEST_CASE("zip archives that would take libzip long are refused, and those at the limit do not take long", "[input][3mf]") {
    const std::string says = "is a zip archive of more than the 10000 parts or 16 directories that are read";
    std::vector<ZipPart> parts = {content_types(), relationships(), {"3D/3dmodel.model", good_model()}};
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
    refused(bytes + end_record, says);
    parts.push_back({"x", "", false});
    refused(zip(parts), says);
}

TEST_CASE("only the root part refers to others, and what it refers to is there", "[input][3mf]") {
    const auto referring = [](int id) { return model_text("", item(id, "p:path=\"/b.model\"")); };
    refused(package(referring(1)), "part 'b.model' is missing");
    refused(package(referring(7), {{"b.model", good_model()}}),
            "part '3D/3dmodel.model', line 6: there is no object 7 in the part that it names");
    const std::string nested = object(1, components({R"(objectid="1" p:path="/3D/3dmodel.model")"}));
    refused(package(referring(1), {{"b.model", model_text(nested, "")}}),
            "part 'b.model', line 4: refers to another part, which only the root part may");
    const std::string inches = model_text(object(1, cube_mesh()), "", "unit=\"inch\"");
    refused(package(referring(1), {{"b.model", inches}}), "part 'b.model' has another unit than the root part");
    const std::string empty = object(1, "<mesh><vertices/><triangles/></mesh>") + object(2, "");
    const std::string support = object(3, cube_mesh(), "type=\"support\"");
    refused(package(model_text(empty + support, item(1) + item(2) + item(3))),
            "holds nothing solid: left out 1 support: 'object 3'", ErrorCode::empty_mesh);
}

TEST_CASE("components that contain themselves are refused", "[input][3mf]") {
    const auto of = [](int id) { return components({"objectid=\"" + std::to_string(id) + "\""}); };
    const std::string in_root = "part '3D/3dmodel.model', line 4: ";
    refused(package(model_text(object(1, of(1)), item(1))), in_root + "object 1 is a component of itself");
    const std::string ring = object(1, of(2)) + object(2, of(3)) + object(3, of(1));
    refused(package(model_text(ring, item(2))), in_root + "object 2 is a component of itself");
    // Not in the build, and so of no concern.
    CHECK(read_mesh(dir.write("a.3mf", package(model_text(ring + object(4, cube_mesh()), item(4))))).ok());
}

/// `levels` objects, each of which is the one before `times` times; the first is `seed`.
std::string tower(int levels, int times, const std::string& seed, const std::string& items = "") {
    std::string resources = object(1, seed);
    for (int id = 2; id <= levels; ++id) {
        resources += object(id, components(std::vector<std::string>(static_cast<std::size_t>(times),
                                                                    "objectid=\"" + std::to_string(id - 1) + "\"")));
    }
    return package(model_text(resources, items + item(levels)));
}

TEST_CASE("more instances and steps than any machine holds are counted and refused", "[input][3mf]") {
    const std::string one_triangle =
        "<mesh><vertices><vertex x=\"0\" y=\"0\" z=\"0\"/></vertices><triangles>"
        "<triangle v1=\"0\" v2=\"0\" v3=\"0\"/></triangles></mesh>";
    std::string items;
    for (int i = 0; i < 2000; ++i) {
        items += item(3000);
    }
    for (const std::string& bytes :
         {tower(41, 2, cube_mesh()), tower(200, 9, cube_mesh()), tower(3000, 1, one_triangle, items)}) {
        refuses(dir.write("a.3mf", bytes), " builds more than the ", ErrorCode::out_of_memory);
    }
    // Of nothing there may be any number.
    refused(tower(200, 9, "<mesh/>"), "holds no triangles", ErrorCode::empty_mesh);
    // A chain is as deep as it is long, and each link is one step.
    CHECK(read_one(dir.write("a.3mf", tower(20000, 1, cube_mesh()))).triangle_count == 12);
}

TEST_CASE("3MF without memory is an error and leaks nothing", "[input][3mf]") {
    const auto path = dir.write("a.3mf", tower(4, 3, cube_mesh()));
    std::size_t failures = 0;
    for (std::size_t limit = 0;; limit += 512) {
        CountingMemory memory(limit);
        {
            const Result<MeshFile> mesh = read_mesh(path, {}, {.memory = &memory});
            if (mesh.ok()) {
                break;
            }
            REQUIRE(mesh.error().code == ErrorCode::out_of_memory);
        }
        REQUIRE(memory.held() == 0);
        ++failures;
    }
    CHECK(failures > 10);
}

}  // namespace
}  // namespace lamella
