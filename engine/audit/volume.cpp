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
#include "lamella/audit/volume.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "audit/pair.hpp"
#include "base/guard.hpp"
#include "slicing/grid/exact.hpp"
#include "slicing/grid/grid_vector.hpp"
#include "slicing/grid/quantise.hpp"
#include "slicing/grid/vertex_hash.hpp"
#include "slicing/planes/plane_set.hpp"

namespace lamella {

namespace {

constexpr std::size_t certified_grain = 4096;
constexpr double relative_tolerance = 1e-12;

/// Towards zero, so that opposite faces cancel. Precondition: below 2^126.
Int128 whole_of(double value) noexcept {
    const auto high = static_cast<std::int64_t>(value * 0x1p-63);
    return (Int128{high} << 63) + static_cast<std::int64_t>(value - static_cast<double>(high) * 0x1p63);
}

/// How many fractional bits corners keep. With them a sum over all faces stays below 2^125.
struct Scale {
    int area_bits;
    int volume_bits;

    /// No face covers more than the mesh's box.
    static Scale of(const Bounds& bounds, const SliceResult& result) noexcept {
        double most = static_cast<double>(result.summary.triangles);
        for (int axis = 0; axis < 2; ++axis) {
            most *= (bounds.max_mm[axis] - bounds.min_mm[axis]) / (2 * result.unit_mm) + 2;
        }
        const int bits = 123 - (std::ilogb(most) + 1);
        return {bits, std::max(0, bits - 32)};
    }
};

/// Of one plane and the slab below it. Squares have sides of two units, heights are in units.
struct PlaneSums {
    Int128 area = 0;       ///< of corners, at the plane
    Int128 volume = 0;     ///< of corners, within the slab
    Int128 step = 0;       ///< of faces that are whole from within the slab on
    Int128 lever = 0;      ///< the same, times the heights from which on
    std::int64_t cut = 0;  ///< faces that the plane is the first to cut, less those that it is the first to miss

    void add(const PlaneSums& other) noexcept {
        area += other.area;
        volume += other.volume;
        step += other.step;
        lever += other.lever;
        cut += other.cut;
    }
};

/// What one worker sums.
struct Sums {
    std::vector<PlaneSums> planes;  ///< and one more, for the slab above them
    Int128 six_volumes = 0;         ///< of tetrahedra, in cubes of two units
    Int128 reach = 0;               ///< area times height of all faces: their corners cannot be larger
    std::uint64_t edges = 0;        ///< of directed edges; opposite ones cancel

    void add(const Sums& other) noexcept {
        six_volumes += other.six_volumes;
        reach += other.reach;
        edges += other.edges;
    }
};

/// Of the edge from one to the other; that of its opposite is the negative.
std::uint64_t directed(std::uint64_t from, std::uint64_t to) noexcept {
    const std::uint64_t edge = mixed(std::min(from, to) * 0x9E3779B97F4A7C15U + std::max(from, to));
    return from < to ? edge : (from > to ? 0 - edge : 0);
}

std::uint64_t boundary_of(const GridTriangle& t) noexcept {
    const std::array<std::uint64_t, 3> corners = {hash_of(t[0]), hash_of(t[1]), hash_of(t[2])};
    return directed(corners[0], corners[1]) + directed(corners[1], corners[2]) + directed(corners[2], corners[0]);
}

/// Adds faces to one worker's sums.
class FaceSummer {
public:
    FaceSummer(const PlaneSet& planes, Scale scale, Sums& sums) noexcept
        : planes_(planes),
          area_scale_(std::ldexp(1.0, scale.area_bits)),
          volume_scale_(std::ldexp(1.0, scale.volume_bits)),
          sums_(sums) {}

    void add(const GridTriangle& t) {
        sums_.edges += boundary_of(t);
        if (is_degenerate(t)) {
            return;
        }
        const std::array<GridVector, 3> corners = {half(t[0]), half(t[1]), half(t[2])};
        const std::int64_t covered = cross(corners[1] - corners[0], corners[2] - corners[0]).z;
        sums_.six_volumes += dot(cross(corners[0], corners[1]), corners[2]);
        std::array<std::int32_t, 3> z = {t[0].z, t[1].z, t[2].z};
        std::sort(z.begin(), z.end());
        const std::array<PlaneIndex, 3> above = {planes_.first_above(z[0]), planes_.first_above(z[1]),
                                                 planes_.first_above(z[2])};
        ++sums_.planes[above[0]].cut;
        --sums_.planes[above[2]].cut;
        sums_.planes[above[1]].step += covered;
        sums_.planes[above[1]].lever += Int128{covered} * z[1];
        if (covered != 0 && z[0] != z[2]) {
            add_corners(covered, z, above);
        }
    }

private:
    /// Covers bend · t² at t from its apex. How far it has been followed: t, and its square.
    struct Corner {
        double area_bend;
        double volume_bend;  ///< a third, for the volume up to t
        double apex;
        double t = 0;
        double square = 0;
    };

    /// Of a face that is neither upright nor level, by height.
    void add_corners(std::int64_t covered, const std::array<std::int32_t, 3>& z, const std::array<PlaneIndex, 3>& above) {
        const std::int64_t height = std::int64_t{z[2]} - z[0];
        const double share = static_cast<double>(covered) / static_cast<double>(height);
        sums_.reach += Int128{std::abs(covered)} * height;
        if (z[0] != z[1]) {
            Corner corner = corner_of(share, z[0], z[1]);
            for (PlaneIndex plane = above[0]; plane < above[1]; ++plane) {
                add_stretch(corner, plane, planes_.z(plane));
                add_area(corner, plane);
            }
            add_stretch(corner, above[1], z[1]);
        }
        if (z[1] != z[2]) {
            Corner corner = corner_of(-share, z[2], z[1]);
            for (PlaneIndex plane = above[2]; plane-- > above[1];) {
                add_stretch(corner, plane + 1, planes_.z(plane));
                add_area(corner, plane);
            }
            add_stretch(corner, above[1], z[1]);
        }
    }

    Corner corner_of(double share, std::int32_t apex, std::int32_t base) const noexcept {
        const double bend = share / std::abs(static_cast<double>(base) - apex);
        return {bend * area_scale_, bend * volume_scale_ / 3, static_cast<double>(apex)};
    }

    /// On to height z, within one slab.
    void add_stretch(Corner& corner, PlaneIndex slab, std::int32_t z) noexcept {
        const double t = std::abs(z - corner.apex);
        const double square = t * t;
        sums_.planes[slab].volume += whole_of(corner.volume_bend * (t - corner.t) * (square + t * corner.t + corner.square));
        corner.t = t;
        corner.square = square;
    }

    void add_area(const Corner& corner, PlaneIndex plane) noexcept {
        sums_.planes[plane].area += whole_of(corner.area_bend * corner.square);
    }

    const PlaneSet& planes_;
    double area_scale_;
    double volume_scale_;
    Sums& sums_;
};

Sums sum_faces(const MeshView& mesh, const SliceResult& result, const PlaneSet& planes, Scale scale,
               const Parallel& parallel) {
    std::vector<Sums> workers(static_cast<std::size_t>(parallel.threads()));
    for (Sums& sums : workers) {
        sums.planes.resize(result.layers.size() + 1);
    }
    with_reader(mesh, result.frame, result.unit_mm, [&](const auto& read) {
        parallel.run_ranges(mesh.triangle_count, certified_grain, [&](std::size_t begin, std::size_t end, int worker) {
            FaceSummer summer(planes, scale, workers[static_cast<std::size_t>(worker)]);
            for (std::size_t t = begin; t < end; ++t) {
                summer.add(read(t));
            }
        });
    });
    Sums all = std::move(workers[0]);
    for (std::size_t w = 1; w < workers.size(); ++w) {
        all.add(workers[w]);
        parallel.run_ranges(all.planes.size(), certified_grain, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t i = begin; i < end; ++i) {
                all.planes[i].add(workers[w].planes[i]);
            }
        });
    }
    return all;
}

/// What a layer's contours enclose, in square units, by the facets' orientations; and how far their edges run along the
/// axes.
struct LayerSize {
    double area = 0;
    double length = 0;
};

LayerSize size_of(const SliceResult& result, const Layer& layer) {
    Int128 twice_area = 0;
    Int128 length = 0;
    for (const Contour& contour : result.contours_of(layer)) {
        const std::span<const Point> points = result.points_of(contour);
        Int128 own = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Point a = points[i];
            const Point b = points[i + 1 == points.size() ? 0 : i + 1];
            own += cross(a, b);
            length += std::abs(std::int64_t{b.x} - a.x) + std::abs(std::int64_t{b.y} - a.y);
        }
        const int run = contour.role == Role::outer ? 1 : (contour.role == Role::hole ? -1 : 0);
        twice_area += own * (run * contour.orientation);
    }
    return {static_cast<double>(twice_area) / 2, static_cast<double>(length)};
}

/// From sums over a closed mesh to areas and volumes.
class Certifier {
public:
    Certifier(const SliceResult& result, const Sums& sums, Scale scale, const Parallel& parallel)
        : result_(result), sums_(sums), scale_(scale), parallel_(parallel) {}

    VolumeCertificate run() {
        measure();
        certificate_.mesh_mm3 = static_cast<double>(sums_.six_volumes) / 6 * 8 * cube_mm3();
        certificate_.verdict = volumes_agree() ? VolumeVerdict::holds : VolumeVerdict::volumes_differ;
        if (result_.fill_rule != FillRule::contours || !result_.closed_gaps.empty()) {
            certificate_.verdict = VolumeVerdict::not_as_walked;
        } else if (!compare_layers()) {
            certificate_.verdict = VolumeVerdict::areas_differ;
        }
        return std::move(certificate_);
    }

private:
    double cube_mm3() const noexcept { return result_.unit_mm * result_.unit_mm * result_.unit_mm; }

    /// Faces are in squares of two units, of which a face's normal spans two: half an area each; those below face down.
    double area(Int128 sum) const noexcept { return -2 * std::ldexp(static_cast<double>(sum), -scale_.area_bits); }
    double volume(Int128 sum) const noexcept { return -2 * std::ldexp(static_cast<double>(sum), -scale_.volume_bits); }

    void measure() {
        const std::size_t planes = result_.layers.size();
        areas_.resize(planes);
        cut_.resize(planes);
        certificate_.slab_mm3.resize(planes + 1);
        Int128 whole = 0;  // of faces wholly below
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
        const double corners = crossings_ + 2 * static_cast<double>(result_.summary.triangles);
        const double lost =
            2 * (static_cast<double>(sums_.reach) * 0x1p-49 + 2 * std::ldexp(corners, -scale_.volume_bits)) * cube_mm3();
        return std::abs(certificate_.slabs_mm3 - certificate_.mesh_mm3) <=
               std::max(relative_tolerance * std::abs(certificate_.mesh_mm3), lost);
    }

    /// Also notes where they differ most.
    bool compare_layers() {
        std::vector<LayerSize> sizes(result_.layers.size());
        parallel_.run(sizes.size(), [&](std::size_t l, int) { sizes[l] = size_of(result_, result_.layers[l]); });
        const double square_mm2 = result_.unit_mm * result_.unit_mm;
        constexpr double moved = 0.5 + 0x1p-16;  // a point, along an axis; with what double loses of a corner's square
        double largest = 0;
        bool agree = true;
        for (std::size_t l = 0; l < sizes.size(); ++l) {
            const double difference = std::abs(areas_[l] - sizes[l].area);
            const double allowed = moved * sizes[l].length + moved * moved * cut_[l];
            agree = agree && difference <= allowed;
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
    Scale scale_;
    const Parallel& parallel_;
    std::vector<double> areas_;  // of each layer, square units
    std::vector<double> cut_;    // triangles that the layer's plane cuts
    double crossings_ = 0;
    Int128 slabs_ = 0;
    VolumeCertificate certificate_;
};

Result<VolumeCertificate> certify_or_throw(const MeshView& mesh, const SliceResult& result, const Control& control) {
    const Parallel parallel(control);
    parallel.begin_stage(0.1);
    const Result<Bounds> bounds = examine(mesh, result, parallel);
    if (!bounds) {
        return bounds.error();
    }
    PlaneSet planes(nullptr);
    planes.build(result.layers);
    const Scale scale = Scale::of(*bounds, result);
    parallel.begin_stage(0.8, static_cast<std::size_t>(parallel.threads()));
    const Sums sums = sum_faces(mesh, result, planes, scale, parallel);
    parallel.begin_stage(0.99);
    VolumeCertificate certificate = sums.edges == 0 ? Certifier(result, sums, scale, parallel).run() : VolumeCertificate{};
    parallel.finish();
    return certificate;
}

}  // namespace

std::string_view name_of(VolumeVerdict verdict) noexcept {
    constexpr std::array<std::string_view, 5> names = {"holds", "areas differ", "volumes differ", "open mesh",
                                                       "contours not as walked"};
    return names[static_cast<std::size_t>(verdict)];
}

Result<VolumeCertificate> certify_volume(const MeshView& mesh, const SliceResult& result, const Control& control) noexcept {
    return guarded(control, [&] { return certify_or_throw(mesh, result, control); });
}

}  // namespace lamella
