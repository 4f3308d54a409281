// The calls of lamella.h that cut, and that put contours together.
#include <algorithm>
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
            part.mesh = read_mesh(c_.parts[p].mesh);
            const double* const placement = c_.parts[p].placement;
            if (std::any_of(placement, placement + 12, [](double entry) { return entry != 0; })) {
                std::copy_n(placement, 12, part.placement.m.begin());
            }
        }
    }

    lamella_source c_{};
    std::vector<Part> parts_;
};

lamella_sink read_sink(const lamella_sink* given) {
    const lamella_sink c = read_sized(given);
    if (c.take == nullptr) {
        refuse("the sink has no function that takes layers");
    }
    require_choice(c.order, LAMELLA_SINK_ANY, "the sink's order");
    return c;
}

HostArrays read_arrays(const lamella_arrays* given) {
    const lamella_arrays c = read_sized(given);
    require_choice(c.point_type, LAMELLA_I64, "point_type");
    return {.points = c.points,
            .point_capacity = c.point_capacity,
            .point_type = static_cast<Number>(c.point_type),
            .point_stride = c.point_stride,
            .scale = c.scale,
            .contours = detail::span_of(as_cpp(c.contours), c.contour_capacity),
            .layers = detail::span_of(as_cpp(c.layers), c.layer_capacity),
            .stitches = detail::span_of(as_cpp(c.stitches), c.stitches == nullptr ? 0 : c.stitch_capacity),
            .origins = detail::span_of(as_cpp(c.origins), c.origins == nullptr ? 0 : c.point_capacity)};
}

/// A slicer that the program keeps, or one for this call.
class Kept {
public:
    explicit Kept(lamella_slicer* given) : kept_(given) {
        if (kept_ == nullptr) {
            own_ = std::make_unique<lamella_slicer>();
            kept_ = own_.get();
        }
    }
    lamella_slicer* operator->() const noexcept { return kept_; }

    /// What the call found, for the program. The list of layers is that of `result` or else of the slicer; where the program
    /// keeps neither, it ends with the call.
    void give(Result<SliceInfo> found, lamella_info* info, const SliceResult* result = nullptr) {
        kept_->info = require(std::move(found));
        lamella_info c = info_of(result != nullptr ? result->info : kept_->info);
        if (result == nullptr && own_ != nullptr) {
            c.layer_of = nullptr;
            c.layer_of_count = 0;
        }
        write_sized(c, info);
    }

private:
    std::unique_ptr<lamella_slicer> own_;
    lamella_slicer* kept_;
};

void slice_to(Kept& kept, const lamella_destination& to, const Source& from, const Context& context, lamella_info* info) {
    const SliceOptions& options = kept->options;
    if (to.result != nullptr) {
        fill_result(to.result, [&](SliceResult& result) {
            kept.give(kept->slicer.slice_to(result, from, options, context), info, &result);
        });
    } else if (to.sink != nullptr) {
        const lamella_sink c = read_sink(to.sink);
        auto take = [&](const LayerView& layer) noexcept {
            const lamella_layer_view view = view_of(layer);
            c.take(c.object, &view);
        };
        auto begin = [&](const SliceInfo& found) noexcept {
            const lamella_info given = info_of(found);
            c.begin(c.object, &given);
        };
        LayerSink cpp{.take = take, .order = c.order == LAMELLA_SINK_ANY ? SinkOrder::any : SinkOrder::ascending};
        if (c.begin != nullptr) {
            cpp.begin = begin;
        }
        kept.give(kept->slicer.slice_to(cpp, from, options, context), info);
    } else {
        kept.give(kept->slicer.slice_to(read_arrays(to.arrays), from, options, context), info);
    }
}

}  // namespace
}  // namespace lamella::c

namespace api = lamella::c;

int32_t lamella_slice(lamella_slicer* slicer, const lamella_mesh* mesh, const lamella_options* options,
                      lamella_result** result, lamella_error* error) {
    return api::called(error, [&] {
        api::Kept kept(slicer);
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
        const auto where = api::read_sized(to);
        api::require_one({where.result, where.sink, where.arrays}, "result, sink and arrays of a destination");
        api::Kept kept(slicer);
        const api::Host host(context);
        api::read_options(options, kept->options);
        const api::GivenSource source(from);
        api::slice_to(kept, where, source.source(), host.context, info);
    });
}

int32_t lamella_outline(lamella_slicer* slicer, const lamella_source* from, const lamella_options* options,
                        const lamella_context* context, lamella_info* info, lamella_error* error) {
    return api::called(error, [&] {
        api::require_initialised(info);
        api::Kept kept(slicer);
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
        lamella::require(api::Kept(slicer)->slicer.make_ready(triangles, host.context));
    });
}

int32_t lamella_region_of(const lamella_path* contours, size_t count, const lamella_options* options, double grid_mm,
                          const lamella_context* context, lamella_result** result, lamella_error* error) {
    return api::called(error, [&] {
        const api::Host host(context);
        lamella::SliceOptions how;
        api::read_options(options, how);
        api::require_list(contours, count, "contours");
        std::vector<std::span<const lamella::Point>> paths;
        for (std::size_t i = 0; i < count; ++i) {
            paths.emplace_back(api::as_cpp(contours[i].points), contours[i].count);
        }
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
