// The calls of lamella.h that cut, and that put contours together.
#include <algorithm>
#include <array>
#include <memory>
#include <new>
#include <span>
#include <utility>
#include <vector>

#include "c/call.hpp"
#include "lamella/layers.hpp"

namespace lamella::c {

namespace {

/// The program's source. Holds the parts that the C++ source views.
class GivenSource {
public:
    explicit GivenSource(const lamella_source* given) {
        require_given(given, "the source");
        c_ = read_sized(given);
        require_one({c_.mesh, c_.prepared, c_.parts}, "mesh, prepared and parts of a source");
        if (c_.parts != nullptr) {
            read_parts();
        }
    }

    Source source() const {
        if (c_.prepared != nullptr) {
            return c_.prepared->mesh;
        }
        return c_.parts != nullptr ? Source(parts_) : Source(read_mesh(c_.mesh));
    }

private:
    void read_parts() {
        for (std::size_t p = 0; p < c_.part_count; ++p) {
            Part& part = parts_.emplace_back();
            if (c_.part_prepared != nullptr && c_.part_prepared[p] != nullptr) {
                part.prepared = &c_.part_prepared[p]->mesh;
            } else {
                part.mesh = read_mesh(c_.parts[p].mesh);
            }
            if (c_.part_roles != nullptr) {
                require_choice(c_.part_roles[p], LAMELLA_SUPPORT, "the part's role");
                part.role = static_cast<PartRole>(c_.part_roles[p]);
            }
            part.object = c_.part_objects != nullptr ? c_.part_objects[p] : 0;
            if (c_.part_places != nullptr && c_.part_places[p] != nullptr) {
                require_given(c_.part_place_counts, "the number of places");
                const auto* const places = reinterpret_cast<const std::array<double, 3>*>(c_.part_places[p]);
                part.at_mm = {places, c_.part_place_counts[p]};
            }
            const double* const placement = c_.parts[p].placement;
            if (std::any_of(placement, placement + 12, [](double entry) { return entry != 0; })) {
                std::copy_n(placement, 12, part.placement.m.begin());
            }
        }
    }

    lamella_source c_{};
    std::vector<Part> parts_;
};

AdaptiveOptions read_adaptive(const lamella_adaptive* given, const Frame& frame) {
    const lamella_adaptive c = read_sized(given);
    require_list(c.ranges, c.range_count, "ranges");
    return {.least_mm = c.least_mm,
            .most_mm = c.most_mm,
            .step_mm = c.step_mm,
            .cusp_mm = c.cusp_mm,
            .deviation_mm = c.deviation_mm,
            .slope_limit_mm = c.slope_limit_mm,
            .most_change_mm = c.most_change_mm,
            .smoothing_mm = c.smoothing_mm,
            .ranges = {as_cpp(c.ranges), c.range_count},
            .frame = frame};
}

}  // namespace
}  // namespace lamella::c

namespace api = lamella::c;

int32_t lamella_slice(lamella_slicer* slicer, const lamella_mesh* mesh, const lamella_options* options,
                      lamella_result** result, lamella_error* error) {
    return api::called(error, [&] {
        api::Kept<lamella_slicer> kept(slicer);
        api::read_options(options, kept->options);
        const lamella::Source from = api::read_mesh(mesh);
        api::fill_result(result, [&](lamella::SliceResult& filled) {
            kept.give(kept->slicer.slice_to(filled, from, kept->options), nullptr);
        });
    });
}

int32_t lamella_slice_to(lamella_slicer* slicer, const lamella_destination* to, const lamella_source* from,
                         const lamella_options* options, const lamella_context* context, lamella_info* info,
                         lamella_error* error) {
    return api::called(error, [&] {
        api::require_initialised(info);
        const lamella_destination where = api::read_destination(to);
        api::Kept<lamella_slicer> kept(slicer);
        const api::Host host(context);
        api::read_options(options, kept->options);
        const api::GivenSource source(from);
        api::fill_destination(where, [&](const lamella::Destination& place, const lamella::SliceResult* result) {
            kept.give(kept->slicer.slice_to(place, source.source(), kept->options, host.context), info, result);
        });
    });
}

int32_t lamella_outline(lamella_slicer* slicer, const lamella_source* from, const lamella_options* options,
                        const lamella_context* context, lamella_info* info, lamella_error* error) {
    return api::called(error, [&] {
        api::require_initialised(info);
        api::Kept<lamella_slicer> kept(slicer);
        const api::Host host(context);
        api::read_options(options, kept->options);
        const api::GivenSource source(from);
        kept.give(kept->slicer.outline(source.source(), kept->options, host.context), info);
    });
}

int32_t lamella_prepare(const lamella_mesh* mesh, const lamella_options* options, const lamella_context* context,
                        lamella_prepared** prepared, lamella_error* error) {
    return api::called(error, [&] {
        api::require_place(prepared, "the prepared mesh", "prepared");
        const api::Host host(context);
        lamella::SliceOptions how;
        api::read_options(options, how);
        auto made = lamella::require(lamella::prepare(api::read_mesh(mesh), how.frame, host.context));
        auto fresh = std::make_unique<lamella_prepared>(lamella_prepared{std::move(made)});
        lamella_prepared_free(std::exchange(*prepared, fresh.release()));
    });
}

uint64_t lamella_prepared_bytes(const lamella_prepared* prepared) {
    return prepared == nullptr ? 0 : prepared->mesh.bytes();
}

double lamella_prepared_grid_mm(const lamella_prepared* prepared) {
    return prepared == nullptr ? 0 : prepared->mesh.frame().grid_mm;
}

void lamella_prepared_free(lamella_prepared* prepared) {
    delete prepared;
}

int32_t lamella_adaptive_layers(const lamella_source* from, const lamella_adaptive* adaptive, const lamella_options* options,
                                const lamella_context* context, lamella_slabs** slabs, lamella_error* error) {
    return api::called(error, [&] {
        api::require_place(slabs, "the slabs", "slabs");
        const api::Host host(context);
        const api::GivenSource source(from);
        lamella::SliceOptions how;
        api::read_options(options, how);
        const lamella::AdaptiveOptions cpp = api::read_adaptive(adaptive, how.frame);
        auto found = lamella::require(lamella::adaptive_layers(source.source(), cpp, host.context));
        auto fresh = std::make_unique<lamella_slabs>(lamella_slabs{std::move(found)});
        lamella_slabs_free(std::exchange(*slabs, fresh.release()));
    });
}

const lamella_slab* lamella_slabs_view(const lamella_slabs* slabs, size_t* count) {
    *count = slabs == nullptr ? 0 : slabs->slabs.size();
    return slabs == nullptr ? nullptr : api::as_c<lamella_slab>(slabs->slabs.data());
}

void lamella_slabs_free(lamella_slabs* slabs) {
    delete slabs;
}

lamella_slicer* lamella_slicer_create(void) {
    return new (std::nothrow) lamella_slicer;
}

uint64_t lamella_slicer_bytes(const lamella_slicer* slicer) {
    return slicer == nullptr ? 0 : slicer->slicer.bytes();
}

void lamella_slicer_trim(lamella_slicer* slicer) {
    if (slicer != nullptr) {
        slicer->slicer.trim();
    }
}

void lamella_slicer_reset(lamella_slicer* slicer) {
    if (slicer != nullptr) {
        slicer->slicer.reset();
    }
}

void lamella_slicer_free(lamella_slicer* slicer) {
    delete slicer;
}

int32_t lamella_slicer_make_ready(lamella_slicer* slicer, uint64_t triangles, const lamella_context* context,
                                  lamella_error* error) {
    return api::called(error, [&] {
        const api::Host host(context);
        lamella::require(api::Kept<lamella_slicer>(slicer)->slicer.make_ready(triangles, host.context));
    });
}

int32_t lamella_region_of(const lamella_path* contours, size_t count, const lamella_options* options, double grid_mm,
                          const lamella_context* context, lamella_result** result, lamella_error* error) {
    return api::called(error, [&] {
        const api::Host host(context);
        lamella::SliceOptions how;
        api::read_options(options, how);
        const auto paths = api::read_paths(contours, count);
        const double step = grid_mm == 0 ? lamella::default_grid_mm : grid_mm;
        api::fill_result(result, [&](lamella::SliceResult& filled) {
            filled = lamella::require(lamella::region_of(paths, how.region, step, host.context));
        });
    });
}

int32_t lamella_assemble(const lamella_segment* segments, size_t count, const lamella_context* context,
                         lamella_result** result, lamella_error* error) {
    return api::called(error, [&] {
        const api::Host host(context);
        api::require_list(segments, count, "segments");
        api::fill_result(result, [&](lamella::SliceResult& filled) {
            filled = lamella::require(lamella::assemble({api::as_cpp(segments), count}, host.context));
        });
    });
}
