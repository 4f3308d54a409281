// The certificate of areas and volumes. What a plane cuts from a closed surface is as large as what the surface below the
// plane covers seen from above, where it faces down (Gauss). Of a face with corners at heights a <= b <= c, all lies below
// from b on but for what is beyond the plane at c, and what is below the plane at a before that:
//
//            c                below z:   (z-a)^2 / (b-a)(c-a)        from a to b
//           /|                       1 - (c-z)^2 / (c-b)(c-a)        from b to c
//      b   / |                       1                               from c on
//       \-/--|-- z
//        \   |            so a face is a whole from b on, a corner at a, and a corner at c taken away
//         `. |
//           `a
//
// Corners are rounded once, to a fraction of a unit that is the same for all; everything else is whole numbers. So the sums
// are the same in any order, and what cancels does so to the last bit. A running sum of the corners' coefficients would
// visit a face three times only, whatever planes it crosses, but its squares of heights need 256 bits to cancel; it was not
// tried.
#include "lamella/audit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "audit/face_sums.hpp"
#include "audit/questions.hpp"
#include "base/words.hpp"
#include "slicing/grid/quantise.hpp"
#include "slicing/regions/rules.hpp"

namespace lamella {

namespace {

constexpr std::size_t certified_grain = 4096;
constexpr double relative_tolerance = 1e-12;

/// No face covers more than the mesh's box.
CornerScale scale_of(const Bounds& bounds, const SliceResult& result) noexcept {
    double most = static_cast<double>(result.info.triangles);
    for (int axis = 0; axis < 2; ++axis) {
        most *= (bounds.max_mm[axis] - bounds.min_mm[axis]) / (2 * result.info.grid_mm) + 2;
    }
    const int bits = 123 - (std::ilogb(most) + 1);
    return {bits, std::max(0, bits - 32)};
}

/// The sums of all workers.
struct Sums {
    std::vector<PlaneSums> planes;  ///< and one more, for the slab above them
    Int128 six_volumes = 0;
    Int128 reach = 0;
    std::uint64_t edges = 0;
};

Sums sum_faces(const SlicedMesh& sliced, CornerScale scale, const Parallel& parallel) {
    const PlaneHeights heights(sliced.planes);
    std::vector<FaceSums> workers(static_cast<std::size_t>(parallel.threads()), FaceSums(sliced.planes, heights, scale));
    with_reader(sliced.mesh, sliced.placing, sliced.result.info.grid_mm, [&](const auto& read) {
        parallel.run_ranges(sliced.mesh.triangle_count, certified_grain,
                            [&](std::size_t begin, std::size_t end, int worker) {
                                FaceSums& sums = workers[static_cast<std::size_t>(worker)];
                                for (std::size_t t = begin; t < end; ++t) {
                                    sums.add(read(t));
                                }
                            });
    });
    Sums all;
    all.planes.resize(sliced.result.layers.size() + 1);
    for (const FaceSums& own : workers) {
        all.six_volumes += own.six_volumes();
        all.reach += own.reach();
        all.edges += own.edges();
    }
    parallel.run_ranges(all.planes.size(), certified_grain, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            for (const FaceSums& own : workers) {
                own.add_to(all.planes[i], i);
            }
        }
    });
    return all;
}

/// The area that a layer's contours enclose, in square units; and how far their edges run along the axes.
struct LayerSize {
    double area = 0;
    double length = 0;
    bool walked = true;  ///< no rule has made or dropped contours
};

/// `solid`: whatever the facets say.
LayerSize size_of(const SliceResult& result, const Layer& layer, bool solid) {
    Int128 twice_area = 0;
    Int128 length = 0;
    std::uint64_t segments = 0;
    for (const Contour& contour : result.contours_of(layer)) {
        segments += contour.segments;
        const PathSize own = size_of(result.points_of(contour));
        length += own.length;
        const int run = contour.role == Role::outer ? 1 : (contour.role == Role::hole ? -1 : 0);
        twice_area += own.twice_area * (solid ? std::abs(run) : run * contour.orientation);
    }
    return {static_cast<double>(twice_area) / 2, static_cast<double>(length), segments == layer.segments};
}

/// From sums over a closed mesh to areas and volumes.
class Certifier {
public:
    Certifier(const SliceResult& result, const Sums& sums, CornerScale scale, const Parallel& parallel)
        : result_(result), sums_(sums), scale_(scale), parallel_(parallel) {}

    VolumeCertificate run() {
        measure();
        certificate_.mesh_mm3 = static_cast<double>(sums_.six_volumes) / 6 * 8 * cube_mm3();
        certificate_.verdict = volumes_agree() ? VolumeVerdict::holds : VolumeVerdict::volumes_differ;
        if (!are_comparable()) {
            certificate_.verdict = VolumeVerdict::not_as_walked;
        } else if (!compare_layers()) {
            certificate_.verdict =
                certificate_.differing_layers > 0 ? VolumeVerdict::solid_differs : VolumeVerdict::areas_differ;
        }
        return std::move(certificate_);
    }

private:
    double cube_mm3() const noexcept { return result_.info.grid_mm * result_.info.grid_mm * result_.info.grid_mm; }

    /// Faces are in squares of two units, of which a face's normal spans two: half an area each; those below face down.
    double area(Int128 sum) const noexcept { return -2 * std::ldexp(static_cast<double>(sum), -scale_.area_bits); }
    double volume(Int128 sum) const noexcept { return -2 * std::ldexp(static_cast<double>(sum), -scale_.volume_bits); }

    /// No step has moved or dropped contours but FillRule::non_zero.
    bool are_comparable() const noexcept {
        const SliceOptions& options = result_.info.options;
        return options.content == LayerContent::section && keeps_solid(options.region) && result_.stitches.empty();
    }

    bool is_filled(std::size_t layer) const noexcept {
        return result_.info.options.region.rule_of(result_.info.first_layer + layer) != FillRule::contours;
    }

    void measure() {
        const std::size_t planes = result_.layers.size();
        areas_.resize(planes);
        cut_.resize(planes);
        certificate_.slab_mm3.resize(planes + 1);
        Int128 whole = 0;  // faces wholly below
        std::int64_t cut = 0;
        std::int64_t below = planes > 0 ? result_.layers[0].plane.z() : 0;
        for (std::size_t i = 0; i <= planes; ++i) {
            const PlaneSums& at = sums_.planes[i];
            const std::int64_t here = i < planes ? result_.layers[i].plane.z() : below;
            const Int128 slab = whole * (here - below) + at.step * here - at.lever;
            whole += at.step;
            cut += at.cut;
            below = here;
            const Int128 exact = (slab << scale_.volume_bits) + at.volume;
            slabs_ += exact;
            certificate_.slab_mm3[i] = volume(exact) * cube_mm3();
            if (i < planes) {
                areas_[i] = area((whole << scale_.area_bits) + at.area);
                cut_[i] = static_cast<double>(cut);
                crossings_ += cut_[i];
            }
        }
        certificate_.slabs_mm3 = volume(slabs_) * cube_mm3();
    }

    bool volumes_agree() const noexcept {
        const double corners = crossings_ + 2 * static_cast<double>(result_.info.triangles);
        const double lost =
            2 * (static_cast<double>(sums_.reach) * 0x1p-49 + 2 * std::ldexp(corners, -scale_.volume_bits)) * cube_mm3();
        return std::abs(certificate_.slabs_mm3 - certificate_.mesh_mm3) <=
               std::max(relative_tolerance * std::abs(certificate_.mesh_mm3), lost);
    }

    /// Also notes where they differ most.
    bool compare_layers() {
        std::vector<LayerSize> sizes(result_.layers.size());
        parallel_.run(sizes.size(),
                      [&](std::size_t l, int) { sizes[l] = size_of(result_, result_.layers[l], is_filled(l)); });
        const double square_mm2 = result_.info.grid_mm * result_.info.grid_mm;
        constexpr double moved = 0.5 + 0x1p-16;  // a point, along an axis; with what double loses of a corner's square
        constexpr double made = 3;               // snap rounding moves what it cuts by a unit more
        const double turn = certificate_.mesh_mm3 < 0 ? -1 : 1;
        double largest = 0;
        bool agree = true;
        for (std::size_t l = 0; l < sizes.size(); ++l) {
            const bool filled = is_filled(l);
            const double enclosed = filled ? turn * areas_[l] : areas_[l];
            const double difference = std::abs(enclosed - sizes[l].area);
            const double allowed = (sizes[l].walked ? 1 : made) * (moved * sizes[l].length + moved * moved * cut_[l]);
            agree = agree && difference <= allowed;
            if (filled && difference > allowed) {
                ++certificate_.differing_layers;
                certificate_.differing_signed_mm2 += enclosed * square_mm2;
                certificate_.differing_solid_mm2 += sizes[l].area * square_mm2;
            }
            const double share = difference / std::max(allowed, 1.0);
            if (l == 0 || share > largest) {
                largest = share;
                certificate_.worst_layer = l;
                certificate_.worst_difference_mm2 = difference * square_mm2;
                certificate_.worst_allowed_mm2 = allowed * square_mm2;
            }
        }
        return agree;
    }

    const SliceResult& result_;
    const Sums& sums_;
    CornerScale scale_;
    const Parallel& parallel_;
    std::vector<double> areas_;  // by layer, square units
    std::vector<double> cut_;    // triangles that the layer's plane cuts
    double crossings_ = 0;
    Int128 slabs_ = 0;
    VolumeCertificate certificate_;
};

}  // namespace

std::string_view name_of(VolumeVerdict verdict) noexcept {
    constexpr std::array<std::string_view, 6> names = {
        "holds",     "areas differ",           "volumes differ",
        "open mesh", "contours not as walked", "solid is not what the mesh encloses"};
    return names[static_cast<std::size_t>(verdict)];
}

std::string words_for(const VolumeCertificate& certificate) {
    if (certificate.verdict == VolumeVerdict::holds) {
        return "certified";
    }
    std::string text = "not certified: " + std::string(name_of(certificate.verdict));
    if (certificate.verdict == VolumeVerdict::solid_differs) {
        const auto mm2 = [](double area) { return exact_text(std::round(area * 1e3) / 1e3) + " mm2"; };
        text += ", as shells overlap or are turned inwards: in " + counted(certificate.differing_layers, "layer") +
                " it encloses " + mm2(certificate.differing_signed_mm2) + " by its facets, and " +
                mm2(certificate.differing_solid_mm2) + " are solid";
    }
    return text;
}

VolumeCertificate certify_volume(const SlicedMesh& sliced, const Parallel& parallel, double progress) {
    const CornerScale scale = scale_of(sliced.bounds, sliced.result);
    parallel.begin_stage(progress, 3);
    const Sums sums = sum_faces(sliced, scale, parallel);
    return sums.edges == 0 ? Certifier(sliced.result, sums, scale, parallel).run() : VolumeCertificate{};
}

}  // namespace lamella
