// Times the calls that hosts make beside whole slices: single planes of a prepared mesh, and small meshes with a Slicer that
// is kept.
#include <algorithm>
#include <vector>

#include "engine/counting_memory.hpp"
#include "measure.hpp"

namespace lamella::bench {

namespace {

constexpr int host_threads = 2;

SliceOptions at_height(double mm) {
    return {.heights_mm = std::vector<double>{mm}};
}

/// One plane a call at nineteen heights, of which the slowest counts: of a mesh and of what was prepared of it, which must
/// give the same.
Figures time_prepared(const Prepared& of, int rounds) {
    const Context context{.threads = host_threads};
    const MeshView mesh = of.mesh->view();
    const PreparedMesh prepared = checked(prepare(mesh, {}, context));
    Slicer slicers[2];
    SliceResult results[2];
    const auto medians = [&](const SliceOptions& options) {
        const auto of_prepared = [&] { checked(slicers[0].slice_to(results[0], prepared, options, context)); };
        const auto of_mesh = [&] { checked(slicers[1].slice_to(results[1], mesh, options, context)); };
        const Figures ms = medians_of({{"prepared", of_prepared}, {"mesh", of_mesh}}, rounds);
        if (results[0].hash() != results[1].hash()) {
            fail("the prepared mesh gives another result");
        }
        return ms;
    };
    Figures figures = medians_of({{"prepare", [&] { checked(prepare(mesh, {}, context)); }}}, rounds);
    const double low = of.info.box.min_mm[2];
    const double high = of.info.box.max_mm[2];
    for (int i = 1; i < 20; ++i) {
        for (const auto& [which, ms] : medians(at_height(low + (high - low) * i / 20))) {
            figures["plane_" + which] = std::max(figures["plane_" + which], ms);
        }
    }
    figures["bytes"] = static_cast<double>(prepared.bytes());
    return figures;
}

/// One plane of a box of twelve triangles.
Figures time_small(int threads) {
    const std::vector<float> corners = {0, 0, 0, 9, 0, 0, 9, 9, 0, 0, 9, 0, 0, 0, 9, 9, 0, 9, 9, 9, 9, 0, 9, 9};
    const std::vector<std::uint32_t> faces = {0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4,
                                              1, 2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6, 3, 0, 4, 3, 4, 7};
    const MeshView box = MeshView::indexed(corners, faces);
    const SliceOptions options = at_height(4.5);
    CountingMemory memory;
    const Context counted{.threads = threads, .memory = &memory};
    Slicer slicer;
    SliceResult result;
    std::uint64_t taken = 0;
    constexpr int calls = 1000;
    const auto slice_kept = [&] {
        const std::uint64_t before = memory.asked();
        for (int call = 0; call < calls; ++call) {
            checked(slicer.slice_to(result, box, options, counted));
        }
        taken = memory.asked() - before;
    };
    const auto slice_fresh = [&] {
        for (int call = 0; call < calls; ++call) {
            checked(slice(box, options, {.threads = threads}));
        }
    };
    const Figures us_a_call = medians_of({{"kept", slice_kept}, {"fresh", slice_fresh}}, 21);
    return {{"kept_us", us_a_call.at("kept")}, {"fresh_us", us_a_call.at("fresh")}, {"blocks", static_cast<double>(taken)}};
}

}  // namespace

void add_hosts(const Options& options, const Case& wanted) {
    add_benchmark(options, "host/" + wanted.name + "/prepared", host_threads,
                  [=](benchmark::State&) { return time_prepared(prepared(wanted), options.quick ? 1 : 9); });
}

void add_small_calls(const Options& options) {
    for (const int threads : {1, host_threads}) {
        add_benchmark(options, "host/box/small", threads, [=](benchmark::State&) { return time_small(threads); });
    }
}

}  // namespace lamella::bench
