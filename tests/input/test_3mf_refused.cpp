// 3MF: what is damaged, malformed or made to harm is refused, with a message that names part and line.
#include "engine/counting_memory.hpp"
#include "read.hpp"
#include "zip.hpp"

namespace lamella {
namespace {

using namespace input_test;
using Catch::Contains;

std::string good_model() {
    return model_text(object(1, cube_mesh()), item(1));
}

/// The message of the package's refusal, without the file's name.
std::string refusal(const std::string& bytes, ErrorCode code = ErrorCode::malformed_mesh) {
    const auto path = dir.write("a.3mf", bytes);
    const Error error = read_error(path);
    CHECK(error.code == code);
    return error.message.substr(path.string().size() + 2);
}

/// The same of a root part that is the good one with `what` replaced.
std::string refusal_with(const std::string& what, const std::string& replacement) {
    std::string model = good_model();
    const std::size_t at = model.find(what);
    REQUIRE(at != std::string::npos);
    return refusal(package(model.replace(at, what.size(), replacement)));
}

std::string in_root(std::size_t line, const std::string& what) {
    return "part '3D/3dmodel.model', line " + std::to_string(line) + ": " + what;
}

TEST_CASE("a 3MF file that ends anywhere but at its end is refused", "[input][3mf]") {
    const std::string bytes = package(good_model());
    refuses_cuts("a.3mf", bytes, 4, bytes.size());
    refuses(dir.write("a.3mf", bytes.substr(0, bytes.size() - 1)), "is truncated or no zip archive");
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
    const auto refusal_of = [&](const ZipPart& root) { return refusal(zip({content_types(), relationships(), root})); };
    ZipPart root = {"3D/3dmodel.model", good_model()};
    root.false_crc = 1;
    CHECK(refusal_of(root) == "part '3D/3dmodel.model' is damaged: its checksum differs");
    root.contents = "not XML";
    CHECK(refusal_of(root) == "part '3D/3dmodel.model' is damaged: its checksum differs");
    root = {"3D/3dmodel.model", good_model()};
    root.excess_bytes = 10;
    CHECK_THAT(refusal_of(root), Contains("is damaged: " + std::to_string(good_model().size()) + " bytes, of which"));
    root = {"3D/3dmodel.model", good_model()};
    root.flags = 1;
    CHECK(refusal_of(root) == "part '3D/3dmodel.model' is encrypted");
    root.flags = 0;
    root.method = 12;
    CHECK(refusal_of(root) == "part '3D/3dmodel.model' is compressed by method 12, which is not deflate");
    root.deflated = false;
    root.method = 8;
    CHECK(refusal_of(root) == "part '3D/3dmodel.model' is damaged: no valid deflate data");
}

TEST_CASE("archives that are no 3MF packages are refused", "[input][3mf]") {
    CHECK(refusal("PK\3\4" + zip({})) == "is a zip archive without any part");
    CHECK(refusal(zip({{"readme.txt", "a mesh"}})) == "part '_rels/.rels' is missing");
    for (const std::string name : {"mesh.stl", "a/mesh.OBJ", "mesh.ply.gz", "mesh.3mf"}) {
        CHECK(refusal(zip({{"readme.txt", "a mesh"}, {name, ascii_stl(numbered_facets(3))}, {"b.stl", ""}})) ==
              "part '" + name + "' is a mesh in a zip archive that is no 3MF package: unpack it first");
    }
    CHECK(refusal(zip({content_types(), relationships()})) == "part '3D/3dmodel.model' is missing");
    CHECK(refusal(zip({relationships(), relationships()})) == "part '_rels/.rels' is there twice");
    CHECK(refusal(zip({{"_rels/.rels", "<a/>"}})) == "part '_rels/.rels' names no model: is no 3MF package");
    CHECK(refusal(zip({{"_rels/.rels", ""}})) == "part '_rels/.rels', line 1: malformed XML: no element found");
    const std::string second =
        "\n<Relationship Target=\"b\" Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/>";
    CHECK(refusal(zip({relationships("a", second)})) == "part '_rels/.rels', line 2: a second model");
}

TEST_CASE("3MF part names that leave the package are refused", "[input][3mf]") {
    for (const std::string path :
         {"../a.model", "/3D/../../a.model", "3D//a", "/", "", ".", "C:/a", "3D\\a", "file:///a", "a/"}) {
        CHECK(refusal(zip({relationships(path), {path, good_model()}})) ==
              "part '_rels/.rels', line 1: the model is no part of the package");
        CHECK(refusal_with("objectid=\"1\"", "objectid=\"1\" p:path=\"" + path + "\"") ==
              in_root(29, "refers to a part outside the package: '" + path + "'"));
    }
}

TEST_CASE("entities and whatever else a document type may hold are refused", "[input][3mf]") {
    const std::string expected = in_root(2, "a document type declaration, which is refused");
    for (const std::string doctype :
         {"<!DOCTYPE model>", "<!DOCTYPE model SYSTEM \"file:///etc/passwd\">",
          "<!DOCTYPE m [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;&a;&a;&a;&a;&a;\"><!ENTITY c \"&b;&b;&b;&b;\">]>",
          "<!DOCTYPE m [<!ENTITY % x SYSTEM \"http://localhost/\"> %x;]>"}) {
        CHECK(refusal_with("<model", doctype + "<model") == expected);
    }
    CHECK(refusal_with("<resources>", "<resources>&bomb;") == in_root(3, "malformed XML: undefined entity"));
}

TEST_CASE("every malformed field of a 3MF model is reported with its line", "[input][3mf]") {
    const std::string compatibility_space = "http://schemas.openxmlformats.org/markup-compatibility/2006";
    using Row = std::tuple<std::string, std::string, std::size_t, std::string>;
    const std::vector<Row> rows = {
        {core_space, "urn:other", 2, "expected a 'model' of the namespace " + core_space + ", found 'model' of 'urn:other'"},
        {"<model", "<mode", 2,
         "expected a 'model' of the namespace " + core_space + ", found 'mode' of '" + core_space + "'"},
        {"</build>", "", 31, "malformed XML: mismatched tag"},
        {"<build>", "<build", 29, "malformed XML: not well-formed (invalid token)"},
        {" >", " unit=\"parsec\">", 2, "unknown unit 'parsec'"},
        {" >", " requiredextensions=\"p q\">", 2, "requires the extension 'q', a prefix that it does not declare"},
        {" >", " xmlns:s=\"urn:s\" requiredextensions=\" p\ts\">", 2,
         "requires the extension 's', 'urn:s', which is not supported"},
        {" >", " xmlns:s=\"urn:s\" xmlns:c=\"" + compatibility_space + "\" c:MustUnderstand=\"p s\">", 2,
         "requires the extension 's', 'urn:s', which is not supported"},
        {" >", " xmlns:c=\"" + compatibility_space + "\" c:MustUnderstand=\"q\">", 2,
         "requires the extension 'q', a prefix that it does not declare"},
        {"id=\"1\"", "", 4, "expected an 'id'"},
        {"id=\"1\"", "id=\"0\"", 4, "malformed id '0'"},
        {"id=\"1\"", "id=\"2147483648\"", 4, "malformed id '2147483648'"},
        {"id=\"1\"", "id=\"1x\"", 4, "malformed id '1x'"},
        {"id=\"1\"", "id=\"1\" type=\"ghost\"", 4, "unknown object type 'ghost'"},
        {"</object>", "</object><object id=\"1\"/>", 26, "a second object with id 1"},
        {"</object>", "<mesh/></object>", 26, "a mesh in an object that has a mesh or components already"},
        {"</object>", "<components><component objectid=\"1\"/></components></object>", 26,
         "components in an object that has a mesh already"},
        {"x=\"0\"", "", 5, "a vertex without 'x'"},
        {"z=\"0\"", "Z=\"0\"", 5, "a vertex without 'z'"},
        {"x=\"0\"", "x=\"1,5\"", 5, "malformed coordinate '1,5'"},
        {"x=\"0\"", "x=\"1 5\"", 5, "malformed coordinate '1 5'"},
        {"x=\"0\"", "x=\"nan\"", 5, "coordinate is not a finite number: 'nan'"},
        {"x=\"0\"", "x=\"1e999\"", 5, "coordinate is not a finite number: '1e999'"},
        {"v1=\"0\"", "", 14, "a triangle without 'v1'"},
        {"v1=\"0\"", "v1=\"8\"", 14, "vertex index 8 of a mesh with 8 vertices"},
        {"v1=\"0\"", "v1=\"-1\"", 14, "malformed vertex index '-1'"},
        {"v1=\"0\"", "v1=\"4294967296\"", 14, "malformed vertex index '4294967296'"},
        {"objectid=\"1\"", "", 29, "expected an 'objectid'"},
        {"objectid=\"1\"", "objectid=\"2\"", 29, "there is no object 2"},
        {"objectid=\"1\"", "objectid=\"1\" q:path=\"/3D/a.model\"", 29,
         "refers to a part by 'q:path', whose prefix is not declared"},
        {"id=\"1\"", "id=\"1\"><b:shape xmlns:b=\"urn:b\"/></object><object id=\"2\"", 29,
         "object 1 is made of 'shape' of the extension 'urn:b', which is not supported"},
    };
    for (const auto& [what, replacement, line, message] : rows) {
        CHECK(refusal_with(what, replacement) == in_root(line, message));
    }
}

TEST_CASE("malformed 3MF transforms are refused", "[input][3mf]") {
    const std::string twelve = "a transform that is not twelve finite numbers: ";
    using Row = std::pair<std::string, std::string>;
    for (const auto& [numbers, message] :
         {Row{"", twelve}, Row{"1 0 0 0 1 0 0 0 1 0 0", twelve}, Row{"1 0 0 0 1 0 0 0 1 0 0 x", twelve},
          Row{"nan 0 0 0 1 0 0 0 1 0 0 0", twelve}, Row{"1 0 0 0 1 0 0 0 1 0 0 inf", twelve},
          Row{"1 0 0 0 1 0 0 0 1 0 0 0 0", "a transform of more than twelve numbers: "},
          Row{"1 0 0 0 1 0 0 0 0 0 0 0", "a transform that flattens what it places: "},
          Row{"1e200 0 0 0 1e200 0 0 0 1 0 0 0", "a transform that flattens what it places: "}}) {
        CHECK(refusal_with("objectid=\"1\"", "objectid=\"1\" transform=\"" + numbers + "\"") ==
              in_root(29, message + "'" + numbers + "'"));
    }
}

TEST_CASE("a 3MF build without triangles is an empty mesh", "[input][3mf]") {
    const std::string empty =
        object(1, "<mesh><vertices/><triangles/></mesh>") + object(2, "") + object(3, cube_mesh(), "type=\"support\"");
    CHECK(refusal(package(model_text(empty, "")), ErrorCode::empty_mesh) ==
          "part '3D/3dmodel.model' has nothing in its build");
    const std::string unprintable = model_text(object(1, cube_mesh()), item(1, "printable=\"0\""));
    CHECK(refusal(package(unprintable), ErrorCode::empty_mesh) ==
          "part '3D/3dmodel.model' has nothing in its build but items marked as not printable");
    CHECK(refusal(package(model_text(empty, item(1) + item(2) + item(3))), ErrorCode::empty_mesh) ==
          "holds nothing solid: left out 1 support: 'object 3'");
    CHECK_THAT(refusal(package("<model xmlns=\"" + core_space + "\"/>"), ErrorCode::empty_mesh), Contains("nothing"));
    const std::string other = model_text(object(1, cube_mesh(), "type=\"other\""), item(1));
    CHECK(refusal(package(other)) == in_root(29, "the build comes to object 1 of type 'other', which is not to be built"));
}

TEST_CASE("only the root part refers to others, and what it refers to is there", "[input][3mf]") {
    const auto referring = [](const std::string& path, int id) {
        return model_text("", item(id, "p:path=\"" + path + "\""));
    };
    CHECK(refusal(package(referring("/b.model", 1))) == "part 'b.model' is missing");
    const ZipPart other = {"b.model", good_model()};
    CHECK(refusal(package(referring("/b.model", 7), {other})) ==
          in_root(6, "there is no object 7 in the part that it names"));
    const ZipPart nested = {"b.model",
                            model_text(object(1, components({R"(objectid="1" p:path="/3D/3dmodel.model")"})), "")};
    CHECK(refusal(package(referring("/b.model", 1), {nested})) ==
          "part 'b.model', line 4: refers to another part, which only the root part may");
    const ZipPart inches = {"b.model", model_text(object(1, cube_mesh()), "", "unit=\"inch\"")};
    CHECK(refusal(package(referring("/b.model", 1), {inches})) == "part 'b.model' has another unit than the root part");
}

TEST_CASE("components that contain themselves are refused", "[input][3mf]") {
    const auto of = [](int id) { return components({"objectid=\"" + std::to_string(id) + "\""}); };
    CHECK(refusal(package(model_text(object(1, of(1)), item(1)))) == in_root(4, "object 1 is a component of itself"));
    const std::string ring = object(1, of(2)) + object(2, of(3)) + object(3, of(1));
    CHECK(refusal(package(model_text(ring, item(2)))) == in_root(4, "object 2 is a component of itself"));
    // Not in the build, and so of no concern.
    const std::string model = model_text(ring + object(4, cube_mesh()), item(4));
    CHECK(read_mesh(dir.write("a.3mf", package(model))).ok());
}

/// `levels` objects, each of which is the one before `times` times; the first is `seed`.
std::string tower(int levels, int times, const std::string& seed) {
    std::string resources = object(1, seed);
    for (int id = 2; id <= levels; ++id) {
        resources += object(id, components(std::vector<std::string>(static_cast<std::size_t>(times),
                                                                    "objectid=\"" + std::to_string(id - 1) + "\"")));
    }
    return model_text(resources, item(levels));
}

TEST_CASE("more instances than any machine holds are counted and refused", "[input][3mf]") {
    for (const auto& [levels, times] : {std::pair{41, 2}, {200, 9}}) {
        const auto path = dir.write("a.3mf", package(tower(levels, times, cube_mesh())));
        CHECK(refuses(path, " builds more than the ").code == ErrorCode::out_of_memory);
    }
    // Of nothing there may be any number.
    CHECK(refusal(package(tower(200, 9, "<mesh/>")), ErrorCode::empty_mesh) == "holds no triangles");
    // A chain is as deep as it is long, and each link is one step.
    CHECK(read_one(dir.write("a.3mf", package(tower(20000, 1, cube_mesh())))).triangle_count == 12);
}

TEST_CASE("steps through nested 3MF components count towards the limit", "[input][3mf]") {
    std::string model = tower(3000, 1,
                              "<mesh><vertices><vertex x=\"0\" y=\"0\" z=\"0\"/></vertices><triangles>"
                              "<triangle v1=\"0\" v2=\"0\" v3=\"0\"/></triangles></mesh>");
    std::string items;
    for (int i = 0; i < 2000; ++i) {
        items += item(3000);
    }
    model.insert(model.find("</build>"), items);
    CHECK_THAT(refusal(package(model), ErrorCode::out_of_memory), Contains(" builds more than the "));
}

TEST_CASE("3MF text that expands enormously is refused while it streams", "[input][3mf]") {
    std::string model = good_model();
    model.insert(model.find("</resources>"), std::string(std::size_t{24} << 20, ' '));
    const auto path = dir.write("a.3mf", package(model));
    CHECK_THAT(message_beyond(std::uint64_t{8} << 20, path), Contains("part '3D/3dmodel.model' expands to more than the "));
    // Nothing of it is kept, so that the default allows it.
    CHECK(read_mesh(path).ok());
}

TEST_CASE("memory for a 3MF file stays within the limit", "[input][3mf]") {
    std::string vertices;
    for (int i = 0; i < 40000; ++i) {
        vertices += "<vertex x=\"" + std::to_string(i) + "\" y=\"0\" z=\"" + std::to_string(i * i % 7919) + "\"/>";
    }
    std::string model = good_model();
    model.insert(model.find("</vertices>"), vertices);
    std::string objects;
    for (int id = 2; id < 20000; ++id) {
        objects += object(id, components({R"(objectid="1")"}));
    }
    const std::string many = model_text(object(1, cube_mesh()) + objects, item(1));
    for (const std::string& text : {model, many}) {
        const auto path = dir.write("a.3mf", package(text));
        CHECK_THAT(message_beyond(1 << 20, path), Contains(": takes more than the 1048576 bytes that reading it may"));
        CHECK(read_mesh(path).ok());
    }
}

TEST_CASE("3MF without memory is an error and leaks nothing", "[input][3mf]") {
    const auto path = dir.write("a.3mf", package(tower(4, 3, cube_mesh())));
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
