// Checks soups with corners on small integers. What check() finds must agree with what it counts alone, and must depend
// neither on threads nor on the order of triangles and corners.
#include <cmath>

#include "bytes.hpp"
#include "lamella/io.hpp"
#include "lamella/lamella.hpp"

using namespace lamella;

namespace {

constexpr std::size_t most_triangles = 120;

CheckOptions drawn_options(fuzz::Bytes& bytes) {
    const unsigned choice = bytes.next();
    return {.frame = {.grid_mm = choice % 2 == 0 ? 0.0 : 1.0},  // on the coarse grid half of the corners coincide
            .tolerance_mm = choice / 2 % 4 * 0.7,
            .sliver_ratio = 2.0 + choice / 8 % 8,
            .most_places = choice / 64 * 5};
}

void check_places(const MeshCheck& found, const CheckOptions& options, std::size_t triangles) {
    for (const FaultFinding& finding : found.findings) {
        fuzz::require(finding.places.size() == std::min<std::uint64_t>(finding.count, options.most_places),
                      "as many places as were asked for");
        for (const FaultPlace& place : finding.places) {
            fuzz::require(place.point_count >= 1 && place.point_count <= 3, "a place has points");
            for (const std::int64_t triangle : place.triangles) {
                fuzz::require(triangle >= -1 && triangle < static_cast<std::int64_t>(triangles), "triangles of the input");
            }
        }
    }
}

void check_shells(const MeshCheck& found) {
    std::uint64_t triangles = found.of(Fault::collapsed_face).count;
    for (const MeshShell& shell : found.shells) {
        triangles += shell.triangles;
        fuzz::require((shell.depth == 0) == (shell.parent < 0), "a shell with a depth has a parent");
        fuzz::require(shell.parent < 0 || found.shells[static_cast<std::size_t>(shell.parent)].closed,
                      "only closed shells enclose others");
        fuzz::require(shell.closed || (shell.orientation == 0 && shell.volume_mm3 == 0),
                      "only closed shells have an orientation");
    }
    fuzz::require(triangles == found.triangles, "every triangle belongs to one shell, or is collapsed");
}

/// The counts are made in another way.
void check_census(const MeshCheck& found) {
    const auto count = [&found](Fault fault) { return found.of(fault).count; };
    fuzz::require(count(Fault::boundary_edge) == found.boundary_edges, "boundary edges are counted");
    fuzz::require(count(Fault::overfull_balanced) + count(Fault::overfull_unbalanced) == found.overfull_edges,
                  "over-full edges are counted");
    fuzz::require(count(Fault::mismatched_edge) == found.mismatched_edges, "mismatched edges are counted");
    fuzz::require(count(Fault::collapsed_face) == found.degenerate, "collapsed faces are counted");
    fuzz::require(found.shells.size() == found.shell_count, "shells are counted");
    fuzz::require(!found.clean() || found.closed, "a mesh without faults is closed");
    fuzz::require((count(Fault::boundary_edge) == 0) == (count(Fault::boundary_loop) == 0), "boundary edges form loops");
    fuzz::require(found.complete(), "so few triangles are searched completely");
}

MeshCheck found_in(const std::vector<fuzz::Triangle>& triangles, const CheckOptions& options, int threads) {
    const std::vector<double> soup = fuzz::soup_of<double>(triangles);
    return fuzz::value_of(check(MeshView::soup(std::span<const double>(soup)), options, {.threads = threads}));
}

std::string text_of(const MeshCheck& found) {
    return make_check_json(found, {}, 1000).value();
}

/// The triangle that represents a place may depend on the order of the input; all else must not.
MeshCheck without_triangles(MeshCheck found) {
    for (FaultFinding& finding : found.findings) {
        for (FaultPlace& place : finding.places) {
            place.triangles = {-1, -1};
        }
    }
    for (MeshShell& shell : found.shells) {
        shell.triangle = -1;
    }
    return found;
}

/// On the grid of 1 mm corners move by at most 1 mm.
bool stay_apart(const fuzz::Corner& a, const fuzz::Corner& b) {
    return std::abs(a[0] - b[0]) > 2 || std::abs(a[1] - b[1]) > 2 || std::abs(a[2] - b[2]) > 2;
}

/// Whether every triangle has two equal corners, so that there is no mesh to check. Then it must be refused as such.
bool all_collapse(const std::vector<fuzz::Triangle>& triangles, const CheckOptions& options) {
    const std::vector<double> soup = fuzz::soup_of<double>(triangles);
    const MeshView mesh = MeshView::soup(std::span<const double>(soup));
    const Result<MeshCheck> found = check(mesh, options);
    if (found) {
        return false;
    }
    fuzz::require(found.error().code == ErrorCode::empty_mesh, found.error().message);
    for (const auto& [a, b, c] : triangles) {
        fuzz::require(!stay_apart(a, b) || !stay_apart(b, c) || !stay_apart(c, a), "a triangle that stays is checked");
    }
    const Result<MeshCheck> counts = check(mesh, {.frame = options.frame, .counts_only = true});
    fuzz::require(!counts && counts.error().message == found.error().message, "counting refuses the same mesh");
    return true;
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::Bytes bytes(data, size);
    const std::uint32_t seed = bytes.next();
    const CheckOptions options = drawn_options(bytes);
    std::vector<fuzz::Triangle> triangles;
    do {
        fuzz::add_shape(bytes, seed % 2 != 0, 1, triangles);
    } while (!bytes.empty() && triangles.size() < most_triangles);
    if (all_collapse(triangles, options)) {
        return 0;
    }
    const MeshCheck found = found_in(triangles, options, 1);
    check_places(found, options, triangles.size());
    check_shells(found);
    check_census(found);
    fuzz::require(text_of(found_in(triangles, options, 3)) == text_of(found),
                  "the number of threads does not change the result");
    fuzz::shuffle_soup(triangles, seed);
    fuzz::require(text_of(without_triangles(found_in(triangles, options, 1))) == text_of(without_triangles(found)),
                  "the order of triangles and corners does not matter");
    return 0;
}
