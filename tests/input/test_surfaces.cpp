// GIfTI, FreeSurfer and glTF in every form. What is refused or warned of: cases/gifti.txt and cases/gltf.txt.
#include <random>

#include "read.hpp"

namespace lamella::input_test {

namespace {

/// What comes after the triangles of FreeSurfer: tags, and where the volume lay.
std::string footer(std::uint32_t frame, const std::string& valid, const std::string& centre) {
    return bytes_of(std::uint32_t{2}, true) + bytes_of(frame, true) + bytes_of(std::uint32_t{20}, true) +
           "valid = " + valid +
           "  # volume info valid\nfilename = a.mgz\nvolume = 256 256 256\nvoxelsize = 1.0 1.0 1.0\nxras   = -1.0 0.0 0.0\n"
           "yras   = 0.0 0.0 -1.0\nzras   = 0.0 1.0 0.0\ncras   = " +
           centre + "\n";
}

/// The file with the same triangles as `expected`, however it is made.
void gives(const std::string& name, const std::string& bytes, const Triangles& expected) {
    INFO(name);
    const Contents contents = read(dir.write(name, bytes));
    CHECK((contents.triangles == expected));
    CHECK(contents.warnings.empty());
}

std::string with_number(std::string bytes, std::size_t at, std::uint32_t number, bool big_endian) {
    return bytes.replace(at, 4, bytes_of(number, big_endian));
}

}  // namespace

TEST_CASE("GIfTI of every encoding, order and type gives the same triangles", "[input][gifti]") {
    const PolygonMesh mesh = triangulated(cube());
    for (const char* const encoding : {"ASCII", "Base64Binary", "GZipBase64Binary"}) {
        for (const char* const points : {"Float32", "Float64", "Int16", "UInt8"}) {
            for (const char* const integers : {"Int32", "UInt8", "Int64"}) {
                for (int form = 0; form < (std::string(encoding) == "ASCII" ? 1 : 4); ++form) {
                    CAPTURE(encoding, points, integers, form);
                    gives("a.surf.gii", Gifti{encoding, form % 2 > 0, form / 2 > 0, points, integers}(mesh),
                          mesh.triangles());
                    check_scalars(dir / "a.surf.gii", "vector");
                }
            }
        }
    }
    const std::string plain = Gifti{"Base64Binary"}(mesh);
    const std::size_t data = plain.find("<Data>") + 6;
    gives("blanks.gii", plain.substr(0, data) + "\n  " + plain.substr(data, 9) + "\r\n\t" + plain.substr(data + 9),
          mesh.triangles());
    refuses(dir.write("a.gii", plain.substr(0, data) + plain.substr(data + 4)),
            "triangles should have 144 bytes, but has 141");
    refuses(dir.write("a.gii", plain.substr(0, data) + "!!!!" + plain.substr(data + 4)), "triangles is malformed base64");
    const std::string packed = Gifti{"GZipBase64Binary"}(mesh);
    for (const char* const rows : {"11", "13", "4000000000"}) {
        refuses(dir.write("a.gii", replaced(packed, "Dim0=\"12\"", std::string("Dim0=\"") + rows + "\"")),
                "the array of triangles");
    }
    PolygonMesh bad = mesh;
    bad.faces[7][1] = 8;
    refuses(dir.write("a.gii", Gifti{"Base64Binary"}(bad)), "number 22: point 8 of triangles does not exist: there are 8");
}

TEST_CASE("FreeSurfer surfaces are read with one newline or two, and with any footer", "[input][freesurfer]") {
    const PolygonMesh mesh = triangulated(cube());
    const Triangles expected = mesh.triangles();
    for (const char* const text : {"made by a test\n\n", "made in 2019\n", "\n\n", "\n"}) {
        gives("lh.pial", freesurfer(mesh, text), expected);
        gives("lh.inflated", freesurfer(mesh, text), expected);
    }
    const std::string plain = freesurfer(mesh);
    const auto framed = [&](const std::string& end, PatientFrame frame, const Texts& warnings) {
        const Contents contents = read(dir.write("lh.white", plain + end));
        CHECK((contents.triangles == expected));
        CHECK(contents.mesh.patient_frame == frame);
        CHECK(contents.warnings == warnings);
    };
    framed(footer(1, "1", "5.0 -3.0 2.5"), PatientFrame::ras, {});
    framed(footer(0, "1", "0.0 0.0 0.0"), PatientFrame::unstated, {});
    framed(footer(0, "0", "5.0 -3.0 2.5"), PatientFrame::unstated, {});
    framed(footer(0, "1", "5.0 -3.0 2.5"), PatientFrame::unstated,
           {"points are as stored, in the surface's own frame, whose centre is at '5.0 -3.0 2.5' of the scanner's"});
    framed("tail", PatientFrame::unstated, {"ignored 4 bytes after the last triangle"});
}

TEST_CASE("FreeSurfer files with wrong counts or corners, and of other kinds, are refused", "[input][freesurfer]") {
    const PolygonMesh mesh = triangulated(cube());
    const std::string plain = freesurfer(mesh);
    const std::size_t counts = plain.find("\n\n") + 2;
    for (const std::uint32_t count : {9U, 0x7FFFFFFFU, 0xFFFFFFFFU}) {
        refuses(dir.write("lh.pial", with_number(plain, counts, count, true)),
                "is truncated: counts ... 12 triangles at 12 bytes");
        refuses(dir.write("lh.pial", with_number(plain, counts + 4, std::max(count, 13U), true)),
                "is truncated: counts 8 points");
    }
    for (const std::uint32_t corner : {8U, 0xFFFFFFFFU}) {
        const Error error = refuses(dir.write("lh.pial", with_number(plain, plain.size() - 8, corner, true)),
                                    "of triangles does not exist: there are 8");
        CHECK(error.byte_offset == static_cast<std::int64_t>(plain.size() - 8));
    }
    refuses(dir.write("lh.pial", freesurfer({{0, 0, 0}, {}})), "holds no triangles", ErrorCode::empty_mesh);
    for (const char* const magic : {"\xFF\xFF\xFF", "\xFF\xFF\xFD"}) {
        refuses(dir.write("lh.thickness", magic + plain.substr(3)), "FreeSurfer file of quads, or of numbers at points");
    }
    PolygonMesh like_stl = mesh;  // whose bytes at 80 count the three facets that an STL file of its size can have
    like_stl.xyz[0] = 1 + 3 * 0x1p-23;
    const std::string bytes = freesurfer(like_stl, std::string(64, 'x') + "\n\n");
    CHECK(bytes.substr(80, 4) == bytes_of(std::uint32_t{3}));
    gives("lh.sphere", bytes, like_stl.triangles());
}

TEST_CASE("binary glTF with wrong lengths, versions or chunks is refused", "[input][gltf]") {
    const PolygonMesh mesh = triangulated(cube());
    const std::string plain = glb(mesh);
    const std::size_t bin = 20 + plain.find("BIN") - 24;
    const auto refused = [&](std::size_t at, std::uint32_t number, const std::string& says) {
        refuses(dir.write("a.glb", with_number(plain, at, number, false)), says);
    };
    refused(4, 1, "is truncated, or no binary glTF of version 2: has version 1");
    refused(8, 11, "counts 11 bytes");
    for (const std::uint32_t length : {0xFFFFFFFFU, static_cast<std::uint32_t>(plain.size() + 1)}) {
        refused(8, length, "is truncated, or no binary glTF");
        refused(12, length, "is truncated, or has no chunk 'JSON' here");
        refused(bin, length, "has no chunk 'BIN?' here");
    }
    refused(16, 0, "has no chunk 'JSON' here");
    CHECK(warnings_of(dir.write("a.glb", plain + "tail")) ==
          Texts{"ignored bytes after the end of the binary glTF file: 4"});
    const MeshFile given = value_of(read_mesh(dir.write("a.glb", plain), {.mm_per_unit = 1}));
    CHECK((!given.states_unit && given.mm_per_unit == 1));
    PolygonMesh bad = mesh;
    bad.faces[3][2] = 8;
    refuses(dir.write("a.glb", glb(bad)), "number 11 of these is point 8, of 8");
}

TEST_CASE("buffers of glTF lie beside it, and nowhere else", "[input][gltf]") {
    const PolygonMesh mesh = triangulated(cube());
    const std::string whole = glb(mesh);
    const std::size_t bin = whole.find("BIN") + 4;
    const auto json = [&](const std::string& uri) {
        return replaced(whole.substr(20, bin - 28), "[{\"byteLength\"", "[{\"uri\":\"" + uri + "\",\"byteLength\"");
    };
    dir.write("a b.bin", whole.substr(bin));
    std::filesystem::create_directory(dir / "in");
    std::filesystem::copy_file(dir / "a b.bin", dir / "in" / "c.bin");
    Triangles expected = mesh.triangles();
    for (auto& triangle : expected) {
        std::for_each(triangle.begin(), triangle.end(), [](double& x) { x *= 1000; });
    }
    for (const char* const uri : {"a%20b.bin", "a b.bin", "in/c.bin"}) {
        gives("a.gltf", json(uri), expected);
        gives("a.gltf.gz", gzipped(json(uri)), expected);
    }
    for (const char* const uri : {"../a b.bin", "%2e%2e/a b.bin", "/etc/passwd", "in/../a b.bin", "in%5C..%5Cc.bin",
                                  "http://a/b.bin", "file:///etc/passwd", "a%00b", "in//c.bin", "."}) {
        refuses(dir.write("a.gltf", json(uri)), "needs '" + std::string(uri) + "', which is no file beside it");
    }
    refuses(dir.write("a.gltf", json("none.bin")), "needs none.bin: cannot be opened", ErrorCode::unreadable_file);
    refuses(dir.write("a.gltf", json("in")), "needs in: is a directory", ErrorCode::unreadable_file);
    CHECK(error_of(read_mesh(dir.write("a.gltf", json("in/c.bin")), {.name = "-"})).message ==
          "-: needs 'in/c.bin', a file beside it, and has no folder");
    dir.write("a b.bin", whole.substr(bin, 200));
    refuses(dir.write("a.gltf", json("a b.bin")), "is truncated: this buffer counts 240 bytes, but has 200");
}

TEST_CASE("surfaces with changed bytes are read or refused", "[input][gifti][freesurfer][gltf]") {
    const PolygonMesh mesh = triangulated(cube());
    std::mt19937 random(1);
    for (const std::string& good : {Gifti{}(mesh), Gifti{"Base64Binary"}(mesh), Gifti{"GZipBase64Binary", true, true}(mesh),
                                    freesurfer(mesh) + footer(0, "1", "1 2 3"), glb(mesh)}) {
        std::size_t read = 0;
        for (int round = 0; round < 4000; ++round) {
            std::string bytes = good;
            for (std::uint32_t changes = 1 + random() % 3; changes > 0; --changes) {
                bytes[random() % bytes.size()] =
                    round % 2 == 0 ? static_cast<char>(random()) : "0123456789-\"<>{}[],:"[random() % 20];
            }
            const Result<MeshFile> file =
                read_mesh(dir.write("a", bytes), {.scalars = round % 4 < 2, .memory_limit_bytes = 1 << 20}, {.threads = 1});
            read += file.ok() ? 1 : 0;
            CHECK((file.ok() ? check(file->view(), {.counts_only = true}).ok() || !file->indices.empty()
                             : file.error().message.find('\n') == std::string::npos));
        }
        CAPTURE(read);
        CHECK((read > 20 && read < 3950));
    }
}

}  // namespace lamella::input_test
