#include "mesh/check/embedded_stars.hpp"

#include <array>
#include <bit>
#include <cstddef>

#include "base/atomic_word.hpp"
#include "slicing/grid/grid_vector.hpp"

namespace lamella {

namespace {

constexpr std::size_t grain = std::size_t{1} << 14;

/// Bit 2 * axis where the face is seen counter-clockwise from the axis's upper end, the next bit where from its lower end.
std::uint32_t views_of(const std::array<GridVertex, 3>& corners) {
    const GridVector a = half(corners[0]);
    const GridVector normal = cross(half(corners[1]) - a, half(corners[2]) - a);
    const auto ends = [](std::int64_t component) { return component > 0 ? 1U : component < 0 ? 2U : 0U; };
    return ends(normal.x) | ends(normal.y) << 2 | ends(normal.z) << 4;
}

/// The coordinate that points upwards in a view along the axis, to whose right the axis after it points.
std::int32_t height_in(std::size_t axis, const GridVertex& v) {
    return axis == 0 ? v.z : axis == 1 ? v.x : v.y;
}

}  // namespace

EmbeddedStars::EmbeddedStars(const GridMesh& mesh, const EdgeTable& edges, const Parallel& parallel)
    : mesh_(mesh), words_(parallel.memory()), areas_(parallel.memory()) {
    words_.resize_discarding(mesh.vertices.size());
    areas_.resize_discarding(mesh.faces.size());
    parallel.run_ranges(words_.size(), grain, [&](std::size_t begin, std::size_t end, int) {
        std::fill(words_.begin() + begin, words_.begin() + end, every_view);
    });
    for (const std::uint32_t edge : edges.irregular()) {
        words_[edges[edge].lower] = 0;
        words_[edges[edge].upper] = 0;
    }
    find_views(parallel);
    count_rounds(parallel);
}

void EmbeddedStars::find_views(const Parallel& parallel) {
    parallel.run_ranges(mesh_.faces.size(), grain, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i != end; ++i) {
            const Face& face = mesh_.faces[i];
            const Word views = views_of(mesh_.corners(face));
            areas_[i] = views != 0 ? 1 : 0;
            for (const std::uint32_t vertex : face.corners) {
                AtomicWord<Word>(words_[vertex]).keep(views);
            }
        }
    });
}

void EmbeddedStars::count_rounds(const Parallel& parallel) {
    parallel.run_ranges(mesh_.faces.size(), grain, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i != end; ++i) {
            const Face& face = mesh_.faces[i];
            const std::array<GridVertex, 3> corners = mesh_.corners(face);
            for (std::size_t corner = 0; corner < 3; ++corner) {
                const AtomicWord<Word> word(words_[face.corners[corner]]);
                const Word now = word.load();
                if ((now & every_view) == 0 || now >= 2 * one_round) {
                    continue;
                }
                const auto view = static_cast<std::size_t>(std::countr_zero(now));
                const std::int32_t v = height_in(view / 2, corners[corner]);
                std::int32_t p = height_in(view / 2, corners[corner == 2 ? 0 : corner + 1]);
                std::int32_t q = height_in(view / 2, corners[corner == 0 ? 2 : corner - 1]);
                if (view % 2 != 0) {
                    std::swap(p, q);
                }
                if (p <= v && v < q) {
                    word.add(one_round);
                }
            }
        }
    });
}

}  // namespace lamella
