// VTK XML polylines in the mesh's frame, a cell a contour, with layer, role, part and z of each. Numbers follow the text as
// they lie in memory, each array after its size; the text says where each begins, so that the arrays have to be complete
// before it.
#include <array>
#include <string>

#include "base/little_endian.hpp"
#include "io/layers/layer_writer.hpp"
#include "io/layers/spill.hpp"

namespace lamella {

namespace {

struct VtpArray {
    const char* type;
    const char* name;
    const char* more;  ///< attributes
};
enum VtpColumn : std::size_t { layer_column, role_column, part_column, z_column, points_column, ids_column, ends_column };
constexpr std::array<VtpArray, 7> arrays = {{{"Int64", "layer", ""},
                                             {"Int32", "role", ""},
                                             {"Int64", "part", ""},
                                             {"Float64", "z", ""},
                                             {"Float64", "Points", " NumberOfComponents=\"3\""},
                                             {"Int64", "connectivity", ""},
                                             {"Int64", "offsets", ""}}};

using Xyz = std::array<double, 3>;

/// From the slicing frame to the mesh's: the inverse by cofactors.
class ToMesh {
public:
    explicit ToMesh(const Transform& frame) noexcept {
        const std::array<double, 12>& m = frame.m;
        const auto cross = [&m](std::size_t a, std::size_t b) {
            return Xyz{m[a + 1] * m[b + 2] - m[a + 2] * m[b + 1], m[a + 2] * m[b] - m[a] * m[b + 2],
                       m[a] * m[b + 1] - m[a + 1] * m[b]};
        };
        axes_ = {cross(4, 8), cross(8, 0), cross(0, 4)};
        determinant_ = m[0] * axes_[0][0] + m[1] * axes_[0][1] + m[2] * axes_[0][2];
        move_ = {m[3], m[7], m[11]};
    }

    Xyz operator()(PointMm at, double z) const noexcept {
        const Xyz from = {at.x - move_[0], at.y - move_[1], z - move_[2]};
        Xyz mesh{};
        for (std::size_t i = 0; i < 3; ++i) {
            mesh[i] = (axes_[0][i] * from[0] + axes_[1][i] * from[1] + axes_[2][i] * from[2]) / determinant_;
        }
        return mesh;
    }

private:
    std::array<Xyz, 3> axes_;
    double determinant_;
    Xyz move_;
};

class VtpWriter final : public LayerWriter {
public:
    VtpWriter(const LayerFilePlan& plan, OutputFile& out)
        : first_(plan.info.first_layer),
          to_mesh_(plan.info.options.frame.transform),
          columns_(plan.path, arrays.size(), plan.context.stop),
          out_(out) {}

    void add(const LayerView& layer) override {
        for (const Contour& contour : layer.contours) {
            const auto begin = static_cast<std::int64_t>(points_);
            for (const Point point : layer.points_of(contour)) {
                put(ids_column, static_cast<std::int64_t>(points_++));
                put(points_column, to_mesh_(layer.to_mm(point), layer.plane_mm));
            }
            if (contour.role != Role::open) {
                put(ids_column, begin);
            }
            ++lines_;
            put(ends_column, static_cast<std::int64_t>(columns_.bytes(ids_column) / sizeof(std::int64_t)));
            put(layer_column, static_cast<std::int64_t>(first_ + layer.index));
            put(role_column, static_cast<std::int32_t>(contour.role));
            put(part_column, std::int64_t{contour.part});
            put(z_column, layer.plane_mm);
        }
    }

    void finish() override {
        std::uint64_t offset = 0;
        const auto listed = [&](std::size_t from, std::size_t to) {
            std::string text;
            for (std::size_t column = from; column < to; ++column) {
                const auto& [type, name, more] = arrays[column];
                text += std::string("<DataArray type=\"") + type + "\" Name=\"" + name + "\"" + more +
                        " format=\"appended\" offset=\"" + std::to_string(offset) + "\"/>\n";
                offset += sizeof(std::uint64_t) + columns_.bytes(column);
            }
            return text;
        };
        std::string text =
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" "
            "header_type=\"UInt64\">\n<PolyData>\n<Piece NumberOfPoints=\"" +
            std::to_string(points_) + "\" NumberOfVerts=\"0\" NumberOfLines=\"" + std::to_string(lines_) +
            "\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n<CellData>\n";
        text += listed(layer_column, points_column) + "</CellData>\n<Points>\n";
        text += listed(points_column, ids_column) + "</Points>\n<Lines>\n";
        text += listed(ids_column, arrays.size());
        out_.append(text + "</Lines>\n</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_");
        for (std::size_t column = 0; column < arrays.size(); ++column) {
            const std::uint64_t bytes = columns_.bytes(column);
            out_.append({reinterpret_cast<const char*>(&bytes), sizeof bytes});
            columns_.read(column, [&](std::string_view piece) { out_.append(piece); });
        }
        out_.append("\n</AppendedData>\n</VTKFile>\n");
    }

    double rounding_mm() const noexcept override { return 0; }

private:
    template <class Number>
    void put(VtpColumn column, const Number& number) {
        columns_.append(column, {reinterpret_cast<const char*>(&number), sizeof number});
    }

    std::uint64_t first_;
    ToMesh to_mesh_;
    Spill columns_;
    OutputFile& out_;
    std::uint64_t points_ = 0;
    std::uint64_t lines_ = 0;
};

}  // namespace

std::unique_ptr<LayerWriter> make_vtp(const LayerFilePlan& plan, OutputFile& out) {
    return std::make_unique<VtpWriter>(plan, out);
}

}  // namespace lamella
