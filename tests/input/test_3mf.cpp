// 3MF packages are read, placed and oriented as the format has it.
#include "lamella/io.hpp"
#include "read.hpp"
#include "zip.hpp"

namespace lamella {
namespace {

using namespace input_test;

constexpr double cube_volume = 1000;
constexpr const char* negative_hole = "left out 1 negative volume: 'hole'; what they take away stays solid";

std::string cube(int id = 1, const std::string& attributes = "") {
    return object(id, cube_mesh(), attributes);
}

/// A package of indexed triangles, and what is warned of.
Contents read_package(const std::string& bytes, const Texts& warnings = {}) {
    Contents contents = read(dir.write("a.3mf", bytes));
    CHECK(contents.mesh.view().indices != nullptr);
    CHECK(contents.warnings == warnings);
    return contents;
}

/// Its triangles fill the box between two corners, so many volumes of the cube.
void check_placed(const std::string& model, const Box& box, double cubes, std::vector<ZipPart> others = {}) {
    const Triangles triangles = read_package(package(model, std::move(others))).triangles;
    CHECK(box_of(triangles) == box);
    CHECK(volume_of(triangles) == Approx(cubes * cube_volume));
}

std::string transform(const std::string& numbers) {
    return " transform=\"" + numbers + "\"";
}

TEST_CASE("a 3MF cube is read as it was written, deflated or stored", "[input][3mf]") {
    std::vector<ZipPart> parts = {content_types(), relationships(), {"3D/3dmodel.model", model_text(cube(), item(1))}};
    const bool deflated = GENERATE(true, false);
    for (ZipPart& part : parts) {
        part.deflated = deflated;
    }
    const Contents contents = read_package(zip(parts));
    CHECK(contents.mesh.format == MeshFormat::three_mf);
    CHECK(name_of(contents.mesh.format) == "3MF");
    CHECK(contents.mesh.text);
    CHECK(contents.mesh.vertex_count == 8);
    REQUIRE(contents.triangles.size() == cube_triangles.size());
    for (std::size_t i = 0; i < 9 * cube_triangles.size(); ++i) {
        const auto corner = static_cast<std::size_t>(cube_triangles[i / 9][i % 9 / 3]);
        CHECK(contents.triangles[i / 9][i % 9] == cube_vertices[corner][i % 3]);
    }
}

TEST_CASE("the unit of a 3MF file overrides the caller's", "[input][3mf]") {
    for (const auto& [name, mm] : {std::pair("micron", 0.001),
                                   {"millimeter", 1.0},
                                   {"centimeter", 10.0},
                                   {"inch", 25.4},
                                   {"foot", 304.8},
                                   {"meter", 1000.0}}) {
        const std::string unit = "unit=\"" + std::string(name) + "\"";
        const auto path = dir.write("a.3mf", package(model_text(cube(), item(1), unit)));
        const MeshFile mesh = value_of(read_mesh(path, {.mm_per_unit = 7}));
        CHECK(mesh.states_unit);
        CHECK(mesh.mm_per_unit == mm);
        CHECK(box_of(triangles_of(mesh)).max_mm == std::array{10 * mm, 10 * mm, 10 * mm});
    }
}

TEST_CASE("items and components are placed by their transforms, the inner one first", "[input][3mf]") {
    // Moved by (1, 2, 3), stretched by (2, 3, 4), and (x, y, z) -> (z, x, y): the last shows which way the matrix is read.
    for (const auto& [numbers, box, cubes] :
         {std::tuple("1 0 0 0 1 0 0 0 1 1 2 3", Box{{1, 2, 3}, {11, 12, 13}}, 1),
          {"2 0 0 0 3 0 0 0 4 0 0 0", Box{{0, 0, 0}, {20, 30, 40}}, 24},
          {"\t0 2 0\r\n0 0 3 4 0 0 +5 -1e1 .5 ", Box{{5, -10, 0.5}, {45, 10, 30.5}}, 24}}) {
        const std::string assembly = object(2, components({"objectid=\"1\"" + transform(numbers)}));
        check_placed(model_text(cube(), item(1, transform(numbers))), box, cubes);
        check_placed(model_text(cube() + assembly, item(2)), box, cubes);
    }
    const std::string moved = object(2, components({"objectid=\"1\"" + transform("1 0 0 0 1 0 0 0 1 1 0 0")}));
    const std::string twice = transform("2 0 0 0 2 0 0 0 2 0 0 0");
    check_placed(model_text(cube() + moved, item(2, twice)), {{2, 0, 0}, {22, 20, 20}}, 8);
}

TEST_CASE("all 3MF items and nested components are placed", "[input][3mf]") {
    const std::string moved = transform("1 0 0 0 1 0 0 0 1 20 0 0");
    const std::string pair = components({R"(objectid="1")", R"(objectid="1")" + moved});
    // Objects may refer to what comes later.
    const std::string pairs = components({R"(objectid="2")", R"(objectid="2" transform="1 0 0 0 1 0 0 0 1 0 20 0")"});
    const std::string items = item(3) + item(3, transform("1 0 0 0 1 0 0 0 1 0 0 20")) + item(1, moved);
    check_placed(model_text(object(3, pairs) + object(2, pair) + cube(), items), {{0, 0, 0}, {30, 30, 30}}, 9);
}

TEST_CASE("triangles that a transform mirrors are reversed to face outwards", "[input][3mf]") {
    const std::string mirror = transform("-1 0 0 0 1 0 0 0 1 0 0 0");
    const std::string assembly = object(2, components({R"(objectid="1")" + mirror, R"(objectid="1")"}));
    check_placed(model_text(cube(), item(1, mirror)), {{-10, 0, 0}, {0, 10, 10}}, 1);
    // One of the two is mirrored twice, the other once.
    check_placed(model_text(cube() + assembly, item(2, mirror)), {{-10, 0, 0}, {10, 10, 10}}, 2);
}

TEST_CASE("all instances of a 3MF mesh of several chunks are placed", "[input][3mf]") {
    constexpr int vertices = 70000;  // more than a chunk holds
    std::string mesh = "<mesh><vertices>";
    std::string faces = "</vertices><triangles>";
    Triangles expected;
    for (int v = 0; v < vertices; ++v) {
        const auto number = [v](int beyond) { return "\"" + std::to_string(v + beyond); };
        mesh += "<vertex x=" + number(0) + "\" y=\"" + std::to_string(v % 7) + "\" z=\"1\"/>";
        if (v + 2 < vertices) {
            faces += "<triangle v1=" + number(0) + "\" v2=" + number(1) + "\" v3=" + number(2) + "\"/>";
            const double x = v;
            expected.push_back({x, double(v % 7), 1, x + 1, double((v + 1) % 7), 1, x + 2, double((v + 2) % 7), 1});
        }
    }
    const std::string items = item(1) + item(2) + item(1, transform("1 0 0 0 1 0 0 0 -1 0 0 0"));
    const std::string resources = object(1, mesh + faces + "</triangles></mesh>") + cube(2);
    const Contents contents = read_package(package(model_text(resources, items)));
    CHECK(contents.mesh.vertex_count == 2 * vertices + 8);
    REQUIRE(contents.triangles.size() == 2 * expected.size() + 12);
    CHECK(std::equal(expected.begin(), expected.end(), contents.triangles.begin()));
    for (auto& t : expected) {  // the second instance, in which z is negative and triangles are reversed
        t = {t[0], t[1], -1, t[6], t[7], -1, t[3], t[4], -1};
    }
    CHECK(std::equal(expected.begin(), expected.end(), contents.triangles.begin() + vertices - 2));
}

TEST_CASE("parts of the production extension are found by their paths", "[input][3mf]") {
    const std::string path = R"(p:path="/3D/Objects/cub%65%201.model" p:UUID="7")";
    const std::string assembly = object(1, components({"objectid=\"1\" " + path, R"(objectid="2")"}));
    const std::string inner = object(4, components({R"(objectid="1" transform="1 0 0 0 1 0 0 0 1 0 0 40")"}));
    const std::string items = item(1) + item(4, path + transform("1 0 0 0 1 0 0 0 1 40 0 0"));
    // Ids count within their part; what another part builds does not count; names of parts are equal in any case, and with
    // percent escapes or without.
    const ZipPart other = {"3D/objects/Cube 1.model", model_text(cube(1) + inner, item(1) + item(4))};
    check_placed(model_text(assembly + cube(2), items, R"(requiredextensions="p")"), {{0, 0, 0}, {50, 10, 50}}, 3, {other});
}

TEST_CASE("3MF supports and unprintable items are left out with a warning", "[input][3mf]") {
    const std::string resources = cube(1) + cube(2, "type=\"support\"") + cube(3, "type=\"solidsupport\"") +
                                  cube(4, "type=\"other\"") + cube(5, "type=\"surface\"") +
                                  object(6, components({R"(objectid="2")", R"(objectid="1")"}));
    const std::string items =
        item(6) + item(2) + item(3) + item(5) + item(1, "printable=\"0\"") + item(1, "printable=\"1\"");
    const Contents contents = read(dir.write("a.3mf", package(model_text(resources, items))));
    CHECK(contents.triangles.size() == 4 * 12);
    REQUIRE(contents.warnings.size() == 2);
    CHECK_THAT(contents.warnings[0], Catch::Contains("ignored an item of the build that is marked as not printable"));
    CHECK(contents.warnings[1] == "left out 1 support: 'object 2'");
}

TEST_CASE("bytes around the zip archive and missing parts of a 3MF file give a warning, parts of no use do not",
          "[input][3mf]") {
    const std::string model = model_text(cube(), item(1));
    const std::string whole = package(model, {{"Metadata/", ""}, {"thumbnail.png", "\x89PNG"}});
    read_package(whole + std::string(5, '\0'), {"ignored 5 bytes after the zip archive"});
    read_package(std::string(7, '\x01') + whole + "tail",
                 {"ignored 7 bytes before the zip archive", "ignored 4 bytes after the zip archive"});
    std::string with_comment = whole + "a comment";
    with_comment[whole.size() - 2] = 9;
    read_package(with_comment);
    read_package(zip({{"3d/3DMODEL.model", model}, relationships("3D/3dmodel.model")}),
                 {"has no part '[Content_Types].xml', as a 3MF package must"});
}

TEST_CASE("3MF is read in UTF-16, and with a prefix on each name", "[input][3mf]") {
    const std::string model = model_text(cube(), item(1));
    std::string wide = "\xFF\xFE";
    for (const char c : model.substr(model.find("<model"))) {
        wide += {c, '\0'};
    }
    CHECK(read_package(package(wide)).triangles.size() == 12);
    std::string prefixed = replaced(replaced(replaced(model, "</", "~"), "<", "<c:"), "~", "</c:");
    prefixed = replaced(replaced(prefixed, "<c:?", "<?"), "xmlns=", "xmlns:c=");
    CHECK(read_package(package(prefixed)).triangles.size() == 12);
}

// --- Volumes as slicers mark them, beside the model or within

/// Four triangles of PrusaSlicer's.
std::string volume(int first, const std::string& type, const std::string& name = "") {
    return "<volume firstid=\"" + std::to_string(first) + "\" lastid=\"" + std::to_string(first + 3) +
           R"("><metadata key="volume_type" value=")" + type + R"("/><metadata key="name" value=")" + name + "\"/></volume>";
}

/// A cube that is built twice.
std::string prusa(const std::string& volumes) {
    const std::string items = item(1) + item(1, transform("1 0 0 0 1 0 0 0 1 0 0 30"));
    return package(model_text(cube(), items), {{"Metadata/Slic3r_PE_model.config",
                                                "<config>\n<object id=\"1\">\n" + volumes + "\n</object></config>"}});
}

TEST_CASE("volumes that a slicer says are not solid are left out of a 3MF mesh and named", "[input][3mf]") {
    const std::string three = volume(8, "ModelPart") + volume(4, "NegativeVolume", "hole") + volume(0, "New", "c");
    const Contents by_prusa = read_package(
        prusa(three),
        {"part 'Metadata/Slic3r_PE_model.config', line 3: unknown type of volume 'New', read as solid", negative_hole});
    CHECK(parts_of(by_prusa.mesh) == "c solid 0 8; hole negative volume 0 8; object 1, volume 1 solid 8 8; ");
    CHECK(by_prusa.mesh.vertex_count == 2 * (8 + 8));  // the hole has none of its own

    const std::string leg = components({R"(objectid="1")", R"(objectid="1")", R"(objectid="2")"});
    const ZipPart settings = {
        "Metadata/model_settings.config",
        R"(<config><object id="3"><metadata key="name" value="Leg"/><part id="1" subtype="normal_part"/>)"
        R"(<part id="1" subtype="negative_part"><metadata key="name" value="hole"/></part>)"
        R"(<part id="2" subtype="support_blocker"/></object></config>)"};
    const std::string assembly = package(model_text(cube(1) + cube(2) + object(3, leg), item(3)), {settings});
    CHECK(parts_of(read_package(assembly, {negative_hole, "left out 1 support blocker: 'Leg'"}).mesh) ==
          "Leg solid 0 12; hole negative volume 0 12; Leg support blocker 0 12; ");

    const std::string cura = R"(<metadatagroup><metadata name="cura:cutting_mesh">True</metadata></metadatagroup>)";
    const std::string cut = model_text(object(7, cura + cube_mesh(), "name=\"a\"") + cube(2), item(7) + item(2));
    CHECK(parts_of(read_package(package(cut), {"left out 1 modifier: 'a'"}).mesh) ==
          "a modifier 0 12; object 2 solid 0 12; ");
}

TEST_CASE("settings of a slicer that do not fit its 3MF model are refused by place", "[input][3mf]") {
    const std::string two = volume(0, "ModelPart") + volume(4, "ModelPart");
    const std::string next = " of object 1, which has 12 and whose next is 8";
    for (const auto& [volumes, message] :
         {std::pair<std::string, std::string>{two, "4: triangle 8 of object 1 is in none of its volumes"},
          {two + volume(9, "ModelPart"), "4: a volume of triangles 9 to 12" + next},
          {two + volume(7, "ModelPart"), "4: a volume of triangles 7 to 10" + next},
          {"<volume firstid=\"-1\"/>", "3: expected a number as 'firstid', found '-1'"},
          {"<volume", "4: malformed XML: not well-formed (invalid token)"}}) {
        refuses(dir.write("a.3mf", prusa(volumes)), ": part 'Metadata/Slic3r_PE_model.config', line " + message);
    }
    const std::string modifier = R"(<volume firstid="0" lastid="11"><metadata key="modifier" value="1"/></volume>)";
    refuses(dir.write("a.3mf", prusa(modifier)), ": holds nothing solid: left out 1 modifier: 'object 1'",
            ErrorCode::empty_mesh);
}

}  // namespace
}  // namespace lamella
