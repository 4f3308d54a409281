// 3MF packages that are large, damaged or made to harm. All else: cases/packages.txt, cases/3mf.txt. How archives list parts
// with ZIP64 fields: tests/sloppy and the fuzzer.
#include <map>

#include "cpu_time.hpp"
#include "engine/counting_memory.hpp"
#include "read.hpp"

namespace lamella::input_test {

namespace {

std::string cube_object(int id = 1) {
    return object(id, mesh_xml(triangulated(cube())));
}

std::string good_package() {
    return package(model_text(cube_object(), item(1)));
}

void refuses_package(const std::string& bytes, const std::string& says, ErrorCode code = ErrorCode::malformed_mesh) {
    refuses(dir.write("a.3mf", bytes), ": " + says, code);
}

TEST_CASE("a 3MF cube is read as it was written, in the file's unit and not the caller's", "[input][3mf]") {
    const auto path = dir.write("a.3mf", package(model_text(cube_object(), item(1), "unit=\"inch\"")));
    const MeshFile mesh = value_of(read_mesh(path, {.mm_per_unit = 7}));
    CHECK(mesh.format == MeshFormat::three_mf);
    CHECK(name_of(mesh.format) == "3MF");
    CHECK(mesh.vertex_count == 8);
    CHECK(mesh.mm_per_unit == 25.4);
    CHECK(triangles_of(mesh) == cube(254).triangles());
}

TEST_CASE("all instances of a 3MF mesh of several chunks are placed", "[input][3mf]") {
    PolygonMesh strip;
    for (int v = 0; v < 70000; ++v) {  // more than a chunk holds
        strip.xyz.insert(strip.xyz.end(), {double(v), double(v % 7), 1});
        if (v > 1) {
            strip.faces.push_back({v - 2, v - 1, v});
        }
    }
    const std::string items = item(1) + item(2) + item(1, "transform=\"1 0 0 0 1 0 0 0 -1 0 0 0\"");
    const std::string resources = object(1, mesh_xml(strip)) + cube_object(2);
    const Contents contents = read(dir.write("a.3mf", package(model_text(resources, items))));
    CHECK(contents.mesh.vertex_count == 2 * strip.points() + 8);
    Triangles expected = strip.triangles();
    REQUIRE(contents.triangles.size() == 2 * expected.size() + 12);
    CHECK(std::equal(expected.begin(), expected.end(), contents.triangles.begin()));
    for (auto& t : expected) {  // the second instance, in which z is negative and triangles are reversed
        t = {t[0], t[1], -1, t[6], t[7], -1, t[3], t[4], -1};
    }
    CHECK(std::equal(expected.begin(), expected.end(), contents.triangles.begin() + std::ssize(expected)));
}

TEST_CASE("a 3MF file's negative volume is cut out of its own object, and modifiers label", "[input][3mf][roles]") {
    const auto component = [](const char* transform) {
        return "<component objectid=\"1\" transform=\"" + std::string(transform) + "\"/>";
    };
    const std::string stage = "<components>" + component("1 0 0 0 1 0 0 0 1 0 0 0") +
                              component(".5 0 0 0 .5 0 0 0 .5 2 2 -1") + component("1 0 0 0 1 0 0 0 1 6 0 0") +
                              "</components>";
    const std::string resources = cube_object(1) + object(2, stage) + cube_object(3);
    std::vector<ZipPart> parts = package_parts(model_text(resources, item(2) + item(3)));
    parts.push_back(
        {"Metadata/model_settings.config",
         "<config><object id=\"2\"><part id=\"1\" subtype=\"normal_part\"/><part id=\"1\" subtype=\"negative_part\"/>"
         "<part id=\"1\" subtype=\"modifier_part\"/></object></config>"});
    const auto path = dir.write("a.3mf", zip(parts));
    const MeshFile solid = value_of(read_mesh(path));
    CHECK(solid.warnings.size() == 2);
    CHECK(parts_of(solid).size() == 2);
    CHECK(value_of(slice(solid, {.heights_mm = {{2.0}}}))[0].area_mm2() == 200);
    const MeshFile file = value_of(read_mesh(path, {.all_roles = true}));
    CHECK(file.warnings.empty());
    CHECK(file.triangle_count == 24);
    CHECK(triangles_of(file) == triangles_of(solid));
    const std::vector<Part> all = parts_of(file);
    REQUIRE(all.size() == 4);
    CHECK((all[2].role == PartRole::negative && all[3].role == PartRole::modifier));
    CHECK((all[0].object == all[2].object && all[0].object == all[3].object && all[0].object != all[1].object));
    const SliceResult cut = value_of(slice(all, {.heights_mm = {{2.0, 8.0}}}));
    std::map<std::pair<std::size_t, std::uint32_t>, double> mm2;
    for (const LayerView layer : cut) {
        for (const Contour& contour : layer.contours) {
            mm2[{layer.index, contour.part}] += layer.area_mm2(contour);
        }
    }
    // Of layer 0 the modifier has what lies from x = 6 on, but for what is taken out up to x = 7.
    CHECK(mm2 == decltype(mm2){{{0, 0}, 40}, {{0, 1}, 100}, {{0, 3}, 35}, {{1, 0}, 60}, {{1, 1}, 100}, {{1, 3}, 40}});
}

TEST_CASE("bytes around a zip archive give a warning, its comment does not", "[input][3mf]") {
    const std::string whole = good_package();
    const auto warnings = [](const std::string& bytes) { return warnings_of(dir.write("a.3mf", bytes)); };
    CHECK(warnings(whole + std::string(5, '\0')) == Texts{"ignored 5 bytes after the zip archive"});
    CHECK(warnings(std::string(7, '\x01') + whole + "tail") ==
          Texts{"ignored 7 bytes before the zip archive", "ignored 4 bytes after the zip archive"});
    std::string with_comment = whole + "a comment";
    with_comment[whole.size() - 2] = 9;
    CHECK(warnings(with_comment).empty());
}

TEST_CASE("a 3MF file with any byte changed is read alike or refused", "[input][3mf]") {
    const std::string bytes = good_package();
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

TEST_CASE("a zip directory that counts more than the file holds is refused", "[input][3mf]") {
    const std::string bytes = good_package();
    refuses_package("PK\3\4" + zip({}), "is a zip archive without any part");
    refuses_package(bytes.substr(0, bytes.size() - 1), "is truncated or no zip archive");
    const std::size_t record = bytes.rfind("PK\5\6");
    for (const auto& [at, lie] : {std::pair{8U, 60'000U << 16 | 60'000U},  // parts
                                  {12U, 100'000'000U},                     // bytes of the directory
                                  {16U, 100'000'000U}}) {                  // where it begins
        refuses_package(std::string(bytes).replace(record + at, 4, input_test::bytes_of(lie)),
                        "is damaged: its zip directory, which the end record at byte ");
    }
}

TEST_CASE("zip archives that would take libzip long are refused, and those at the limit do not take long", "[input][3mf]") {
    const std::string says = "is a zip archive of more than the 10000 parts or 16 directories that are read";
    std::vector<ZipPart> parts = package_parts(model_text(cube_object(), item(1)));
    // libzip's hash of a text is 33 times that of what precedes the last letter, and the letter: of "Ez" and "FY" the same.
    for (unsigned i = 0; parts.size() < 10'000; ++i) {
        std::string name;
        for (unsigned bit = 0; bit < 14; ++bit) {
            name += (i >> bit & 1U) != 0 ? "Ez" : "FY";
        }
        parts.push_back({name, "", false});
    }
    const std::string bytes = zip(parts);
    const std::string end_record = bytes.substr(bytes.rfind("PK\5\6"));
    const double start = cpu_ms();
    CHECK(read_mesh(dir.write("a.3mf", bytes + repeated(end_record, 15))).ok());
    CHECK(cpu_ms() - start < 10'000);
    refuses_package(bytes + repeated(end_record, 16), says);
    parts.push_back({"x", "", false});
    refuses_package(zip(parts), says);
}

/// `levels` objects, each of which is the one before `times` times; the first is `seed`.
std::string tower(int levels, std::size_t times, const std::string& seed, const std::string& items = "") {
    std::string resources = object(1, seed);
    for (int id = 2; id <= levels; ++id) {
        resources += object(id, components(Texts(times, "objectid=\"" + std::to_string(id - 1) + "\"")));
    }
    return package(model_text(resources, items + item(levels)));
}

TEST_CASE("more instances and steps than any machine holds are counted and refused", "[input][3mf]") {
    const std::string mesh = mesh_xml(triangulated(cube()));
    const std::string one_triangle = mesh_xml({{0, 0, 0}, {{0, 0, 0}}});
    for (const std::string& bytes :
         {tower(41, 2, mesh), tower(200, 9, mesh), tower(3000, 1, one_triangle, repeated(item(3000), 2000))}) {
        refuses(dir.write("a.3mf", bytes), " expands to more than the ", ErrorCode::out_of_memory);
    }
    // Of nothing there may be any number.
    refuses_package(tower(200, 9, "<mesh/>"), "holds no triangles", ErrorCode::empty_mesh);
    // A chain is as deep as it is long, and each link is one step.
    CHECK(read_one(dir.write("a.3mf", tower(20000, 1, mesh))).triangle_count == 12);
}

TEST_CASE("3MF without memory is an error and leaks nothing", "[input][3mf]") {
    const auto path = dir.write("a.3mf", tower(4, 3, mesh_xml(triangulated(cube()))));
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
}  // namespace lamella::input_test
