// Where the calls of lamella.h that make layers put them.
#include "lamella/destination.hpp"

#include "c/call.hpp"

namespace lamella::c {

namespace {

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

void fill_sink(const lamella_sink& c, FunctionRef<void(const Destination&, const SliceResult*)> fill) {
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
    fill(cpp, nullptr);
}

}  // namespace

lamella_destination read_destination(const lamella_destination* given) {
    const lamella_destination c = read_sized(given);
    require_one({c.result, c.sink, c.arrays}, "result, sink and arrays of a destination");
    return c;
}

void fill_destination(const lamella_destination& to, FunctionRef<void(const Destination&, const SliceResult*)> fill) {
    if (to.result != nullptr) {
        fill_result(to.result, [&](SliceResult& result) { fill(result, &result); });
    } else if (to.sink != nullptr) {
        fill_sink(read_sink(to.sink), fill);
    } else {
        fill(read_arrays(to.arrays), nullptr);
    }
}

}  // namespace lamella::c
