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

/// Each type under its first name.
inline constexpr std::array<std::string_view, 8> ply_types = {"char", "uchar", "short", "ushort",
                                                              "int",  "uint",  "float", "double"};
inline constexpr std::array<std::string_view, 8> ply_sized_types = {"int8",  "uint8",  "int16",   "uint16",
                                                                    "int32", "uint32", "float32", "float64"};

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
};

using Faces = std::vector<std::vector<double>>;

namespace detail {

inline void declare_extra(PlyWriter& out, const PlyVariant& how, const std::string& name) {
    if (how.extra_numbers) {
        out.header("property double " + name).header("property uchar " + name + "_too");
    }
    if (how.extra_lists) {
        out.header("property list ushort float " + name + "_list");
    }
}

/// Of row `row`; the lengths of lists vary.
inline void write_extra(PlyWriter& out, const PlyVariant& how, std::size_t row) {
    if (how.extra_numbers) {
        out.number("double", -0.5).number("uchar", 200);
    }
    if (how.extra_lists) {
        out.list("ushort", "float", std::vector<double>(row % 3, 7.25));
    }
}

inline void add_vertices(PlyWriter& out, const PlyVariant& how, const std::vector<double>& xyz) {
    out.header("element vertex " + std::to_string(xyz.size() / 3));
    for (const std::size_t axis : how.axes) {
        declare_extra(out, how, "before" + std::to_string(axis));
        out.header("property " + std::string(how.coordinate) + " " + "xyz"[axis]);
    }
    declare_extra(out, how, "after");
    for (std::size_t v = 0; v < xyz.size() / 3; ++v) {
        for (const std::size_t axis : how.axes) {
            write_extra(out, how, v + axis);
            out.number(how.coordinate, xyz[3 * v + axis]);
        }
        write_extra(out, how, v);
        out.end_row();
    }
}

inline void add_faces(PlyWriter& out, const PlyVariant& how, const Faces& faces) {
    out.header("element face " + std::to_string(faces.size()));
    declare_extra(out, how, "before");
    out.header("property list " + std::string(how.count) + " " + std::string(how.index) + " " + how.index_name);
    declare_extra(out, how, "after");
    for (std::size_t f = 0; f < faces.size(); ++f) {
        write_extra(out, how, f);
        out.list(how.count, how.index, faces[f]);
        write_extra(out, how, f + 1);
        out.end_row();
    }
}

inline void add_other(PlyWriter& out, const PlyVariant& how, const std::string& name) {
    if (how.extra_elements) {
        out.header("element " + name + " 4").header("property int id").header("property list int uchar names");
        for (std::size_t row = 0; row < 4; ++row) {
            out.number("int", -7).list("int", "uchar", std::vector<double>(row, 65)).end_row();
        }
    }
}

}  // namespace detail

inline std::string ply(const PlyVariant& how, const std::vector<double>& xyz, const Faces& faces) {
    PlyWriter out(how.encoding);
    const auto vertices = [&] { detail::add_vertices(out, how, xyz); };
    const auto all_faces = [&] { detail::add_faces(out, how, faces); };
    detail::add_other(out, how, "camera");
    how.faces_first ? all_faces() : vertices();
    detail::add_other(out, how, "edge");
    how.faces_first ? vertices() : all_faces();
    detail::add_other(out, how, "material");
    return out.file();
}

inline Faces triangles_of(const shapes::Indexed& mesh) {
    Faces faces;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
        const auto* corner = mesh.indices.data() + i;
        faces.push_back({static_cast<double>(corner[0]), static_cast<double>(corner[1]), static_cast<double>(corner[2])});
    }
    return faces;
}

inline std::string ply(const PlyVariant& how, const shapes::Indexed& mesh) {
    return ply(how, mesh.xyz, triangles_of(mesh));
}

}  // namespace lamella::ply_test
