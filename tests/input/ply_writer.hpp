// PLY in all its variants, for the tests of the reader.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "engine/shapes.hpp"
#include "files.hpp"

namespace lamella::ply_test {

inline constexpr std::array<std::string_view, 3> ply_encodings = {"ascii", "binary_little_endian", "binary_big_endian"};

/// A file, number by number: in binary as bytes, in ASCII as words.
class PlyWriter {
public:
    explicit PlyWriter(std::string_view encoding) : encoding_(encoding) {
        header("ply").header("format " + std::string(encoding) + " 1.0");
    }

    PlyWriter& header(const std::string& line) {
        header_ += line + "\n";
        return *this;
    }

    PlyWriter& number(std::string_view type, double value) {
        body_ += input_test::as_type(type, value, [this](auto number) { return encoded(number); });
        return *this;
    }

    PlyWriter& list(std::string_view count_type, std::string_view type, const std::vector<double>& values) {
        number(count_type, static_cast<double>(values.size()));
        for (const double value : values) {
            number(type, value);
        }
        return *this;
    }

    /// In ASCII each row of an element ends with its line.
    PlyWriter& end_row() {
        if (encoding_ == "ascii") {
            body_.back() = '\n';
        }
        return *this;
    }

    std::string file() const { return header_ + "end_header\n" + body_; }

private:
    template <class T>
    std::string encoded(T value) const {
        if (encoding_ != "ascii") {
            return input_test::bytes_of(value, encoding_ == "binary_big_endian");
        }
        const auto number = static_cast<double>(value);
        const bool whole = std::trunc(number) == number;
        return (whole ? std::to_string(static_cast<long long>(number)) : std::to_string(number)) + ' ';
    }

    std::string encoding_;
    std::string header_;
    std::string body_;
};

using Faces = std::vector<std::vector<double>>;

/// How a mesh is written as PLY.
struct PlyVariant {
    std::string_view encoding = "ascii";
    std::string_view coordinate = "float";
    std::string_view count = "uchar";
    std::string_view index = "int";
    std::string index_name = "vertex_indices";
    std::array<std::size_t, 3> axes = {0, 1, 2};  ///< the order in which x, y and z come
    bool faces_first = false;
    bool extra_numbers = false;   ///< between and around the properties that are used
    bool extra_lists = false;     ///< so too, also among the vertices
    bool extra_elements = false;  ///< before, between and after

    void vertices(PlyWriter& out, const std::vector<double>& xyz) const {
        out.header("element vertex " + std::to_string(xyz.size() / 3));
        for (const std::size_t axis : axes) {
            declare_extra(out, "before" + std::to_string(axis));
            out.header("property " + std::string(coordinate) + " " + "xyz"[axis]);
        }
        declare_extra(out, "after");
        for (std::size_t v = 0; v < xyz.size() / 3; ++v) {
            for (const std::size_t axis : axes) {
                extra(out, v + axis);
                out.number(coordinate, xyz[3 * v + axis]);
            }
            extra(out, v);
            out.end_row();
        }
    }

    void faces(PlyWriter& out, const Faces& faces) const {
        out.header("element face " + std::to_string(faces.size()));
        declare_extra(out, "before");
        out.header("property list " + std::string(count) + " " + std::string(index) + " " + index_name);
        declare_extra(out, "after");
        for (std::size_t f = 0; f < faces.size(); ++f) {
            extra(out, f);
            out.list(count, index, faces[f]);
            extra(out, f + 1);
            out.end_row();
        }
    }

    void other(PlyWriter& out, const std::string& name) const {
        if (extra_elements) {
            out.header("element " + name + " 4").header("property int id").header("property list int uchar names");
            for (std::size_t row = 0; row < 4; ++row) {
                out.number("int", -7).list("int", "uchar", std::vector<double>(row, 65)).end_row();
            }
        }
    }

private:
    void declare_extra(PlyWriter& out, const std::string& name) const {
        if (extra_numbers) {
            out.header("property double " + name).header("property uchar " + name + "_too");
        }
        if (extra_lists) {
            out.header("property list ushort float " + name + "_list");
        }
    }

    /// Further values of row `row`; the lengths of lists vary.
    void extra(PlyWriter& out, std::size_t row) const {
        if (extra_numbers) {
            out.number("double", -0.5).number("uchar", 200);
        }
        if (extra_lists) {
            out.list("ushort", "float", std::vector<double>(row % 3, 7.25));
        }
    }
};

inline std::string ply(const PlyVariant& how, const std::vector<double>& xyz, const Faces& faces) {
    PlyWriter out(how.encoding);
    how.other(out, "camera");
    how.faces_first ? how.faces(out, faces) : how.vertices(out, xyz);
    how.other(out, "edge");
    how.faces_first ? how.vertices(out, xyz) : how.faces(out, faces);
    how.other(out, "material");
    return out.file();
}

inline Faces faces_of(const shapes::Indexed& mesh) {
    Faces faces;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
        faces.emplace_back(mesh.indices.begin() + static_cast<std::ptrdiff_t>(i),
                           mesh.indices.begin() + static_cast<std::ptrdiff_t>(i + 3));
    }
    return faces;
}

inline std::string ply(const PlyVariant& how, const shapes::Indexed& mesh) {
    return ply(how, mesh.xyz, faces_of(mesh));
}

}  // namespace lamella::ply_test
