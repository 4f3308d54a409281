#include "input/mesh_files.hpp"

#include "input/encoded.hpp"

namespace lamella::input_test {

namespace {

std::string little(std::uint32_t number) {
    return bytes_of(number);
}
std::string little16(std::size_t number) {
    return bytes_of(static_cast<std::uint16_t>(number));
}

std::vector<std::array<double, 3>> points_of(const PolygonMesh& mesh) {
    std::vector<std::array<double, 3>> points;
    for (std::size_t i = 0; i < mesh.xyz.size(); i += 3) {
        points.push_back({mesh.xyz[i], mesh.xyz[i + 1], mesh.xyz[i + 2]});
    }
    return points;
}

/// The rows, and before each of them how long it is.
Rows counted(const Rows& rows) {
    Rows all = rows;
    for (auto& row : all) {
        row.insert(row.begin(), static_cast<std::int64_t>(row.size()));
    }
    return all;
}

/// Where each row ends, were they one.
Rows ends_of(const Rows& rows) {
    Rows ends;
    std::int64_t end = 0;
    for (const auto& row : rows) {
        ends.push_back({end += static_cast<std::int64_t>(row.size())});
    }
    return ends;
}

}  // namespace

Triangles PolygonMesh::triangles() const {
    Triangles triangles;
    const auto add = [&](std::int64_t a, std::int64_t b, std::int64_t c) {
        auto& triangle = triangles.emplace_back();
        const std::array corners{a, b, c};
        for (std::size_t i = 0; i < 9; ++i) {
            triangle[i] = xyz[3 * static_cast<std::size_t>(corners[i / 3]) + i % 3];
        }
    };
    for (const auto& face : triangulated(*this).faces) {
        add(face[0], face[1], face[2]);
    }
    for (const auto& strip : strips) {
        for (std::size_t i = 2; i < strip.size(); ++i) {
            add(strip[i - 2 + i % 2], strip[i - 1 - i % 2], strip[i]);
        }
    }
    return triangles;
}

Triangles triangles_of(const Soup& soup) {
    Triangles triangles(soup.size() / 9);
    for (std::size_t i = 0; i < soup.size(); ++i) {
        triangles[i / 9][i % 9] = soup[i];
    }
    return triangles;
}

PolygonMesh mesh_of(const Soup& soup) {
    const shapes::Indexed indexed = shapes::indexed(soup);
    PolygonMesh mesh{indexed.xyz, {}};
    for (std::size_t i = 0; i < indexed.indices.size(); i += 3) {
        mesh.faces.push_back({indexed.indices[i], indexed.indices[i + 1], indexed.indices[i + 2]});
    }
    return mesh;
}

PolygonMesh cube(double edge) {
    PolygonMesh mesh;
    for (int i = 0; i < 8; ++i) {
        mesh.xyz.insert(mesh.xyz.end(), {i % 2 * edge, i / 2 % 2 * edge, i / 4 * edge});
    }
    mesh.faces = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    return mesh;
}

PolygonMesh cube_with_strips() {
    PolygonMesh mesh = cube();
    mesh.strips = {{0, 1, 2, 3, 4, 5}, {7, 6, 5}};
    return mesh;
}

PolygonMesh triangulated(PolygonMesh mesh) {
    Rows faces;
    for (const auto& face : mesh.faces) {
        for (std::size_t i = 2; i < face.size(); ++i) {
            faces.push_back({face[0], face[i - 1], face[i]});
        }
    }
    mesh.faces = std::move(faces);
    return mesh;
}

PolygonMesh sheet(std::uint32_t side, std::uint32_t quads) {
    PolygonMesh mesh;
    for (std::uint32_t i = 0; i < (side + 1) * (side + 1); ++i) {
        const std::uint32_t x = i % (side + 1);
        const std::uint32_t y = i / (side + 1);
        mesh.xyz.insert(mesh.xyz.end(), {double(x), double(y), (x * y) % 7 / 64.0});
    }
    for (std::uint32_t i = 0; i < side * side; ++i) {
        const std::uint32_t first = i / side * (side + 1) + i % side;
        const std::uint32_t above = first + side + 1;
        if (i >= quads) {
            mesh.faces.push_back({first, first + 1, above + 1, above});
        } else {
            mesh.faces.push_back({first, first + 1, above + 1});
            mesh.faces.push_back({first, above + 1, above});
        }
    }
    return mesh;
}

std::string obj(const PolygonMesh& mesh) {
    std::string text = "# body\no body\nvn 0 0 1\n";
    for (const auto& point : points_of(mesh)) {
        text += "v " + encoded_rows("double", std::vector{point}, Coding::text);
    }
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        text += "f";
        for (const std::int64_t index : mesh.faces[f]) {
            text += " " + std::to_string(f % 3 == 2 ? index - static_cast<std::int64_t>(mesh.points()) : index + 1);
            text += f % 3 == 1 ? "//1" : "";
        }
        text += "\n";
    }
    return text;
}

std::string off(const PolygonMesh& mesh) {
    return "OFF\n" + std::to_string(mesh.points()) + " " + std::to_string(mesh.faces.size()) + " 0\n" +
           encoded_rows("double", points_of(mesh), Coding::text) + encoded_rows("long", counted(mesh.faces), Coding::text);
}

// --- PLY

namespace {

/// A file, number by number.
struct PlyWriter {
    const Ply& form;
    Coding coding = form.encoding == "ascii"                  ? Coding::text
                    : form.encoding == "binary_little_endian" ? Coding::little_endian
                                                              : Coding::big_endian;
    std::string header = "ply\nformat " + form.encoding + " 1.0\n";
    std::string body{};

    void number(const std::string& type, double value) { body += encoded(type, value, coding); }
    void list(const std::string& count, const std::string& type, const auto& values) {
        number(count, static_cast<double>(values.size()));
        for (const auto value : values) {
            number(type, static_cast<double>(value));
        }
    }
    /// In text each row ends with its line.
    void end_row() { body.back() = coding == Coding::text ? '\n' : body.back(); }
    void element(const std::string& name, std::size_t count) {
        header += "element " + name + " " + std::to_string(count) + "\n";
    }
    void declare_extra(const std::string& name) {
        header += form.extra_numbers ? "property double " + name + "\nproperty uchar " + name + "_too\n" : "";
        header += form.extra_lists ? "property list ushort float " + name + "_list\n" : "";
    }
    /// Further values of row `row`; the lengths of lists vary.
    void extra(std::size_t row) {
        if (form.extra_numbers) {
            number("double", -0.5);
            number("uchar", 200);
        }
        if (form.extra_lists) {
            list("ushort", "float", std::vector<double>(row % 3, 7.25));
        }
    }
    void other(const std::string& name) {
        if (form.extra_elements) {
            element(name, 4);
            header += "property int id\nproperty list int uchar names\n";
            for (std::size_t row = 0; row < 4; ++row) {
                number("int", -7);
                list("int", "uchar", std::vector<double>(row, 65));
                end_row();
            }
        }
    }
    void vertices(const PolygonMesh& mesh) {
        element("vertex", mesh.points());
        for (const std::size_t axis : form.axes) {
            declare_extra("before" + std::to_string(axis));
            header += "property " + form.coordinate + " " + "xyz"[axis] + "\n";
        }
        declare_extra("after");
        for (std::size_t v = 0; v < mesh.points(); ++v) {
            for (const std::size_t axis : form.axes) {
                extra(v + axis);
                number(form.coordinate, mesh.xyz[3 * v + axis]);
            }
            extra(v);
            end_row();
        }
    }
    void faces(const std::string& name, const Rows& rows) {
        element(name, rows.size());
        declare_extra("before");
        header += "property list " + form.count + " " + form.index + " " + form.index_name + "\n";
        declare_extra("after");
        for (std::size_t f = 0; f < rows.size(); ++f) {
            extra(f);
            list(form.count, form.index, rows[f]);
            extra(f + 1);
            end_row();
        }
    }
};

}  // namespace

std::string Ply::operator()(const PolygonMesh& mesh) const {
    PlyWriter out{*this};
    out.header += comment.empty() ? "" : "comment " + comment + "\n";
    out.other("camera");
    for (const bool faces : {faces_first, !faces_first}) {
        if (faces && (!mesh.faces.empty() || mesh.strips.empty())) {
            out.faces("face", mesh.faces);
        } else if (faces) {
            out.faces("tristrips", mesh.strips);
        } else {
            out.vertices(mesh);
        }
        out.other(faces == faces_first ? "edge" : "material");
    }
    return out.header + "end_header\n" + out.body;
}

// --- Legacy VTK

template <class Row>
std::string Vtk::rows(const std::string& type, const std::vector<Row>& all) const {
    return encoded_rows(type, all, text ? Coding::text : Coding::big_endian) + (text ? "" : "\n");
}

std::string Vtk::cells(const std::string& name, const Rows& cells) const {
    if (cells.empty()) {
        return "";
    }
    Rows offsets = ends_of(cells);
    const std::string corners = std::to_string(offsets.back()[0]);
    if (version < 5) {
        return name + " " + std::to_string(cells.size()) + " " + std::to_string(cells.size() + std::stoul(corners)) + "\n" +
               rows("int", counted(cells));
    }
    offsets.insert(offsets.begin(), {0});
    return name + " " + std::to_string(offsets.size()) + " " + corners + "\nOFFSETS " + integers + "\n" +
           rows(integers, offsets) + "CONNECTIVITY " + integers + "\n" + rows(integers, cells);
}

std::string Vtk::operator()(const PolygonMesh& mesh) const {
    return "# vtk DataFile Version " + std::to_string(version) + (version == 5 ? ".1\n" : ".0\n") + title +
           (text ? "\nASCII" : "\nBINARY") + "\nDATASET POLYDATA\nPOINTS " + std::to_string(mesh.points()) + " " + points +
           "\n" + rows(points, points_of(mesh)) + extra + cells("POLYGONS", mesh.faces) +
           cells("TRIANGLE_STRIPS", mesh.strips);
}

// --- VTP

std::string base64(const std::string& bytes) {
    constexpr std::string_view alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t bits = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            bits = bits << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0);
        }
        for (std::size_t k = 0; k < 4; ++k) {
            text += i + k > bytes.size() ? '=' : alphabet[bits >> (18 - 6 * k) & 63];
        }
    }
    return text;
}

std::string Vtp::header(const std::vector<std::uint64_t>& numbers) const {
    std::string bytes;
    for (const std::uint64_t number : numbers) {
        bytes += encoded(wide ? "UInt64" : "UInt32", number, big_endian ? Coding::big_endian : Coding::little_endian);
    }
    return bytes;
}

std::string Vtp::stored(const std::string& data) const {
    std::string head = header({data.size()});
    std::string body = data;
    if (zlib) {
        std::vector<std::uint64_t> counts{(data.size() + block - 1) / block, block, data.size() % block};
        body.clear();
        for (std::size_t at = 0; at < data.size(); at += block) {
            const std::string packed = deflated(data.substr(at, block), MAX_WBITS);
            counts.push_back(packed.size());
            body += packed;
        }
        head = header(counts);
    }
    return format == "raw" ? head + body : zlib ? base64(head) + base64(body) : base64(head + body);
}

std::string Vtp::element(const std::string& attributes, const std::string& data) {
    const std::string start = "<DataArray " + attributes + " format=\"";
    if (format == "ascii" || format == "binary") {
        return start + format + "\">" + (format == "ascii" ? data : stored(data)) + "</DataArray>\n";
    }
    const std::string offset = std::to_string(appended.size());
    appended += stored(data);
    return start + "appended\" offset=\"" + offset + "\"><InformationKey name=\"a\"/></DataArray>\n";
}

template <class Row>
std::string Vtp::array(const std::string& attributes, const std::string& type, const std::vector<Row>& rows) {
    const Coding coding = format == "ascii" ? Coding::text : big_endian ? Coding::big_endian : Coding::little_endian;
    return element("type=\"" + type + "\" " + attributes, encoded_rows(type, rows, coding));
}

std::string Vtp::cells(const std::string& name, const Rows& cells) {
    // One by one: each array is appended as it is made. The golden file has a blank at the end of the first one's lines.
    std::string xml = array("Name=\"connectivity\"", integers, cells);
    xml = "<" + name + ">\n" + (format == "ascii" ? replaced(replaced(xml, "\n", " \n"), "> \n", ">\n") : xml);
    xml += array("Name=\"offsets\"", integers, ends_of(cells));
    return xml + "</" + name + ">\n";
}

std::string Vtp::piece(const PolygonMesh& mesh) {
    std::string xml = "<Piece NumberOfPoints=\"" + std::to_string(mesh.points()) +
                      "\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"" + std::to_string(mesh.strips.size()) +
                      "\" NumberOfPolys=\"" + std::to_string(mesh.faces.size()) + "\">\n";
    const std::string three = "NumberOfComponents=\"3\"";
    xml += decoys ? "<PointData>" + array("Name=\"Points\" " + three, points, points_of(mesh)) + "</PointData>\n" : "";
    xml += "<Points>\n" + array(three, points, points_of(mesh)) + "</Points>\n";
    xml += decoys ? "<Verts>" + array("Name=\"connectivity\"", "Int64", Rows{}) + "</Verts>\n" : "";
    return xml + (mesh.strips.empty() ? "" : cells("Strips", mesh.strips)) + cells("Polys", mesh.faces) + "</Piece>\n";
}

std::string Vtp::operator()(const std::vector<PolygonMesh>& pieces) {
    appended.clear();
    std::string file = std::string("<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"") +
                       (big_endian ? "BigEndian" : "LittleEndian") + "\"" + (wide ? " header_type=\"UInt64\"" : "") +
                       (zlib ? " compressor=\"vtkZLibDataCompressor\"" : "") + ">\n<PolyData>\n" + field;
    for (const PolygonMesh& mesh : pieces) {
        file += piece(mesh);
    }
    file += "</PolyData>\n";
    if (format == "raw" || format == "base64") {
        file += "<AppendedData encoding=\"" + format + "\">\n _" + appended + "\n</AppendedData>\n";
    }
    return file + "</VTKFile>\n";
}

// --- GIfTI, FreeSurfer, glTF

template <class Row>
std::string Gifti::array(const std::string& intent, const std::string& type, const std::vector<Row>& rows) const {
    std::vector<std::vector<typename Row::value_type>> lines(by_columns ? 3 : rows.size());
    for (std::size_t i = 0; i < 3 * rows.size(); ++i) {
        lines[by_columns ? i % 3 : i / 3].push_back(rows[i / 3][i % 3]);
    }
    const Coding coding = encoding == "ASCII" ? Coding::text : big_endian ? Coding::big_endian : Coding::little_endian;
    const std::string bytes = encoded_rows(type, lines, coding);
    std::string name = type;
    std::transform(name.begin(), name.end(), name.begin(), ::toupper);
    return "<DataArray Intent=\"NIFTI_INTENT_" + intent + "\" DataType=\"NIFTI_TYPE_" + name + "\" ArrayIndexingOrder=\"" +
           (by_columns ? "Column" : "Row") + "MajorOrder\" Dimensionality=\"2\" Dim0=\"" + std::to_string(rows.size()) +
           "\" Dim1=\"3\" Encoding=\"" + encoding + "\" Endian=\"" + (big_endian ? "Big" : "Little") + "Endian\">\n<Data>" +
           (encoding == "ASCII"          ? bytes
            : encoding == "Base64Binary" ? base64(bytes)
                                         : base64(deflated(bytes, MAX_WBITS))) +
           "</Data></DataArray>\n";
}

std::string Gifti::operator()(const PolygonMesh& mesh) const {
    return "<?xml version=\"1.0\"?>\n<!DOCTYPE GIFTI SYSTEM \"gifti.dtd\">\n<GIFTI>\n" +
           array("TRIANGLE", integers, mesh.faces) + array("POINTSET", points, points_of(mesh)) +
           array("VECTOR", points, points_of(mesh)) + "</GIFTI>\n";
}

std::string freesurfer(const PolygonMesh& mesh, const std::string& text) {
    return "\xFF\xFF\xFE" + text +
           encoded_rows("int", Rows{{std::int64_t(mesh.points()), std::int64_t(mesh.faces.size())}}, Coding::big_endian) +
           encoded_rows("float", points_of(mesh), Coding::big_endian) + encoded_rows("int", mesh.faces, Coding::big_endian);
}

std::string glb(const PolygonMesh& mesh) {
    const std::string points = encoded_rows("float", points_of(mesh), Coding::little_endian);
    const std::string faces = encoded_rows("uint", mesh.faces, Coding::little_endian);
    const auto bytes = [](std::size_t count) { return "\"byteLength\":" + std::to_string(count); };
    std::string json =
        R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}],"meshes":[{"primitives":[)"
        R"({"attributes":{"POSITION":0},"indices":1}]}],"accessors":[{"bufferView":0,"componentType":5126,"count":)" +
        std::to_string(mesh.points()) + R"(,"type":"VEC3"},{"bufferView":1,"componentType":5125,"type":"SCALAR","count":)" +
        std::to_string(3 * mesh.faces.size()) + R"(}],"bufferViews":[{"buffer":0,)" + bytes(points.size()) +
        R"(},{"buffer":0,"byteOffset":)" + std::to_string(points.size()) + "," + bytes(faces.size()) + "}],\"buffers\":[{" +
        bytes(points.size() + faces.size()) + "}]}";
    json.append(-json.size() % 4, ' ');
    const std::string chunks = little(static_cast<std::uint32_t>(json.size())) + "JSON" + json +
                               little(static_cast<std::uint32_t>(points.size() + faces.size())) + std::string("BIN\0", 4) +
                               points + faces;
    return "glTF" + little(2) + little(static_cast<std::uint32_t>(12 + chunks.size())) + chunks;
}

// --- 3MF

std::string zip(const std::vector<ZipPart>& parts) {
    std::string archive;
    std::string directory;
    for (const ZipPart& part : parts) {
        const std::string packed = part.deflated ? deflated(part.contents) : part.contents;
        const auto crc = static_cast<std::uint32_t>(
            crc32(0, reinterpret_cast<const Bytef*>(part.contents.data()), static_cast<uInt>(part.contents.size())));
        const int method = part.method >= 0 ? part.method : (part.deflated ? 8 : 0);
        // What the local header and the directory have in common, from the version on.
        const std::string fields = little16(20) + bytes_of(part.flags) + bytes_of(static_cast<std::uint16_t>(method)) +
                                   little(0x21 << 16) + little(crc + part.false_crc) +
                                   little(static_cast<std::uint32_t>(packed.size())) +
                                   little(static_cast<std::uint32_t>(part.contents.size()) + part.excess_bytes) +
                                   little16(part.name.size()) + little16(0);
        directory += "PK\1\2" + little16(20) + fields + std::string(10, '\0') +
                     little(static_cast<std::uint32_t>(archive.size())) + part.name;
        archive += "PK\3\4" + fields + part.name + packed;
    }
    return archive + directory + "PK\5\6" + std::string(4, '\0') + little16(parts.size()) + little16(parts.size()) +
           little(static_cast<std::uint32_t>(directory.size())) + little(static_cast<std::uint32_t>(archive.size())) +
           little16(0);
}

std::vector<ZipPart> package_parts(const std::string& model) {
    return {{"[Content_Types].xml",
             R"(<?xml version="1.0"?><Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">)"
             R"(<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>)"
             R"(<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>)"},
            {"_rels/.rels",
             R"(<?xml version="1.0"?><Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">)"
             R"(<Relationship Target="/thumbnail.png" Id="rel0" Type="http://example.org/thumbnail"/>)"
             R"(<Relationship Target="/3D/3dmodel.model" Id="rel1")"
             R"( Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>)"},
            {"3D/3dmodel.model", model}};
}

std::string model_text(const std::string& resources, const std::string& items, const std::string& attributes) {
    return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model "
           "xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" "
           "xmlns:p=\"http://schemas.microsoft.com/3dmanufacturing/production/2015/06\" " +
           attributes + ">\n<resources>\n" + resources + "</resources>\n<build>\n" + items + "</build>\n</model>\n";
}

std::string mesh_xml(const PolygonMesh& mesh) {
    std::string text = "<mesh><vertices>\n";
    for (const auto& [x, y, z] : points_of(mesh)) {
        text +=
            "<vertex x=\"" + std::to_string(x) + "\" y=\"" + std::to_string(y) + "\" z=\"" + std::to_string(z) + "\"/>\n";
    }
    text += "</vertices><triangles>\n";
    for (const auto& t : mesh.faces) {
        text += "<triangle v1=\"" + std::to_string(t[0]) + "\" v2=\"" + std::to_string(t[1]) + "\" v3=\"" +
                std::to_string(t[2]) + "\"/>\n";
    }
    return text + "</triangles></mesh>";
}

std::string object(int id, const std::string& contents, const std::string& attributes) {
    return "<object id=\"" + std::to_string(id) + "\" " + attributes + ">" + contents + "</object>\n";
}

std::string item(int id, const std::string& attributes) {
    return "<item objectid=\"" + std::to_string(id) + "\" " + attributes + "/>\n";
}

std::string components(const std::vector<std::string>& list) {
    std::string text = "<components>";
    for (const std::string& component : list) {
        text += "<component " + component + "/>";
    }
    return text + "</components>";
}

}  // namespace lamella::input_test
