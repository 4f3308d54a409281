// Every reader gives the same triangles on any number of threads, reports the first of several errors, refuses files that
// are cut off, and takes no more memory than allowed.
#include "read.hpp"
#include "sheet_files.hpp"

namespace lamella::input_test {

namespace {

constexpr std::uint32_t side = 130;  // pieces of text are of 1 MB

/// Puts an x in the place of a number that begins after `near`, and returns where.
std::size_t damage(std::string& text, std::size_t near) {
    const std::size_t line = text.starts_with("solid") ? text.find("vertex", near) : text.find('\n', near);
    const std::size_t at = text.find_first_of("-0123456789", line);
    text[at] = 'x';
    return at;
}

/// A file of only the first bytes of `whole`, [first, end) of them in turn, and `rest`, must be refused: as malformed, or as
/// empty where it may be. Each is read in one of four ways.
void refuses_cuts(const std::string& name, const std::string& whole, std::size_t first, std::size_t end,
                  bool may_be_empty = false, const std::string& rest = "") {
    for (std::size_t length = first; length < end; ++length) {
        INFO(name << " " << length);
        const Error error = error_of(read_mesh(dir.write(name, whole.substr(0, length) + rest),
                                               {.map_file = length % 2 == 1}, {.threads = length % 4 == 3 ? 3 : 1}));
        CHECK((error.code == ErrorCode::malformed_mesh || (may_be_empty && error.code == ErrorCode::empty_mesh)));
        CHECK(error.byte_offset <= static_cast<std::int64_t>(length + rest.size()));
    }
}

}  // namespace

TEST_CASE("files of several pieces give every triangle once, in order, in every format", "[input][threads]") {
    for (const SheetFile& file : sheet_files) {
        if (file.once) {
            INFO(file.name);
            const Contents contents = read(dir.write(file.name, bytes_of(file, side)));
            Triangles expected = sheet(side, 0).triangles();
            for (auto& triangle : expected) {
                for (double& coordinate : triangle) {
                    coordinate *= contents.mesh.mm_per_unit;
                }
            }
            CHECK((contents.triangles == expected));
        }
    }
}

TEST_CASE("the first of several errors is reported on any number of threads", "[input][stl][obj][off][ply][vtk][threads]") {
    for (const SheetFile& file : sheet_files) {
        const std::string name = file.name;
        // Of VTP the offsets at the end are read before the corners.
        if ((name.starts_with("text") && name != "text.vtp") || name.starts_with("lines") || name == "quads.obj") {
            INFO(name);
            std::string text = bytes_of(file, side);
            for (const std::size_t part : {9U, 6U, 4U, 1U}) {
                const std::size_t at = damage(text, text.size() / 10 * part);
                CHECK(read_error(dir.write(name, text)).byte_offset == static_cast<std::int64_t>(at));
            }
        }
    }
}

TEST_CASE("a 3MF file and a PLY file cut off anywhere are refused", "[input][3mf][ply]") {
    const std::string cubes = package(model_text(object(1, mesh_xml(triangulated(cube()))), item(1)));
    refuses_cuts("a.3mf", cubes, 4, cubes.size());
    Ply form{GENERATE(from_range(ply_encodings))};
    form.faces_first = GENERATE(false, true);
    form.extra_elements = form.extra_lists = GENERATE(false, true);
    const std::string bytes = form(triangulated(cube()));
    // What is left of the last number of text may be a number, too.
    refuses_cuts("a.ply", bytes, 4, form.encoding == "ascii" ? bytes.rfind(' ') + 2 : bytes.size());
}

TEST_CASE("legacy VTK cut off anywhere is refused", "[input][vtk]") {
    Vtk form{GENERATE(false, true), GENERATE(3, 5)};
    form.extra = std::string("FIELD FieldData 2\nnote 1 1 string\n") + (form.text ? "" : "\xC3") + "abc\nt 1 1 double\n" +
                 (form.text ? "7\n" : std::string(8, '\0') + "\n");
    const std::string whole = form(cube());
    const std::size_t complete = whole.size() - 1;  // after the last number
    CHECK(read_triangles(dir.write("a.vtk", whole.substr(0, complete))) == cube().triangles());
    // Where a section ends, nothing is wrong but what is missing.
    refuses_cuts("a.vtk", whole, 22, complete, true);
}

TEST_CASE("VTP and its appended data cut off anywhere are refused", "[input][vtp]") {
    const std::string format = GENERATE(as<std::string>(), "ascii", "binary", "raw", "base64");
    const bool zlib = GENERATE(false, true) && format != "ascii";
    const std::string whole = Vtp{format, zlib}({cube()});
    const std::size_t data = whole.find('_', whole.find("<AppendedData"));
    const std::size_t end = whole.rfind("\n</AppendedData");
    // All that is read lies before the end of the appended data.
    const std::size_t complete = end != std::string::npos ? end + 15 : whole.rfind('>') + 1;
    refuses_cuts("a.vtp", whole, whole.find("<VTKFile") + 8, complete);
    CHECK(read_triangles(dir.write("a.vtp", whole.substr(0, complete))) == cube().triangles());
    if (end != std::string::npos) {
        refuses_cuts("a.vtp", whole, data + 1, end, false, whole.substr(end + 1));
    }
}

TEST_CASE("GIfTI, FreeSurfer and glTF cut off anywhere are refused", "[input][gifti][freesurfer][gltf]") {
    const PolygonMesh mesh = triangulated(cube());
    for (const char* const encoding : {"ASCII", "Base64Binary", "GZipBase64Binary"}) {
        const std::string whole = Gifti{encoding}(mesh);
        refuses_cuts("a.gii", whole, whole.find("<GIFTI") + 6, whole.size() - 1);
    }
    const std::string surface = freesurfer(mesh);
    refuses_cuts("lh.pial", surface, 3, surface.size());
    const std::string scene = glb(mesh);
    refuses_cuts("a.glb", scene, 4, scene.size());
    const std::size_t json = scene.find("BIN") - 4;
    refuses_cuts("a.gltf", scene.substr(20, json - 20), 20, scene.find_last_of('}', json) - 19);
}

TEST_CASE("what takes more memory than allowed is refused before it is allocated", "[input]") {
    PolygonMesh strips = sheet(100, 5000);
    strips.strips.emplace_back();
    for (int i = 0; i < 20'000; ++i) {
        strips.strips[0].push_back(i % 10);
    }
    PolygonMesh alike = sheet(150, 0);
    alike.faces.assign(alike.faces.size(), {0, 1, 2});
    Vtp packed{"raw", true};
    packed.block = 32768;
    const std::string pieces = repeated("<Piece NumberOfPoints=\"0\"/>", 5000);
    const PolygonMesh large_faces = {{0, 0, 0, 1, 0, 0, 0, 1, 0}, Rows(10, std::vector<std::int64_t>(200, 1))};
    const auto ply = [&](const std::string& encoding) { return Ply{.encoding = encoding, .index = "uchar"}(large_faces); };
    const std::string mesh = object(1, mesh_xml(triangulated(cube())));
    const std::string vertices = repeated("<vertex x=\"1\" y=\"0\" z=\"2\"/>", 40000);
    std::string objects = mesh;
    for (int id = 2; id < 20000; ++id) {
        objects += object(id, components({R"(objectid="1")"}));
    }
    std::string nodes = "[{\"mesh\":0}";
    std::string places = "[0";
    for (int i = 1; i < 4000; ++i) {
        nodes += ",{\"mesh\":0}";
        places += "," + std::to_string(i);
    }
    const std::string instances =
        replaced(replaced(glb(triangulated(cube())), "[{\"mesh\":0}", nodes), "[0]}]", places + "]}]");
    const std::string expands = "expands to more than the ";
    const std::string expands_to = "expands to ... more than the 20000 bytes that reading";
    struct Case {
        const char* name;
        std::string bytes;
        std::uint64_t limit;
        std::string says;
        bool fits_by_default = true;
    };
    for (const auto& [name, bytes, limit, says, fits_by_default] : {
             Case{"a.stl.gz", gzipped(std::string(std::size_t{8} << 20, '\0')), 6 << 20, expands, false},
             Case{"a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf" + repeated(" 1", 400'000), 4'000'000,
                  "more than the 4000000 bytes that reading it may"},
             Case{"text.ply", ply("ascii"), 20'000, expands_to},
             Case{"little.ply", ply("binary_little_endian"), 20'000, expands_to},
             Case{"big.ply", ply("binary_big_endian"), 20'000, expands_to},
             Case{"text.vtk", Vtk{true}(strips), 200'000, expands},
             Case{"binary.vtk", Vtk{false}(strips), 200'000, expands},
             Case{"a.vtp", packed({alike}), 500'000, expands},
             Case{"many.vtp", replaced(Vtp{}({cube()}), "<PolyData>", "<PolyData>" + pieces), 500'000, "expands"},
             Case{"zlib.gii", Gifti{"GZipBase64Binary"}(triangulated(alike)), 500'000, expands},
             Case{"columns.gii", Gifti{"Base64Binary", true}(triangulated(alike)), 800'000, expands},
             Case{"nodes.gltf",
                  replaced(instances.substr(20, instances.find("BIN") - 24), "[{\"byteLength\":",
                           "[{\"uri\":\"data:;base64," + base64(instances.substr(instances.find("BIN") + 4)) +
                               "\",\"byteLength\":"),
                  4'000'000, expands},
             Case{"spaces.3mf", package(model_text(mesh + std::string(std::size_t{24} << 20, ' '), item(1))), 8 << 20,
                  "part '3D/3dmodel.model' " + expands},
             Case{"vertices.3mf", package(model_text(replaced(mesh, "</vertices>", vertices + "</vertices>"), item(1))),
                  1 << 20, ": expands to more than the 1048576 bytes that reading it may take"},
             Case{"objects.3mf", package(model_text(objects, item(1))), 1 << 20,
                  ": expands to more than the 1048576 bytes that reading it may take"},
         }) {
        INFO(name);
        const auto path = dir.write(name, bytes);
        const Error error = error_of(read_mesh(path, {.memory_limit_bytes = limit}));
        CHECK(error.code == ErrorCode::out_of_memory);
        check_says(error.message, says);
        CHECK(read_mesh(path).ok() == fits_by_default);
    }
}

}  // namespace lamella::input_test
