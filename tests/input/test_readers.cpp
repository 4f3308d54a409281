// Every reader gives the same triangles on any number of threads, reports the first of several errors, and takes no more
// memory than allowed.
#include <string>

#include "ply_writer.hpp"
#include "read.hpp"
#include "sheet_files.hpp"
#include "vtp_files.hpp"

namespace lamella::input_test {

namespace {

constexpr std::uint32_t side = 130;  // pieces of text are of 1 MB

/// Puts an x in the place of a number that begins after `near`, and returns where.
std::size_t damage(std::string& text, std::size_t near) {
    const bool is_stl = text.starts_with("solid");
    const std::size_t line = is_stl ? text.find("vertex", near) : text.find('\n', near);
    const std::size_t at = text.find_first_of("-0123456789", line);
    text[at] = 'x';
    return at;
}

}  // namespace

TEST_CASE("files of several pieces give every triangle once, in order, in every format", "[input][threads]") {
    const shapes::Soup soup = sheet_soup(side);
    Triangles expected(soup.size() / 9);
    for (std::size_t i = 0; i < soup.size(); ++i) {
        expected[i / 9][i % 9] = soup[i];
    }
    for (const SheetFile& file : sheet_files) {
        if (file.once) {
            INFO(file.name);
            const Contents contents = read(dir.write(file.name, file.bytes(side)));
            const auto in_mm = [&](const auto& triangle) {
                auto scaled = triangle;
                for (double& coordinate : scaled) {
                    coordinate *= contents.mesh.mm_per_unit;
                }
                return scaled;
            };
            Triangles placed;
            std::transform(expected.begin(), expected.end(), std::back_inserter(placed), in_mm);
            CHECK((contents.triangles == placed));
        }
    }
}

TEST_CASE("the first of several errors is reported on any number of threads", "[input][stl][obj][off][ply][vtk][threads]") {
    for (const SheetFile& file : sheet_files) {
        const std::string name = file.name;
        // Of VTP the offsets at the end are read before the corners.
        if ((name.starts_with("text") && name != "text.vtp") || name.starts_with("lines") || name == "quads.obj") {
            INFO(name);
            std::string text = file.bytes(side);
            for (const std::size_t part : {9U, 6U, 4U, 1U}) {
                const std::size_t at = damage(text, text.size() / 10 * part);
                CHECK(read_error(dir.write(name, text)).byte_offset == static_cast<std::int64_t>(at));
            }
        }
    }
}

TEST_CASE("what takes more memory than allowed is refused before it is allocated", "[input]") {
    vtk_test::PolyData strips = vtk_test::sheet(100);
    strips.strips.emplace_back();
    for (std::uint32_t i = 0; i < 20'000; ++i) {
        strips.strips[0].push_back(i % 10);
    }
    vtk_test::PolyData alike = vtk_test::sheet(150);
    for (auto& cell : alike.polygons) {
        cell = {0, 1, 2};
    }
    vtk_test::Xml packed{"raw", true};
    packed.block = 32768;
    const std::string pieces = repeated("<Piece NumberOfPoints=\"0\"/>", 5000);
    const ply_test::Faces large_faces(10, std::vector<double>(200, 1));
    const auto ply = [&](std::string_view encoding) {
        return ply_test::ply({.encoding = encoding, .index = "uchar"}, {0, 0, 0, 1, 0, 0, 0, 1, 0}, large_faces);
    };
    const std::string mesh = object(1, cube_mesh());
    const std::string vertices = repeated("<vertex x=\"1\" y=\"0\" z=\"2\"/>", 40000);
    std::string objects = mesh;
    for (int id = 2; id < 20000; ++id) {
        objects += object(id, components({R"(objectid="1")"}));
    }
    const std::string expands = "expands to more than the ";
    struct Case {
        const char* name;
        std::string bytes;
        std::uint64_t limit;
        std::string says;
        bool fits_by_default = true;
    };
    for (const auto& [name, bytes, limit, says, fits_by_default] : {
             Case{"a.stl.gz", deflated(std::string(std::size_t{8} << 20, '\0'), 16 + MAX_WBITS), 6 << 20, expands, false},
             Case{"a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf" + repeated(" 1", 400'000), 4'000'000,
                  "more than the 4000000 bytes that reading it may"},
             Case{"text.ply", ply("ascii"), 20'000, "expands to ... more than the 20000 bytes that reading"},
             Case{"little.ply", ply("binary_little_endian"), 20'000,
                  "expands to ... more than the 20000 bytes that reading"},
             Case{"big.ply", ply("binary_big_endian"), 20'000, "expands to ... more than the 20000 bytes that reading"},
             Case{"text.vtk", vtk_test::Legacy{true}(strips), 200'000, expands},
             Case{"binary.vtk", vtk_test::Legacy{false}(strips), 200'000, expands},
             Case{"a.vtp", packed({alike}), 500'000, expands},
             Case{"many.vtp", replaced(vtk_test::Xml{}({vtk_test::cube()}), "<PolyData>", "<PolyData>" + pieces), 500'000,
                  "expands"},
             Case{"spaces.3mf", package(model_text(mesh + std::string(std::size_t{24} << 20, ' '), item(1))), 8 << 20,
                  "part '3D/3dmodel.model' " + expands},
             Case{"vertices.3mf", package(model_text(replaced(mesh, "</vertices>", vertices + "</vertices>"), item(1))),
                  1 << 20, ": takes more than the 1048576 bytes that reading it may"},
             Case{"objects.3mf", package(model_text(objects, item(1))), 1 << 20,
                  ": takes more than the 1048576 bytes that reading it may"},
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
