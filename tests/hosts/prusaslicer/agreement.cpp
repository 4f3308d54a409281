// Whether the host's layers and the adapter's are the same. Under the adapter's licence: AGPL-3.0-or-later (see
// adapter.cpp).
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <libslic3r/ClipperUtils.hpp>
#include <numeric>
#include <stdexcept>

#include "both.hpp"

namespace compare {
namespace {

using namespace Slic3r;
using Mode = MeshSlicingParams::SlicingMode;

constexpr double square_mm = SCALING_FACTOR * SCALING_FACTOR;

// The layer in which the two differ most.
struct Worst {
    double apart_mm = 0;  ///< area that only one of them has, by the length of the host's contours
    double difference_mm2 = 0;
    double area_mm2 = 0;
    float height = 0;
};

template <class Region>
double area_of(const Region& region) {
    return std::accumulate(region.begin(), region.end(), 0.0,
                           [](double sum, const auto& each) { return sum + each.area(); });
}

double length_of(const ExPolygons& region) {
    double sum = 0;
    for (const ExPolygon& each : region) {
        sum += each.contour.length();
        for (const Polygon& hole : each.holes) {
            sum += hole.length();
        }
    }
    return sum * SCALING_FACTOR;
}

Worst difference(const ExPolygons& host, const ExPolygons& ours, float height, bool by_area) {
    Worst made;
    made.difference_mm2 = by_area ? std::abs(area_of(host) - area_of(ours)) * square_mm
                                  : (area_of(diff_ex(host, ours)) + area_of(diff_ex(ours, host))) * square_mm;
    made.area_mm2 = area_of(host) * square_mm;
    // At least a millimetre: a speck in an otherwise empty layer counts as its area.
    made.apart_mm = made.difference_mm2 / std::max(length_of(host), 1.0);
    made.height = height;
    return made;
}

Worst worst_layer(const Layers& host, const Layers& ours, const std::vector<float>& zs, bool by_area) {
    if (host.size() != ours.size()) {
        throw std::runtime_error("numbers of layers differ");
    }
    std::vector<Worst> all(host.size());
    tbb::parallel_for(std::size_t{0}, host.size(),
                      [&](std::size_t layer) { all[layer] = difference(host[layer], ours[layer], zs[layer], by_area); });
    Worst made;
    for (const Worst& each : all) {
        made = each.apart_mm > made.apart_mm ? each : made;
    }
    return made;
}

Transform3d tilted() {
    Transform3d made = Transform3d::Identity();
    made.rotate(Eigen::AngleAxisd(0.3, Vec3d(1, 2, 3).normalized()));
    made.pretranslate(Vec3d(10, -20, 5));
    return made;
}

Transform3d mirrored() {
    Transform3d made = Transform3d::Identity();
    made.scale(Vec3d(-1, 1, 1));
    return made;
}

// The host rounds coordinates to float in units of 1e-6 mm.
double rounding_mm(const Model& model) {
    float farthest = 0;
    for (const stl_vertex& vertex : model.mesh.vertices) {
        farthest = std::max(farthest, vertex.cwiseAbs().maxCoeff());
    }
    return static_cast<double>(farthest) * 0x1p-23;
}

MeshSlicingParamsEx params_of(Mode mode, float closing = 0, float offset = 0, double resolution = 0) {
    MeshSlicingParamsEx params;
    params.mode = mode;
    params.closing_radius = closing;
    params.extra_offset = offset;
    params.resolution = resolution;
    return params;
}

Way regions(const char* name, const MeshSlicingParamsEx& params, double bound_mm, bool by_area = false) {
    return {name,
            [params](const Model& model, const auto& zs) { return slice_mesh_ex_host(model.mesh, zs, params, never); },
            [params](const Model& model, const auto& zs) { return slice_mesh_ex(model.mesh, zs, params, never); },
            bound_mm,
            by_area,
            params.trafo};
}

// The region of what upward or downward faces project.
Way slabs(bool upward, const Transform3d& trafo) {
    const auto by = [upward, trafo](const auto& project) {
        return [upward, trafo, project](const Model& model, const std::vector<float>& zs) {
            std::vector<Polygons> projected;
            project(model.mesh, zs, trafo, upward ? &projected : nullptr, upward ? nullptr : &projected, never);
            Layers made(projected.size());
            tbb::parallel_for(std::size_t{0}, made.size(), [&](std::size_t at) { made[at] = union_ex(projected[at]); });
            return made;
        };
    };
    return {upward ? "top slabs" : "bottom slabs", by(slice_mesh_slabs_host), by(slice_mesh_slabs), points_mm, false, trafo};
}

std::vector<Way> ways() {
    constexpr double resolution_mm = 0.01;
    MeshSlicingParamsEx turned = params_of(Mode::Regular);
    turned.trafo = tilted();
    MeshSlicingParamsEx mixed = params_of(Mode::PositiveLargestContour);
    mixed.slicing_mode_normal_below_layer = 5;
    return {regions("regular", params_of(Mode::Regular), points_mm),
            regions("closing 0.049", params_of(Mode::Regular, 0.049F), corners_mm),
            regions("even-odd", params_of(Mode::EvenOdd), points_mm),
            regions("positive", params_of(Mode::Positive), points_mm),
            regions("largest contour", params_of(Mode::PositiveLargestContour), points_mm, true),
            regions("offset 0.1", params_of(Mode::Regular, 0, 0.1F), corners_mm),
            regions("offset 0.02, closing 0.049", params_of(Mode::Regular, 0.049F, 0.02F), corners_mm),
            regions("offset -0.1, closing 0.049", params_of(Mode::Regular, 0.049F, -0.1F), corners_mm),
            regions("resolution 0.01", params_of(Mode::Regular, 0, 0, resolution_mm), resolution_mm),
            regions("tilted", turned, points_mm),
            regions("largest contour, regular below layer 5", mixed, points_mm, true)};
}

// Every third facet, as if painted: the host projects such patches.
std::vector<Model> painted(const std::vector<Model>& models) {
    std::vector<Model> patches = models;
    for (Model& patch : patches) {
        std::size_t kept = 0;
        for (std::size_t facet = 0; facet < patch.mesh.indices.size(); facet += 3) {
            patch.mesh.indices[kept++] = patch.mesh.indices[facet];
        }
        patch.mesh.indices.resize(kept);
        its_compactify_vertices(patch.mesh);
    }
    return patches;
}

// The loops of slice_mesh(), by the area that each layer's enclose as they turn.
bool loops_agree(const Model& model) {
    const std::vector<float> zs = heights(model, 0.2, 0.1);
    const auto host = slice_mesh_host(model.mesh, zs, MeshSlicingParams{}, never);
    const auto ours = slice_mesh(model.mesh, zs, MeshSlicingParams{}, never);
    for (std::size_t layer = 0; layer < zs.size(); ++layer) {
        const Polygons single = slice_mesh(model.mesh, zs[layer], MeshSlicingParams{});
        const double sums[] = {area_of(host[layer]) * square_mm, area_of(ours[layer]) * square_mm,
                               area_of(single) * square_mm};
        double length = 1;
        for (const Polygon& loop : host[layer]) {
            length += loop.length() * SCALING_FACTOR;
        }
        if (std::abs(sums[0] - sums[1]) > (points_mm + rounding_mm(model)) * length ||
            std::abs(sums[1] - sums[2]) > 1e-9 * length) {
            std::printf("\n%s, loops at %g: %.9g mm2 of the host, %.9g of the adapter, %.9g at one plane\n",
                        model.name.c_str(), static_cast<double>(zs[layer]), sums[0], sums[1], sums[2]);
            return false;
        }
    }
    return true;
}

}  // namespace

void print_agreement_head() {
    std::printf(
        "| meshes | way | layers | worst in | differ by, mm2 | of mm2 | apart, mm | bound, mm |\n"
        "|---|---|---|---|---|---|---|---|\n");
}

bool agree(const std::vector<Model>& models, double first_mm, const Way& way, const char* label, std::string& beyond) {
    Worst worst;
    std::string worst_mesh;
    std::size_t layers = 0;
    bool all = true;
    for (const Model& model : models) {
        const std::vector<float> zs = heights(model, 0.2, first_mm, way.trafo);
        const Worst found = worst_layer(way.host(model, zs), way.ours(model, zs), zs, way.by_area);
        layers += zs.size();
        if (found.apart_mm > way.bound_mm + (way.same_layers ? 0 : rounding_mm(model))) {
            all = false;
            beyond += "Beyond the bound: " + model.name + ", " + way.name + ", at " + std::to_string(found.height) + ": " +
                      std::to_string(found.difference_mm2) + " of " + std::to_string(found.area_mm2) + " mm2\n";
        }
        if (found.apart_mm >= worst.apart_mm) {
            worst = found;
            worst_mesh = model.name;
        }
    }
    std::printf("| %s | %s | %zu | %s | %.2g | %.4g | %.2g | %.0g |\n", label, way.name, layers, worst_mesh.c_str(),
                worst.difference_mm2, worst.area_mm2, worst.apart_mm, way.bound_mm);
    return all;
}

bool layers_agree(const std::vector<Model>& parts, const std::vector<Model>& organs) {
    print_agreement_head();
    bool all = true;
    std::string beyond;
    const std::vector<Way> each_way = ways();
    const auto both_slabs = [&](const std::vector<Model>& models, double first_mm, const Transform3d& trafo,
                                const char* label) {
        all = agree(models, first_mm, slabs(true, trafo), label, beyond) && all;
        all = agree(models, first_mm, slabs(false, trafo), label, beyond) && all;
    };
    for (const Way& way : each_way) {
        all = agree(parts, 0.1, way, "the host's", beyond) && all;
    }
    all = agree(parts, 0.2, each_way.front(), "the host's, planes on faces", beyond) && all;
    const Transform3d as_is = Transform3d::Identity();
    both_slabs(parts, 0.1, as_is, "the host's");
    both_slabs(parts, 0.2, as_is, "the host's, planes on faces");
    both_slabs(parts, 0.1, tilted(), "the host's, tilted");
    both_slabs(parts, 0.1, mirrored(), "the host's, mirrored");
    both_slabs(painted(parts), 0.1, as_is, "every third facet of the host's");
    for (const Model& organ : organs) {
        for (const Way& way : {each_way[0], each_way[1]}) {
            all = agree({organ}, 0.1, way, organ.name.c_str(), beyond) && all;
        }
        both_slabs({organ}, 0.1, as_is, organ.name.c_str());
    }
    std::printf("\n%s", beyond.c_str());
    for (const std::vector<Model>* models : {&parts, &organs}) {
        for (const Model& model : *models) {
            all = loops_agree(model) && all;
        }
    }
    return all;
}

}  // namespace compare
