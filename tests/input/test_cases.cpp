// The cases of cases/*.txt: a good file, what is changed in it, and what reading then gives.
//
//     @ NAME                                   a good file, whose lines follow, up to a line @@; with no line it is binary()
//     TEXT | OTHER | ... TEXT | OTHER | ANSWER the good file with OTHER in place of the first TEXT, one pair after another
//     # ...                                    a comment
//
// *TEXT means every one, ^ and $ the places before and after the file, @ the whole file; "upper" and "lower" change its
// letters. Escapes are those of C, \s is a space, and \{N TEXT} is N times TEXT. The lines of a 3MF file are its root
// part, or several parts, each after a line "=== NAME" or "=== FLAGS: NAME"; {cube} is the mesh of cube(). Good files cube.*
// hold one cube, triangle.* one triangle. ANSWER is one of the first four, or some of the others, which " && " divides:
//
//     refused TEXT ... TEXT    malformed, with a message that holds the texts in this order
//     empty TEXT               without triangles, and so too
//     same                     the triangles of the good file, as where there is none of the three below
//     reads N ...              triangles of these coordinates
//     box X Y Z X Y Z V        triangles that fill this box and this volume
//     parts TEXT               list_list_parts_of() the mesh
//     vertices N               so many of them
//     warns TEXT               a warning, which holds TEXT; these are all, in this order
//     LPS, RAS                 this patient frame; without them none
#include <cctype>
#include <sstream>

#include "read.hpp"

namespace lamella::input_test {

namespace {

struct GoodFile {
    std::string name;
    std::string text;
    Triangles triangles;
};

/// What lies before the first `separator` of the text, which loses it.
std::string cut_off(std::string& text, const std::string& separator) {
    const std::size_t at = text.find(separator);
    std::string first = text.substr(0, at);
    text.erase(0, at == std::string::npos ? at : at + separator.size());
    return first;
}

std::string unescaped(std::string_view text) {
    std::string plain;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] != '\\') {
            plain += text[i];
            continue;
        }
        constexpr std::string_view codes = "nrts0";
        constexpr std::string_view meant("\n\r\t \0", 5);
        const char code = text.at(++i);
        if (code == 'x') {
            plain += static_cast<char>(std::stoi(std::string(text.substr(i + 1, 2)), nullptr, 16));
            i += 2;
        } else if (code == '{') {
            const std::size_t end = text.find('}', i);
            const std::size_t space = text.find(' ', i);
            plain += repeated(unescaped(text.substr(space + 1, end - space - 1)),
                              std::stoul(std::string(text.substr(i + 1, space - i))));
            i = end;
        } else {
            plain += codes.find(code) == std::string_view::npos ? code : meant[codes.find(code)];
        }
    }
    return plain;
}

std::string in_utf16(const std::string& text) {
    std::string wide = "\xFF\xFE";
    for (const char c : text) {
        wide += {c, '\0'};
    }
    return wide;
}

std::string changed(std::string text, const std::string& what, const std::string& by) {
    if (what == "^" || what == "$") {
        return what == "^" ? by + text : text + by;
    }
    if (what == "@") {
        return by;
    }
    if (what == "upper" || what == "lower") {
        std::transform(text.begin(), text.end(), text.begin(), what == "upper" ? ::toupper : ::tolower);
        return text;
    }
    const std::string part = unescaped(what.substr(what[0] == '*' ? 1 : 0));
    CAPTURE(part);
    REQUIRE(text.find(part) != std::string::npos);
    return what[0] == '*' ? replaced(text, part, by) : text.replace(text.find(part), part.size(), by);
}

std::string package_of(std::string text) {
    text = replaced(text, "{cube}", mesh_xml(triangulated(cube())));
    if (!text.starts_with("=== ")) {
        return package(text);
    }
    std::vector<ZipPart> parts;
    text.erase(0, 4);
    while (!text.empty()) {
        std::string contents = cut_off(text, "\n=== ");
        std::string name = cut_off(contents, "\n");
        const std::string flags = name.find(": ") == std::string::npos ? "" : cut_off(name, ": ");
        const auto has = [&](const char* flag) { return flags.find(flag) != std::string::npos; };
        ZipPart& part = parts.emplace_back(ZipPart{name, has("utf16") ? in_utf16(contents) : contents});
        part.deflated = !has("stored");
        part.flags = has("encrypted") ? 1 : 0;
        part.method = has("method ") ? std::stoi(flags.substr(flags.find("method ") + 7)) : -1;
        part.false_crc = has("false crc") ? 1 : 0;
        part.excess_bytes = has("false size") ? 10 : 0;
    }
    return zip(parts);
}

std::filesystem::path written(const std::string& name, const std::string& text) {
    return dir.write(name, name.ends_with(".3mf") ? package_of(text) : text);
}

/// A tetrahedron's corners and one face as PLY, a cube as legacy VTK and as VTP.
std::string binary(const std::string& name) {
    const std::string stem = name.substr(0, name.find('.'));
    if (name.ends_with(".ply")) {
        return Ply{.encoding = "binary_" + stem}({{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, {{0, 1, 2}}});
    }
    return name.ends_with(".vtk") ? Vtk{false, std::stoi(stem)}(cube())
                                  : Vtp{stem == "zlib" ? "binary" : stem, stem == "zlib"}({cube()});
}

/// The cube from the origin to (8, 8, 8.5), each side a fan of its first corner.
Triangles cube_of_cases() {
    PolygonMesh mesh{{}, {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}};
    for (int v = 0; v < 8; ++v) {
        mesh.xyz.insert(mesh.xyz.end(), {v % 4 % 3 > 0 ? 8.0 : 0.0, v % 4 > 1 ? 8.0 : 0.0, v > 3 ? 8.5 : 0.0});
    }
    return mesh.triangles();
}

/// The good file whose name follows, up to a line "@@".
GoodFile read_good(std::istream& in, const std::string& name) {
    GoodFile good{name, {}, {}};
    std::string line;
    while (std::getline(in, line) && line != "@@") {
        good.text += line + "\n";
    }
    const bool is_text = !good.text.empty();
    good.text = is_text ? good.text : binary(name);
    const Contents contents = read(written(name, good.text));
    CHECK(contents.warnings.empty());
    CHECK(contents.mesh.text == (is_text && contents.mesh.format != MeshFormat::gltf));
    CHECK(contents.mesh.patient_frame == PatientFrame::unstated);
    good.triangles = contents.triangles;
    CHECK((!name.starts_with("cube.") || good.triangles == cube_of_cases()));
    CHECK((!name.starts_with("triangle.") || good.triangles == Triangles{{0, 0, 0, 1, 0, 0, 0, 1, 0}}));
    return good;
}

/// "NAME ROLE FIRST COUNT; ..."
std::string list_parts_of(const MeshFile& file) {
    std::string text;
    for (const MeshPart& part : file.parts) {
        text += (text.empty() ? "" : "; ") + part.name + " " + std::string(name_of(part.role)) + " " +
                std::to_string(part.first_triangle) + " " + std::to_string(part.triangle_count);
    }
    return text;
}

std::vector<double> numbers_in(const std::string& text) {
    std::istringstream in(text);
    return {std::istream_iterator<double>(in), {}};
}

void check_read(const std::filesystem::path& path, const GoodFile& good, std::string answer) {
    const Contents contents = read(path);
    const MeshFile& mesh = contents.mesh;
    PatientFrame frame = PatientFrame::unstated;
    bool same = true;
    Texts warnings;
    while (!answer.empty()) {
        std::string text = cut_off(answer, " && ");
        const std::string word = cut_off(text, " ");
        const std::vector<double> numbers = numbers_in(text);
        same = same && word != "reads" && word != "box" && word != "parts";
        if (word == "reads") {
            CHECK(contents.triangles == triangles_of(numbers));
        } else if (word == "box") {
            const MeshCheck found = value_of(check(mesh.view(), {.counts_only = true}));
            for (std::size_t i = 0; i < 6; ++i) {
                CHECK((i < 3 ? found.box.min_mm[i] : found.box.max_mm[i - 3]) == Approx(numbers.at(i)).margin(1e-5));
            }
            CHECK(found.volume_mm3 == Approx(numbers.at(6)).margin(1e-5));
        } else if (word == "parts") {
            CHECK(list_parts_of(mesh) == unescaped(text));
        } else if (word == "vertices") {
            CHECK(mesh.vertex_count == static_cast<std::uint64_t>(numbers.at(0)));
        } else if (word == "warns") {
            warnings.push_back(unescaped(text));
        } else if (word != "same") {
            REQUIRE((word == "LPS" || word == "RAS"));
            frame = word == "LPS" ? PatientFrame::lps : PatientFrame::ras;
        }
    }
    CHECK((!same || contents.triangles == good.triangles));
    CHECK(mesh.states_unit == (mesh.format == MeshFormat::three_mf || mesh.format == MeshFormat::gltf));
    CHECK(mesh.patient_frame == frame);
    CAPTURE(contents.warnings);
    REQUIRE(contents.warnings.size() == warnings.size());
    for (std::size_t i = 0; i < warnings.size(); ++i) {
        CHECK_THAT(contents.warnings[i], Catch::Contains(warnings[i]));
    }
}

void check_row(const GoodFile& good, std::string row) {
    INFO(row);
    std::string text = good.text;
    while (row.find(" | ") != std::string::npos) {
        const std::string what = cut_off(row, " | ");
        text = changed(text, what, row.starts_with("| ") ? "" : unescaped(cut_off(row, " | ")));
        row.erase(0, row.starts_with("| ") ? 2 : 0);
    }
    const std::filesystem::path path = written(good.name, text);
    if (row.starts_with("refused") || row.starts_with("empty")) {
        const std::string word = cut_off(row, " ");
        refuses(path, unescaped(row), word == "empty" ? ErrorCode::empty_mesh : ErrorCode::malformed_mesh);
    } else {
        check_read(path, good, row);
    }
}

void check_cases(const std::string& name) {
    INFO(name);
    std::istringstream in(::bytes_of(std::string(LAMELLA_TESTS_DIR) + "/input/cases/" + name));
    GoodFile good;
    std::size_t rows = 0;
    for (std::string line; std::getline(in, line);) {
        if (line.starts_with("@ ") && line.find(" | ") == std::string::npos) {
            good = read_good(in, line.substr(2));
        } else if (!line.empty() && line[0] != '#') {
            check_row(good, line);
            ++rows;
        }
    }
    CHECK(rows > 20);
}

}  // namespace

TEST_CASE("files of every format are read, read with a warning or refused",
          "[input][stl][obj][off][ply][vtk][vtp][3mf][gltf][gifti]") {
    check_cases(GENERATE("stl.txt", "obj.txt", "off.txt", "ply.txt", "vtk.txt", "vtp.txt", "3mf.txt", "packages.txt",
                         "gltf.txt", "gifti.txt"));
}

}  // namespace lamella::input_test
