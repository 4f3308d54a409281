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
#include <span>
#include <utility>
#include <vector>

#include "audit/questions.hpp"
#include "base/numbers.hpp"
#include "base/words.hpp"
#include "slicing/grid/grid_vector.hpp"
#include "slicing/grid/quantise.hpp"
#include "slicing/grid/vertex_hash.hpp"
#include "slicing/regions/rules.hpp"

namespace lamella {

namespace {

constexpr std::size_t certified_grain = 4096;
constexpr double relative_tolerance = 1e-12;

/// How many fractional bits corners keep. With them a sum over all faces stays below 2^125.
struct CornerScale {
    int area_bits;
    int volume_bits;
};

/// No face covers more than the mesh's box.
CornerScale scale_of(const Bounds& bounds, const SliceResult& result) noexcept {
    double most = static_cast<double>(result.info.triangles);
    for (int axis = 0; axis < 2; ++axis) {
        most *= (bounds.max_mm[axis] - bounds.min_mm[axis]) / (2 * result.info.grid_mm) + 2;
    }
    const int bits = 123 - (std::ilogb(most) + 1);
    return {bits, std::max(0, bits - 32)};
}

/// Sums for one plane and the slab below it. Squares have sides of two units, heights are in units.
struct PlaneSums {
    Int128 area = 0;       ///< by corners, at the plane
    Int128 volume = 0;     ///< by corners, within the slab
    Int128 step = 0;       ///< by faces that are whole from within the slab on
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

/// A corner of a face, from its apex to the height where the face is widest. It covers bend * t^2 at t from the apex.
struct FaceCorner {
    double apex;
    double base;
    double bend;
    PlaneIndex first;  ///< slabs [first, last] that it reaches into, and planes [first, last)
    PlaneIndex last;
};

/// A hash of the edge from one to the other; that of its opposite is the negative.
std::uint64_t directed(std::uint64_t from, std::uint64_t to) noexcept {
    const std::uint64_t edge = mul_fold((from + to) ^ 0x94D049BB133111EBU, (from ^ to) ^ 0xD6E8FEB86659FD93U);
    return (std::uint64_t{from < to} - std::uint64_t{from > to}) * edge;
}

std::uint64_t boundary_of(const GridTriangle& t) noexcept {
    const std::array<std::uint64_t, 3> corners = {quick_hash_of(t[0]), quick_hash_of(t[1]), quick_hash_of(t[2])};
    return directed(corners[0], corners[1]) + directed(corners[1], corners[2]) + directed(corners[2], corners[0]);
}

std::array<std::int32_t, 3> ascending(std::int32_t a, std::int32_t b, std::int32_t c) noexcept {
    const std::int32_t low = std::min(a, b);
    const std::int32_t high = std::max(a, b);
    return {std::min(low, c), std::max(low, std::min(high, c)), std::max(high, c)};
}

/// Towards zero. The compiler's own conversion takes five times as long. Precondition: below 2^125.
Int128 whole_part(double value) noexcept {
    constexpr int low_bits = 62;
    const auto high = static_cast<std::int64_t>(value * 0x1p-62);
    const auto low = static_cast<std::int64_t>(value - static_cast<double>(high) * 0x1p62);
    return (Int128{high} << low_bits) + low;
}

/// The sums of one worker, or of all.
class FaceSums {
public:
    FaceSums(const PlaneSet& planes, CornerScale scale)
        : planes_(planes),
          area_scale_(std::ldexp(1.0, scale.area_bits)),
          volume_scale_(std::ldexp(1.0, scale.volume_bits)),
          sums_(std::size_t{planes.size()} + 1) {}

    void add(const GridTriangle& t) noexcept {
        edges_ += boundary_of(t);
        if (is_degenerate(t)) {
            return;
        }
        const std::array<GridVector, 3> halves = {half(t[0]), half(t[1]), half(t[2])};
        const std::int64_t covered = cross(halves[1] - halves[0], halves[2] - halves[0]).z;
        six_volumes_ += dot(cross(halves[0], halves[1]), halves[2]);
        const std::array<std::int32_t, 3> z = ascending(t[0].z, t[1].z, t[2].z);
        const std::array<PlaneIndex, 3> above = {planes_.first_above(z[0]), planes_.first_above(z[1]),
                                                 planes_.first_above(z[2])};
        ++sums_[above[0]].cut;
        --sums_[above[2]].cut;
        sums_[above[1]].step += covered;
        sums_[above[1]].lever += Int128{covered} * z[1];
        if (covered != 0 && z[0] != z[2]) {
            add_corners(covered, z, above);
        }
    }

    /// Adds planes [begin, end) of another worker.
    void add(const FaceSums& other, std::size_t begin, std::size_t end) noexcept {
        for (std::size_t plane = begin; plane < end; ++plane) {
            sums_[plane].add(other.sums_[plane]);
        }
    }
    void add_whole(const FaceSums& other) noexcept {
        six_volumes_ += other.six_volumes_;
        reach_ += other.reach_;
        edges_ += other.edges_;
    }

    /// By plane, and one more for the slab above them.
    const std::vector<PlaneSums>& planes() const noexcept { return sums_; }
    Int128 six_volumes() const noexcept { return six_volumes_; }  ///< tetrahedra, in cubes of two units
    Int128 reach() const noexcept { return reach_; }  ///< area times height of all faces: their corners cannot be larger
    std::uint64_t edges() const noexcept { return edges_; }  ///< hash of directed edges; opposite ones cancel

private:
    /// The face is neither upright nor level; all is by height.
    void add_corners(std::int64_t covered, const std::array<std::int32_t, 3>& z,
                     const std::array<PlaneIndex, 3>& above) noexcept {
        const std::int64_t height = std::int64_t{z[2]} - z[0];
        const double share = static_cast<double>(covered) / static_cast<double>(height);
        reach_ += Int128{std::abs(covered)} * height;
        if (z[0] != z[1]) {
            add_corner<true>(corner_of(share, z[0], z[1], above[0], above[1]));
        }
        if (z[1] != z[2]) {
            add_corner<false>(corner_of(-share, z[2], z[1], above[1], above[2]));
        }
    }

    static FaceCorner corner_of(double share, std::int32_t apex, std::int32_t base, PlaneIndex first,
                                PlaneIndex last) noexcept {
        const double bend = share / std::abs(static_cast<double>(base) - apex);
        return {static_cast<double>(apex), static_cast<double>(base), bend, first, last};
    }

    /// Each number is rounded towards zero, so that opposite faces cancel. `rises`: the apex is the lowest point.
    template <bool rises>
    void add_corner(const FaceCorner& corner) noexcept {
        const double area_bend = corner.bend * area_scale_;
        const double volume_bend = corner.bend * volume_scale_ / 3;
        const std::int32_t* const heights = planes_.heights() + corner.first;
        double below = heights[-1];
        for (std::size_t slab = corner.first; slab <= corner.last; ++slab) {
            const double above = heights[slab - corner.first];
            // Within the slab, from the apex: where the corner ends, and where it entered.
            const double to =
                rises ? std::min(above, corner.base) - corner.apex : corner.apex - std::max(below, corner.base);
            const double from = std::max(rises ? below - corner.apex : corner.apex - above, 0.0);
            const double square = to * to;
            const double square_from = from * from;
            PlaneSums& sums = sums_[slab];
            sums.volume += whole_part(volume_bend * (to - from) * (square + to * from + square_from));
            if (slab < corner.last) {
                sums.area += whole_part(area_bend * (rises ? square : square_from));
            }
            below = above;
        }
    }

    const PlaneSet& planes_;
    double area_scale_;
    double volume_scale_;
    std::vector<PlaneSums> sums_;
    Int128 six_volumes_ = 0;
    Int128 reach_ = 0;
    std::uint64_t edges_ = 0;
};

FaceSums sum_faces(const SlicedMesh& sliced, CornerScale scale, const Parallel& parallel) {
    std::vector<FaceSums> workers(static_cast<std::size_t>(parallel.threads()), FaceSums(sliced.planes, scale));
    with_reader(sliced.mesh, sliced.placing, sliced.result.info.grid_mm, [&](const auto& read) {
        parallel.run_ranges(sliced.mesh.triangle_count, certified_grain,
                            [&](std::size_t begin, std::size_t end, int worker) {
                                FaceSums& sums = workers[static_cast<std::size_t>(worker)];
                                for (std::size_t t = begin; t < end; ++t) {
                                    sums.add(read(t));
                                }
                            });
    });
    FaceSums& all = workers.front();
    const std::span<const FaceSums> others = std::span(workers).subspan(1);
    parallel.run_ranges(all.planes().size(), certified_grain, [&](std::size_t begin, std::size_t end, int) {
        for (const FaceSums& own : others) {
            all.add(own, begin, end);
        }
    });
    for (const FaceSums& own : others) {
        all.add_whole(own);
    }
    return std::move(all);
}

/// The area that a layer's contours enclose, in square units; and how far their edges run along the axes.
struct LayerSize {
    double area = 0;
    double length = 0;
    bool walked = true;  ///< no rule has made or dropped contours
};

/// Twice the area within a closed path, and how far its edges run along the axes.
std::pair<Int128, std::uint64_t> traced(std::span<const Point> points) noexcept {
    Int128 twice_area = 0;
    std::uint64_t length = 0;  // up to 2^32 edges of up to 2^32
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Point at = points[i];
        const Point next = points[i + 1 == points.size() ? 0 : i + 1];
        twice_area += std::int64_t{at.x} * next.y - std::int64_t{at.y} * next.x;
        length += static_cast<std::uint64_t>(std::abs(std::int64_t{next.x} - at.x) + std::abs(std::int64_t{next.y} - at.y));
    }
    return {twice_area, length};
}

/// `solid`: whatever the facets say.
LayerSize size_of(const SliceResult& result, const Layer& layer, bool solid) {
    Int128 twice_area = 0;
    Int128 length = 0;
    std::uint64_t segments = 0;
    for (const Contour& contour : result.contours_of(layer)) {
        segments += contour.segments;
        const std::span<const Point> points = result.points_of(contour);
        const auto [own, own_length] = traced(points);
        length += own_length;
        const int run = contour.role == Role::outer ? 1 : (contour.role == Role::hole ? -1 : 0);
        twice_area += own * (solid ? std::abs(run) : run * contour.orientation);
    }
    return {static_cast<double>(twice_area) / 2, static_cast<double>(length), segments == layer.segments};
}

/// From sums over a closed mesh to areas and volumes.
class Certifier {
public:
    Certifier(const SliceResult& result, const FaceSums& sums, CornerScale scale, const Parallel& parallel)
        : result_(result), sums_(sums), scale_(scale), parallel_(parallel) {}

    VolumeCertificate run() {
        measure();
        certificate_.mesh_mm3 = static_cast<double>(sums_.six_volumes()) / 6 * 8 * cube_mm3();
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
            const PlaneSums& at = sums_.planes()[i];
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
            2 * (static_cast<double>(sums_.reach()) * 0x1p-49 + 2 * std::ldexp(corners, -scale_.volume_bits)) * cube_mm3();
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
    const FaceSums& sums_;
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

VolumeCertificate certify_volume(const SlicedMesh& sliced, const ProgressShare& progress) {
    const CornerScale scale = scale_of(sliced.bounds, sliced.result);
    const Parallel& parallel = progress.parallel;
    progress.begin(0.8, static_cast<std::size_t>(parallel.threads()));
    const FaceSums sums = sum_faces(sliced, scale, parallel);
    progress.begin(1);
    return sums.edges() == 0 ? Certifier(sliced.result, sums, scale, parallel).run() : VolumeCertificate{};
}

}  // namespace lamella
