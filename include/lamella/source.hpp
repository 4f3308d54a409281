// What can be cut: a mesh in memory, a mesh that was prepared, several parts, a file.
//
//     lamella::Slicer slicer;
//     const auto once = slicer.slice(mesh);                       // a MeshView, or anything whose view() gives one
//
//     const auto prepared = lamella::prepare(mesh);               // for slices again and again, by other heights or rules
//     lamella::SliceResult live;
//     for (const double height : {1.5, 0.25, 7.0}) {
//         if (prepared && slicer.slice_to(live, *prepared, {.heights_mm = std::vector<double>{height}})) {
//             std::printf("z %g mm: %g mm2\n", height, live[0].area_mm2());
//         }
//     }
//
//     // A mesh, and with it the same at twice its size, each with its own contours.
//     const lamella::Part parts[] = {{.mesh = mesh}, {.mesh = mesh, .placement = lamella::Transform::scale(2)}};
//     const auto both = slicer.slice(parts);
//
//     // The mesh without what half of it fills, which is cut out of it.
//     const lamella::Part holed[] = {{.mesh = mesh},
//                                    {.mesh = mesh,
//                                     .placement = lamella::Transform::scale(0.5),
//                                     .role = lamella::PartRole::negative}};
//     const auto rest = slicer.slice(holed);
//
//     // The mesh three times, cut once.
//     const std::vector<std::array<double, 3>> places = {{0, 0, 0}, {250, 0, 0}, {0, 250, 0}};
//     const lamella::Part copies[] = {{.mesh = mesh, .at_mm = places}};
//     const auto plate = slicer.slice(copies);
//
// Several parts are cut at the planes of one plan, on one grid: planes are chosen for the box around the solid parts, the
// grid for that around all. Facets of one part never continue those of another. A layer has the contours of part 0, then of
// part 1, and so on, those of each as it has them alone; Contour::part is the part's index. By SliceOptions::unite_parts the
// rules of regions are done to all of a layer together, and contours are in the order of one mesh. Heights are rounded as
// floats where every part is of floats that no transform moves in double and no place lifts, as doubles elsewhere. Many
// small parts are cut side by side, larger ones one after another by all threads; all are held until they are put together,
// so that the result takes its memory twice.
//
// A part with places stands for as many parts, one after the other, each with a number of its own and the bytes of the mesh
// moved there by hand. Places are turned and scaled as Frame::transform turns and scales parts, then rounded to the even
// grid: 0.3 mm are 314,572 units. All at one height are cut once; the mesh must fit the grid where it is cut, too. Objects
// with roles are copied as a whole: their parts have the same places, and roles act at each by itself.
//
// Where an object has a part that is negative or a modifier, each of its parts is made a region by the rules of the options,
// by non-zero where they have none, and one overlay of these in each layer says what is solid, and of which part:
//
//     outside all solid parts, or inside a negative one      nothing
//     else inside modifiers                                  the last of them
//     else                                                   the last of the solid parts that it is inside of
//
//     .-------------.          Contours of part 0, a box from which part 1 is taken, and of part 2, a modifier: they share
//     | 0  .---.  .-|----.     the points of the boundary between them, and neither overlap nor leave gaps.
//     |    | 1 |  |2|    |
//     |    '---'  '-|----'
//     '-------------'
//
// Contours of supports are cut and have their part's number, but are no solid: a layer's area counts them, and a host that
// wants its solid's leaves them out. By SliceOptions::unite_parts, what is solid is united afterwards, supports left out, so
// that the modifiers' boundaries go, and the rules other than the fill rule are done to that region.
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "lamella/context.hpp"
#include "lamella/error.hpp"
#include "lamella/mesh.hpp"
#include "lamella/options.hpp"

namespace lamella {

namespace detail {
struct PreparedImpl;
class SourceImpl;
}  // namespace detail

/// A mesh with the order of its triangles by height: one plane reads little more than the triangles that it cuts, where a
/// MeshView is read whole. Immutable: any number of threads may slice it at once, each with a Slicer of its own. What the
/// MeshView that it was made of views must outlive it, unchanged. One that was moved from may only be assigned to or
/// destroyed.
class PreparedMesh {
public:
    explicit PreparedMesh(std::unique_ptr<const detail::PreparedImpl> impl) noexcept;
    ~PreparedMesh();
    PreparedMesh(PreparedMesh&&) noexcept;
    PreparedMesh& operator=(PreparedMesh&&) noexcept;

    /// As given to prepare(), with the grid that was chosen. A slice's own frame is this one, or left out.
    const Frame& frame() const noexcept;
    /// The memory that it holds beside the mesh: 12 bytes a triangle and about an eighth of a byte more for each.
    std::size_t bytes() const noexcept;

private:
    friend class Source;
    std::unique_ptr<const detail::PreparedImpl> impl_;
};

struct Part;

/// What is cut, as a parameter only: it views what it is made of, which must outlive the call.
class Source {
public:
    // NOLINTBEGIN(google-explicit-constructor): made where a source is passed
    Source(const MeshView& mesh) noexcept : mesh_(mesh) {}
    Source(const PreparedMesh& mesh) noexcept : prepared_(mesh.impl_.get()) {}
    Source(const detail::SourceImpl& other) noexcept : other_(&other) {}
    template <class Parts>
    requires std::convertible_to<const Parts&, std::span<const Part>> Source(const Parts& parts)
    noexcept : Source(std::span<const Part>(parts), 0) {}
    /// Of MeshFile, WeldedMesh, MeshStream, or a host's own class.
    template <class Mesh>
    requires requires(const Mesh& mesh) {
        { mesh.view() } -> std::convertible_to<Source>;
    }
    Source(const Mesh& mesh) noexcept : Source(mesh.view()) {}
    // NOLINTEND(google-explicit-constructor)

    // What it was made of, for the library: the first of these that is not null, else the mesh.
    const detail::PreparedImpl* prepared() const noexcept { return prepared_; }
    const detail::SourceImpl* other() const noexcept { return other_; }
    const Part* parts() const noexcept { return parts_; }
    std::size_t part_count() const noexcept { return part_count_; }
    bool is_parts() const noexcept { return is_parts_; }
    const MeshView& mesh() const noexcept { return mesh_; }

private:
    Source(std::span<const Part> parts, int) noexcept;

    MeshView mesh_{};
    const detail::PreparedImpl* prepared_ = nullptr;
    const detail::SourceImpl* other_ = nullptr;
    const Part* parts_ = nullptr;
    std::size_t part_count_ = 0;
    bool is_parts_ = false;
};

/// What a part is for.
enum class PartRole : std::uint8_t {
    solid,
    negative,  ///< taken out of the solid parts of its object, wherever it stands among them
    modifier,  ///< gives what it covers of its object's solid its own number
    support_blocker,
    support_enforcer,
    support,
};

struct Part {
    MeshView mesh{};
    Transform placement{};  ///< from the part in mm to the space that all parts share; Frame::transform comes next
    PartRole role = PartRole::solid;
    std::uint32_t object = 0;  ///< roles act among parts of the same number, of which at most 63 are no supports
    /// In place of `mesh`. It must be prepared on the grid of all, with the transform that the frame and `placement` make,
    /// or they make none.
    const PreparedMesh* prepared = nullptr;
    /// Moves from where `placement` puts the part, one for each copy of it; none: it stays there.
    std::span<const std::array<double, 3>> at_mm{};
};

inline Source::Source(std::span<const Part> parts, int /*made of parts*/) noexcept
    : parts_(parts.data()), part_count_(parts.size()), is_parts_(true) {}

/// O(n) for n triangles, of which the mesh is read three times. Takes 12 bytes a triangle from the context's memory, which
/// it holds until its end, and while it works some more for its lists. A mesh without triangles is prepared too; slicing it
/// needs SliceOptions::allow_empty. Errors: invalid_argument, bad_coordinate (with the triangle), out_of_memory, cancelled.
Result<PreparedMesh> prepare(const MeshView& mesh, const Frame& frame = {}, const Context& context = {}) noexcept;

}  // namespace lamella
