// The cases of cases/*.txt: a good file, a text in it, what takes its place, and what reading then gives.
//
//     @ NAME                   a good file, whose lines follow, up to a line @@; cube.* hold one cube, triangle.* one
//     triangle TEXT | OTHER | ANSWER    the good file with OTHER in place of the first TEXT # ...                    a
//     comment
//
// *TEXT means every one, ^ and $ the places before and after the file, @ the whole file; "upper" and "lower" change its
// letters. Escapes are those of C, \s is a space, and \{N TEXT} is N times TEXT. ANSWER is one of
//
//     same                     the triangles of the good file, without a warning
//     warns TEXT               the same with one warning, which holds TEXT
//     LPS, RAS                 the same, in this patient frame; the other answers are of none
//     refused TEXT ... TEXT    malformed, with a message that holds the texts in this order
//     empty TEXT               without triangles, and so too
#include <cctype>
#include <sstream>

#include "read.hpp"
#include "zip.hpp"

namespace lamella::input_test {

namespace {

struct GoodFile {
    std::string name;
    std::string text;
    Triangles triangles;
};

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
            const std::string part = unescaped(text.substr(space + 1, end - space - 1));
            for (int times = std::stoi(std::string(text.substr(i + 1, space - i))); times > 0; --times) {
                plain += part;
            }
            i = end;
        } else {
            plain += codes.find(code) == std::string_view::npos ? code : meant[codes.find(code)];
        }
    }
    return plain;
}

std::string changed(const std::string& good, const std::string& what, const std::string& by) {
    if (what == "^") {
        return by + good;
    }
    if (what == "$") {
        return good + by;
    }
    if (what == "@") {
        return by;
    }
    std::string text = good;
    if (what == "upper" || what == "lower") {
        std::transform(text.begin(), text.end(), text.begin(), what == "upper" ? ::toupper : ::tolower);
        return text;
    }
    const std::string part = unescaped(what.substr(what[0] == '*' ? 1 : 0));
    REQUIRE(good.find(part) != std::string::npos);
    return what[0] == '*' ? replaced(text, part, by) : text.replace(text.find(part), part.size(), by);
}

/// The text is the root part of a 3MF package, and the whole of any other file.
std::filesystem::path written(const std::string& name, const std::string& text) {
    return dir.write(name, name.ends_with(".3mf") ? package(text) : text);
}

/// The cube from the origin to (8, 8, 8.5), each side a fan of its first corner.
Triangles cube() {
    const auto corner = [](int v) {
        return std::array{v % 4 % 3 > 0 ? 8.0 : 0.0, v % 4 > 1 ? 8.0 : 0.0, v > 3 ? 8.5 : 0.0};
    };
    Triangles triangles;
    for (const auto& [a, b, c, d] : std::to_array<std::array<int, 4>>(
             {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}})) {
        for (const auto& corners : {std::array{a, b, c}, std::array{a, c, d}}) {
            auto& triangle = triangles.emplace_back();
            for (std::size_t i = 0; i < 9; ++i) {
                triangle[i] = corner(corners[i / 3])[i % 3];
            }
        }
    }
    return triangles;
}

/// The good file whose name follows, up to a line "@@".
GoodFile read_good(std::istream& in, const std::string& name) {
    GoodFile good{name, {}, {}};
    std::string line;
    while (std::getline(in, line) && line != "@@") {
        good.text += line + "\n";
    }
    const Contents contents = read(written(name, good.text));
    CHECK(contents.warnings.empty());
    CHECK(contents.mesh.text);
    CHECK(contents.mesh.patient_frame == PatientFrame::unstated);
    good.triangles = contents.triangles;
    CHECK((!name.starts_with("cube.") || good.triangles == cube()));
    CHECK((!name.starts_with("triangle.") || good.triangles == Triangles{{0, 0, 0, 1, 0, 0, 0, 1, 0}}));
    return good;
}

void check_answer(const std::filesystem::path& path, const GoodFile& good, const std::string& answer) {
    const std::string word = answer.substr(0, answer.find(' '));
    const std::string text = unescaped(answer.substr(std::min(word.size() + 1, answer.size())));
    if (word == "refused" || word == "empty") {
        refuses(path, text, word == "empty" ? ErrorCode::empty_mesh : ErrorCode::malformed_mesh);
        return;
    }
    const Contents contents = read(path);
    CHECK((contents.triangles == good.triangles));
    CHECK(contents.mesh.states_unit == (contents.mesh.format == MeshFormat::three_mf));
    const bool framed = word == "LPS" || word == "RAS";
    CHECK(contents.mesh.patient_frame == (!framed         ? PatientFrame::unstated
                                          : word == "LPS" ? PatientFrame::lps
                                                          : PatientFrame::ras));
    CAPTURE(contents.warnings);
    REQUIRE(contents.warnings.size() == (word == "warns" ? 1U : 0U));
    if (word == "warns") {
        CHECK_THAT(contents.warnings[0], Catch::Contains(text));
    } else {
        REQUIRE((word == "same" || framed));
    }
}

void check_cases(const std::string& name) {
    std::istringstream in(::bytes_of(std::string(LAMELLA_TESTS_DIR) + "/input/cases/" + name));
    GoodFile good;
    std::size_t rows = 0;
    for (std::string line; std::getline(in, line);) {
        if (line.starts_with("@ ") && line.find(" | ") == std::string::npos) {
            good = read_good(in, line.substr(2));
        } else if (!line.empty() && line[0] != '#') {
            INFO(line);
            const std::size_t first = line.find(" | ");
            const std::size_t second = line.find(" | ", first + 2);
            REQUIRE(second != std::string::npos);
            const std::string by = second > first + 3 ? unescaped(line.substr(first + 3, second - first - 3)) : "";
            check_answer(written(good.name, changed(good.text, line.substr(0, first), by)), good, line.substr(second + 3));
            ++rows;
        }
    }
    CHECK(rows > 20);
}

}  // namespace

TEST_CASE("text STL is read, read with a warning or refused", "[input][stl]") {
    check_cases("stl.txt");
}

TEST_CASE("OBJ is read, read with a warning or refused", "[input][obj]") {
    check_cases("obj.txt");
}

TEST_CASE("OFF is read, read with a warning or refused", "[input][off]") {
    check_cases("off.txt");
}

TEST_CASE("text PLY is read, read with a warning or refused", "[input][ply]") {
    check_cases("ply.txt");
}

TEST_CASE("legacy VTK as text is read, read with a warning or refused", "[input][vtk]") {
    check_cases("vtk.txt");
}

TEST_CASE("VTP as text is read, read with a warning or refused", "[input][vtp]") {
    check_cases("vtp.txt");
}

TEST_CASE("3MF models are read, read with a warning or refused", "[input][3mf]") {
    check_cases("3mf.txt");
}

}  // namespace lamella::input_test
