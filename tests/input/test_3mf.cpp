// 3MF: what is in a package is read, placed and oriented as the format has it.
#include "lamella/io.hpp"
#include "lamella/lamella.hpp"
#include "read.hpp"
#include "zip.hpp"

namespace lamella {
namespace {

using namespace input_test;

using Box = std::array<std::array<double, 3>, 2>;

constexpr double cube_volume = 1000;

std::string cube(int id = 1, const std::string& attributes = "") {
    return object(id, cube_mesh(), attributes);
}

std::vector<Corners> read_corners(const std::string& bytes) {
    const MeshFile mesh = read_indexed(dir.write("a.3mf", bytes));
    CHECK(mesh.warnings.empty());
    return corners_of(mesh);
}

/// What is warned of a package from which so many triangles are read.
Texts warnings(const std::string& bytes, std::uint64_t triangles = 12) {
    const auto path = dir.write("a.3mf", bytes);
    CHECK(read_indexed(path).triangle_count == triangles);
    return warnings_of(path);
}

double volume(const std::vector<Corners>& triangles) {
    return six_volumes(triangles) / 6;
}

TEST_CASE("a 3MF cube is read as it was written", "[input][3mf]") {
    const bool deflated = GENERATE(true, false);
    std::vector<ZipPart> parts = {content_types(), relationships(), {"3D/3dmodel.model", model_text(cube(), item(1))}};
    for (ZipPart& part : parts) {
        part.deflated = deflated;
    }
    const MeshFile mesh = read_indexed(dir.write("a.3mf", zip(parts)));
    CHECK(mesh.format == MeshFormat::three_mf);
    CHECK(name_of(mesh.format) == "3MF");
    CHECK(mesh.text);
    CHECK(mesh.vertex_count == 8);
    CHECK(mesh.states_unit);
    CHECK(mesh.mm_per_unit == 1);
    CHECK(mesh.warnings.empty());
    const std::vector<Corners> triangles = corners_of(mesh);
    REQUIRE(triangles.size() == cube_triangles.size());
    for (std::size_t i = 0; i < 9 * triangles.size(); ++i) {
        const auto corner = static_cast<std::size_t>(cube_triangles[i / 9][i % 9 / 3]);
        CHECK(triangles[i / 9][i % 9 / 3][i % 3] == cube_vertices[corner][i % 3]);
    }
}

TEST_CASE("the unit of a 3MF file overrides the caller's", "[input][3mf]") {
    const auto [name, mm] = GENERATE(table<std::string, double>(
        {{"micron", 0.001}, {"millimeter", 1}, {"centimeter", 10}, {"inch", 25.4}, {"foot", 304.8}, {"meter", 1000}}));
    ReadOptions options;
    options.mm_per_unit = 7;
    const auto path = dir.write("a.3mf", package(model_text(cube(), item(1), "unit=\"" + name + "\"")));
    const MeshFile mesh = value_of(read_mesh(path, options));
    CHECK(mesh.states_unit);
    CHECK(mesh.mm_per_unit == mm);
    CHECK(box_of(corners_of(mesh))[1] == std::array<double, 3>{10 * mm, 10 * mm, 10 * mm});
}

TEST_CASE("items and components are placed by their transforms", "[input][3mf]") {
    // Moved by (1, 2, 3), stretched by (2, 3, 4), and (x, y, z) -> (z, x, y): the last shows which way the matrix is read.
    const auto [transform, box] = GENERATE(table<std::string, Box>({
        {"1 0 0 0 1 0 0 0 1 1 2 3", Box{{{1, 2, 3}, {11, 12, 13}}}},
        {"2 0 0 0 3 0 0 0 4 0 0 0", Box{{{0, 0, 0}, {20, 30, 40}}}},
        {"\t0 2 0\r\n0 0 3 4 0 0 +5 -1e1 .5 ", Box{{{5, -10, 0.5}, {45, 10, 30.5}}}},
    }));
    const std::string attribute = "transform=\"" + transform + "\"";
    const std::string assembly = object(2, components({"objectid=\"1\" " + attribute}));
    for (const std::string& model : {model_text(cube(), item(1, attribute)), model_text(cube() + assembly, item(2))}) {
        const std::vector<Corners> triangles = read_corners(package(model));
        CHECK(box_of(triangles) == box);
        CHECK(volume(triangles) > 0);
    }
}

TEST_CASE("nested 3MF transforms apply the inner one first", "[input][3mf]") {
    const std::string assembly = object(2, components({R"(objectid="1" transform="1 0 0 0 1 0 0 0 1 1 0 0")"}));
    const std::string twice = R"(transform="2 0 0 0 2 0 0 0 2 0 0 0")";
    const std::vector<Corners> triangles = read_corners(package(model_text(cube() + assembly, item(2, twice))));
    CHECK(box_of(triangles) == Box{{{2, 0, 0}, {22, 20, 20}}});
}

TEST_CASE("all 3MF items and nested components are placed", "[input][3mf]") {
    const std::string moved = R"( transform="1 0 0 0 1 0 0 0 1 20 0 0")";
    const std::string pair = components({R"(objectid="1")", R"(objectid="1")" + moved});
    // Objects may refer to what comes later.
    const std::string pairs = components({R"(objectid="2")", R"(objectid="2" transform="1 0 0 0 1 0 0 0 1 0 20 0")"});
    const std::string resources = object(3, pairs) + object(2, pair) + cube();
    const std::string items = item(3) + item(3, R"(transform="1 0 0 0 1 0 0 0 1 0 0 20")") + item(1, moved);
    const std::vector<Corners> triangles = read_corners(package(model_text(resources, items)));
    CHECK(triangles.size() == 9 * 12);
    CHECK(volume(triangles) == Approx(9 * cube_volume));
    CHECK(box_of(triangles) == Box{{{0, 0, 0}, {30, 30, 30}}});
}

TEST_CASE("triangles that a transform mirrors are reversed to face outwards", "[input][3mf]") {
    const std::string mirror = R"( transform="-1 0 0 0 1 0 0 0 1 0 0 0")";
    const std::string assembly = object(2, components({R"(objectid="1")" + mirror, R"(objectid="1")"}));
    const std::vector<Corners> once = read_corners(package(model_text(cube(), item(1, mirror))));
    CHECK(volume(once) == Approx(cube_volume));
    CHECK(box_of(once) == Box{{{-10, 0, 0}, {0, 10, 10}}});
    // One of the two is mirrored twice, the other once.
    const std::vector<Corners> both = read_corners(package(model_text(cube() + assembly, item(2, mirror))));
    CHECK(both.size() == 24);
    CHECK(volume(both) == Approx(2 * cube_volume));
    CHECK(box_of(both) == Box{{{-10, 0, 0}, {10, 10, 10}}});
}

TEST_CASE("all instances of a 3MF mesh of several chunks are placed", "[input][3mf]") {
    constexpr int vertices = 70000;  // more than a chunk holds
    std::string mesh = "<mesh><vertices>";
    for (int v = 0; v < vertices; ++v) {
        mesh += "<vertex x=\"" + std::to_string(v) + "\" y=\"" + std::to_string(v % 7) + "\" z=\"1\"/>";
    }
    mesh += "</vertices><triangles>";
    for (int v = 0; v + 2 < vertices; ++v) {
        mesh += "<triangle v1=\"" + std::to_string(v) + "\" v2=\"" + std::to_string(v + 1) + "\" v3=\"" +
                std::to_string(v + 2) + "\"/>";
    }
    mesh += "</triangles></mesh>";
    const std::string items = item(1) + item(2) + item(1, R"(transform="1 0 0 0 1 0 0 0 -1 0 0 0")");
    const MeshFile file = read_indexed(dir.write("a.3mf", package(model_text(object(1, mesh) + cube(2), items))));
    const std::vector<Corners> triangles = corners_of(file);
    REQUIRE(file.vertex_count == 2 * vertices + 8);
    REQUIRE(triangles.size() == 2 * (vertices - 2) + 12);
    bool right = true;
    for (int v = 0; v + 2 < vertices; ++v) {
        const auto corner = [](int at, double z) {
            return std::array<double, 3>{static_cast<double>(at), static_cast<double>(at % 7), z};
        };
        const auto t = static_cast<std::size_t>(v);
        right = right && triangles[t] == Corners{corner(v, 1), corner(v + 1, 1), corner(v + 2, 1)} &&
                triangles[t + vertices - 2] == Corners{corner(v, -1), corner(v + 2, -1), corner(v + 1, -1)};
    }
    CHECK(right);
}

TEST_CASE("parts of the production extension are found by their paths", "[input][3mf]") {
    const std::string path = R"(p:path="/3D/Objects/cub%65%201.model" p:UUID="7")";
    const std::string assembly = object(1, components({"objectid=\"1\" " + path, R"(objectid="2")"}));
    const std::string inner = object(4, components({R"(objectid="1" transform="1 0 0 0 1 0 0 0 1 0 0 40")"}));
    const std::string items = item(1) + item(4, path + R"( transform="1 0 0 0 1 0 0 0 1 40 0 0")");
    const std::string root = model_text(assembly + cube(2), items, R"(requiredextensions="p")");
    // Ids count within their part; what another part builds does not count; names of parts are equal in any case, and with
    // percent escapes or without.
    const ZipPart other = {"3D/objects/Cube 1.model", model_text(cube(1) + inner, item(1) + item(4))};
    const std::vector<Corners> triangles = read_corners(package(root, {other}));
    CHECK(triangles.size() == 3 * 12);
    CHECK(volume(triangles) == Approx(3 * cube_volume));
    CHECK(box_of(triangles) == Box{{{0, 0, 0}, {50, 10, 50}}});
}

TEST_CASE("3MF extensions without geometry are skipped", "[input][3mf]") {
    const std::string material =
        "xmlns:m=\"http://schemas.microsoft.com/3dmanufacturing/material/2015/02\" "
        "requiredextensions=\"m p\"";
    const std::string colours =
        "<m:colorgroup id=\"9\"><m:color color=\"#FF0000\"/></m:colorgroup>"
        "<basematerials id=\"8\"><base name=\"PLA\" displaycolor=\"#0000FF\"/></basematerials>";
    std::string mesh = cube_mesh();
    mesh.replace(mesh.find("v1="), 0, "pid=\"9\" p1=\"0\" ");
    const std::string metadata = "<metadatagroup><metadata name=\"a\">b &lt; &#65;</metadata></metadatagroup>";
    const std::string model = model_text(colours + object(1, metadata + mesh), item(1), material);
    CHECK(read_corners(package(model)).size() == 12);
}

TEST_CASE("an optional 3MF extension with shapes of its own gives a warning", "[input][3mf]") {
    std::string mesh = cube_mesh();
    mesh.replace(mesh.find("</mesh>"), 0,
                 "\n<b:beamlattice radius=\"1\"><b:beams><b:beam v1=\"0\"/></b:beams></b:beamlattice>");
    const std::string model = model_text(object(1, mesh) + object(2, mesh), item(1), "xmlns:b=\"urn:lattice\"");
    CHECK(warnings(package(model)) == Texts{"part '3D/3dmodel.model', line 27: ignored 'beamlattice' in an object, of "
                                            "the extension 'urn:lattice'"});
}

TEST_CASE("3MF supports and unprintable items are left out with a warning", "[input][3mf]") {
    const std::string resources = cube(1) + cube(2, "type=\"support\"") + cube(3, "type=\"solidsupport\"") +
                                  cube(4, "type=\"other\"") + cube(5, "type=\"surface\"") +
                                  object(6, components({R"(objectid="2")", R"(objectid="1")"}));
    const std::string items =
        item(6) + item(2) + item(3) + item(5) + item(1, "printable=\"0\"") + item(1, "printable=\"1\"");
    const Texts found = warnings(package(model_text(resources, items)), 4 * 12);
    REQUIRE(found.size() == 2);
    CHECK(found[0].find("ignored an item of the build that is marked as not printable") != std::string::npos);
    CHECK(found[1] == "left out 1 support: 'object 2'");
}

TEST_CASE("3MF names whose prefix is not declared are left out with a warning", "[input][3mf]") {
    const auto [resources, items, line, name] = GENERATE(table<std::string, std::string, std::string, std::string>({
        {cube(), item(1, "q:UUID=\"1\""), "29", "q:UUID"},
        {object(1, cube_mesh(), "q:UUID=\"1\""), item(1), "4", "q:UUID"},
        {"<q:colours><q:colour/></q:colours>" + cube(), item(1), "4", "q:colours"},
    }));
    CHECK(warnings(package(model_text(resources, items))) ==
          Texts{"part '3D/3dmodel.model', line " + line + ": ignored '" + name + "', as its prefix is not declared"});
}

TEST_CASE("bytes around the zip archive of a 3MF file give a warning, parts of no use do not", "[input][3mf]") {
    const std::string whole = package(model_text(cube(), item(1)), {{"Metadata/", ""}, {"thumbnail.png", "\x89PNG"}});
    CHECK(warnings(whole + std::string(5, '\0')) == Texts{"ignored 5 bytes after the zip archive"});
    CHECK(warnings(std::string(7, '\x01') + whole + "tail") ==
          Texts{"ignored 7 bytes before the zip archive", "ignored 4 bytes after the zip archive"});
    std::string with_comment = whole + "a comment";
    with_comment[whole.size() - 2] = 9;
    CHECK(warnings(with_comment).empty());
}

TEST_CASE("a package that lacks its content types is read with a warning", "[input][3mf]") {
    const std::string model = model_text(cube(), item(1));
    CHECK(warnings(zip({{"3d/3DMODEL.model", model}, relationships("3D/3dmodel.model")})) ==
          Texts{"has no part '[Content_Types].xml', as a 3MF package must"});
}

TEST_CASE("3MF vertices and triangles are read the same in every XML spelling", "[input][3mf]") {
    const std::string model = model_text(cube(), item(1));
    const std::vector<Corners> expected = read_corners(package(model));
    const auto with = [&model](const std::string& from, const std::string& to) {
        std::string text = replaced(model, from, to);
        REQUIRE(text != model);
        return text;
    };
    const std::string fourth = R"(<vertex x="0" y="10" z="0"/>)";
    const std::string fifth = R"(<triangle v1="0" v2="1" v3="5"/>)";
    const std::string text = GENERATE_COPY(
        as<std::string>(), with("\n", "\r\n"), with("\n", "\r"), with("\n", ""), with("\"/>\n", "\" />\n"),
        with("/>\n<", "/>\t <"), with(fourth, R"(<vertex y="10" x="0" z="0"/>)"),
        with(fourth, "<vertex x='0' y='10' z='0'/>"), with(fourth, R"(<vertex x=" 0" y="10 " z="&#48;"/>)"),
        with(fourth, R"(<vertex x="0" y="1&#x30;" z="0"></vertex>)"),
        with(fourth, "<!-- <vertices> -->" + fourth + "<?a <triangles>?>"),
        with(fourth, R"(<other xmlns="urn:other"><vertices><vertex x="1" y="1" z="1"/></vertices></other>)" + fourth),
        with(fifth, R"(<triangle v1="0" v2="1" v3="5" pid="7"/>)"),
        with(fifth, R"(<triangle v1="0" v2="1" v3="5"><extra/></triangle>)"), with("<vertices>", "<vertices >"),
        with("<triangles>", R"(<triangles a="&lt;vertices>">)"));
    INFO(text);
    CHECK(read_corners(package(text)) == expected);
    // Names without a prefix in a list with one are of another namespace.
    std::string prefixed = with("<vertices>", "<c:vertices xmlns:c=\"" + core_space + "\" xmlns=\"urn:other\">");
    prefixed.replace(prefixed.find("</vertices>"), 11, "</c:vertices>");
    refuses(dir.write("a.3mf", package(prefixed)), "vertex index 0 of a mesh with 0 vertices");
}

TEST_CASE("3MF is read in UTF-8 and UTF-16, and with a prefix on each name", "[input][3mf]") {
    const std::string model = model_text(cube(), item(1));
    CHECK(read_corners(package("\xEF\xBB\xBF" + model)).size() == 12);
    std::string wide = "\xFF\xFE";
    for (const char c : model.substr(model.find("<model"))) {
        wide += c;
        wide += '\0';
    }
    CHECK(read_corners(package(wide)).size() == 12);
    std::string prefixed = model;
    for (const char* name :
         {"model", "resources", "object", "mesh", "vertices", "vertex", "triangles", "triangle", "build", "item"}) {
        for (const std::string& before : {std::string("<"), std::string("</")}) {
            for (const std::string& after : {std::string(" "), std::string(">")}) {
                prefixed = replaced(prefixed, before + name + after, before + "c:" + name + after);
            }
        }
    }
    prefixed.replace(prefixed.find("xmlns="), 6, "xmlns:c=");
    CHECK(read_corners(package(prefixed)).size() == 12);
}

}  // namespace
}  // namespace lamella
