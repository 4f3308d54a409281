// 3MF: what slicers say of volumes, beside the model or within.
#include "read.hpp"
#include "zip.hpp"

namespace lamella {
namespace {

using namespace input_test;

constexpr const char* negative_hole = "left out 1 negative volume: 'hole'; what they take away stays solid";

/// Four triangles of PrusaSlicer's.
std::string volume(int first, const std::string& type, const std::string& name = "") {
    return "<volume firstid=\"" + std::to_string(first) + "\" lastid=\"" + std::to_string(first + 3) +
           R"("><metadata key="volume_type" value=")" + type + R"("/><metadata key="name" value=")" + name + "\"/></volume>";
}

/// A cube that is built twice.
std::string prusa(const std::string& volumes) {
    const std::string items = item(1) + item(1, R"(transform="1 0 0 0 1 0 0 0 1 0 0 30")");
    return package(
        model_text(object(1, cube_mesh()), items),
        {{"Metadata/Slic3r_PE_model.config", "<config>\n<object id=\"1\">\n" + volumes + "\n</object></config>"}});
}

TEST_CASE("volumes that a slicer says are not solid are left out of a 3MF mesh and named", "[input][3mf]") {
    const auto require = [&](const std::string& bytes, const std::string& parts, const std::vector<std::string>& warnings) {
        const auto path = dir.write("a.3mf", bytes);
        const MeshFile file = read_indexed(path);
        CHECK(parts_of(file) == parts);
        CHECK(warnings_of(path) == warnings);
        return file.vertex_count;
    };
    const std::string three = volume(8, "ModelPart") + volume(4, "NegativeVolume", "hole") + volume(0, "New", "c");
    const std::uint64_t vertices = require(
        prusa(three), "c solid 0 8; hole negative volume 0 8; object 1, volume 1 solid 8 8; ",
        {"part 'Metadata/Slic3r_PE_model.config', line 3: unknown type of volume 'New', read as solid", negative_hole});
    CHECK(vertices == 2 * (8 + 8));  // the hole has none of its own

    const std::string leg = components({R"(objectid="1")", R"(objectid="1")", R"(objectid="2")"});
    const std::string cubes = object(1, cube_mesh()) + object(2, cube_mesh());
    require(package(model_text(cubes + object(3, leg), item(3)),
                    {{"Metadata/model_settings.config",
                      R"(<config><object id="3"><metadata key="name" value="Leg"/><part id="1" subtype="normal_part"/>)"
                      R"(<part id="1" subtype="negative_part"><metadata key="name" value="hole"/></part>)"
                      R"(<part id="2" subtype="support_blocker"/></object></config>)"}}),
            "Leg solid 0 12; hole negative volume 0 12; Leg support blocker 0 12; ",
            {negative_hole, "left out 1 support blocker: 'Leg'"});

    const std::string cura = R"(<metadatagroup><metadata name="cura:cutting_mesh">True</metadata></metadatagroup>)";
    require(package(model_text(object(7, cura + cube_mesh(), "name=\"a\"") + cubes, item(7) + item(2))),
            "a modifier 0 12; object 2 solid 0 12; ", {"left out 1 modifier: 'a'"});
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
        const auto path = dir.write("a.3mf", prusa(volumes));
        CHECK(read_error(path).message == path.string() + ": part 'Metadata/Slic3r_PE_model.config', line " + message);
    }
    const auto path =
        dir.write("a.3mf", prusa(R"(<volume firstid="0" lastid="11"><metadata key="modifier" value="1"/></volume>)"));
    CHECK(read_error(path).message == path.string() + ": holds nothing solid: left out 1 modifier: 'object 1'");
}

}  // namespace
}  // namespace lamella
