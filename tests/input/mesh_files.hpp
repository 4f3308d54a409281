// Meshes of polygons, and files of them in every format and every form that the readers know.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "files.hpp"

namespace lamella::input_test {

/// Nine coordinates each.
using Triangles = std::vector<std::array<double, 9>>;
/// Corners of faces or strips, which may be wrong on purpose.
using Rows = std::vector<std::vector<std::int64_t>>;

struct PolygonMesh {
    std::vector<double> xyz;
    Rows faces;
    Rows strips{};  ///< written as PLY and VTK only

    std::size_t points() const { return xyz.size() / 3; }
    /// The triangles that must be read: convex faces as fans, then strips with every other triangle the other way round.
    Triangles triangles() const;
};

Triangles triangles_of(const Soup& soup);
PolygonMesh mesh_of(const Soup& soup);

/// From 0 to `edge` mm, six quads.
PolygonMesh cube(double edge = 10);
PolygonMesh cube_with_strips();
/// The same faces as triangles.
PolygonMesh triangulated(PolygonMesh mesh);
/// A sheet of side * side quads: those before the `quads`-th as two triangles each.
PolygonMesh sheet(std::uint32_t side, std::uint32_t quads);

/// Indices from the front and from the back, alone and with those of normals.
std::string obj(const PolygonMesh& mesh);
std::string off(const PolygonMesh& mesh);

inline constexpr std::array ply_encodings = {"ascii", "binary_little_endian", "binary_big_endian"};

/// How a mesh is written as PLY.
struct Ply {
    std::string encoding = "ascii";
    std::string coordinate = "float";
    std::string count = "uchar";
    std::string index = "int";
    std::string index_name = "vertex_indices";
    std::string comment{};
    std::array<std::size_t, 3> axes = {0, 1, 2};  ///< the order in which x, y and z come
    bool faces_first = false;
    bool extra_numbers = false;   ///< between and around the properties that are used
    bool extra_lists = false;     ///< so too, also among the vertices
    bool extra_elements = false;  ///< before, between and after

    std::string operator()(const PolygonMesh& mesh) const;
};

/// How a mesh is written as legacy VTK.
struct Vtk {
    bool text = true;
    int version = 3;
    std::string points = "float";
    std::string integers = "vtktypeint64";  ///< of offsets and connectivity, from version 5 on
    std::string extra{};                    ///< between points and cells
    std::string title = "a title";

    std::string operator()(const PolygonMesh& mesh) const;

private:
    std::string cells(const std::string& name, const Rows& cells) const;
    template <class Row>
    std::string rows(const std::string& type, const std::vector<Row>& all) const;
};

/// How meshes are written as VTP, each as a piece. All arrays are stored in one way.
struct Vtp {
    std::string format = "ascii";  ///< or "binary", or "raw" or "base64" for those that are appended
    bool zlib = false;
    bool big_endian = false;
    bool wide = true;  ///< headers of 64 bits
    std::string points = "Float32";
    std::string integers = "Int64";
    std::size_t block = 64;
    std::string field{};     ///< before the pieces
    bool decoys = true;      ///< arrays that are not read, under names of some that are
    std::string appended{};  ///< what has been appended so far

    std::string header(const std::vector<std::uint64_t>& numbers) const;
    std::string element(const std::string& attributes, const std::string& data);
    std::string operator()(const std::vector<PolygonMesh>& pieces);

private:
    std::string stored(const std::string& data) const;
    template <class Row>
    std::string array(const std::string& attributes, const std::string& type, const std::vector<Row>& rows);
    std::string cells(const std::string& name, const Rows& cells);
    std::string piece(const PolygonMesh& mesh);
};

std::string base64(const std::string& bytes);

/// How a mesh of triangles is written as GIfTI.
struct Gifti {
    std::string encoding = "ASCII";  ///< or "Base64Binary" or "GZipBase64Binary"
    bool by_columns = false;
    bool big_endian = false;
    std::string points = "Float32";
    std::string integers = "Int32";

    std::string operator()(const PolygonMesh& mesh) const;

private:
    template <class Row>
    std::string array(const std::string& intent, const std::string& type, const std::vector<Row>& rows) const;
};

/// A mesh of triangles as a surface of FreeSurfer, with what is between its mark and its numbers.
std::string freesurfer(const PolygonMesh& mesh, const std::string& text = "made by a test\n\n");

/// A mesh of triangles as binary glTF.
std::string glb(const PolygonMesh& mesh);

/// A part of an archive, and what its headers say of it where that is not the truth.
struct ZipPart {
    std::string name;
    std::string contents;
    bool deflated = true;
    std::uint16_t flags = 0;
    int method = -1;                 ///< -1: as it is
    std::uint32_t false_crc = 0;     ///< added to the checksum
    std::uint32_t excess_bytes = 0;  ///< added to the expanded size
};

std::string zip(const std::vector<ZipPart>& parts);

/// Of a 3MF package whose root part is `model`.
std::vector<ZipPart> package_parts(const std::string& model);
inline std::string package(const std::string& model) {
    return zip(package_parts(model));
}
std::string model_text(const std::string& resources, const std::string& items, const std::string& attributes = "");
/// The element of a mesh, which is one of triangles.
std::string mesh_xml(const PolygonMesh& mesh);
std::string object(int id, const std::string& contents, const std::string& attributes = "");
std::string item(int id, const std::string& attributes = "");
std::string components(const std::vector<std::string>& list);

}  // namespace lamella::input_test
