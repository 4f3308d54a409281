#include "slicing/source_impl.hpp"

#include <new>

#include "base/vector.hpp"

namespace lamella {

namespace {

template <class T>
void append(Vector<T>& to, std::span<const T> more) {
    to.insert(to.end(), more.begin(), more.end());
}

template <class T>
void copy_to(Array<T>& to, const Vector<T>& from) {
    to.resize_discarding(from.size());
    std::copy(from.begin(), from.end(), to.data());
}

/// Layers come in ascending order, and count contours and points from their own first.
class Collecting {
public:
    explicit Collecting(const Memory* memory) : layers_(memory), contours_(memory), points_(memory), stitches_(memory) {}

    void take(const LayerView& view) noexcept {
        try {
            add(view);
        } catch (const std::bad_alloc&) {
            is_full_ = true;
        }
    }
    bool is_full() const noexcept { return is_full_; }

    void move_to(SliceResult& result) const {
        copy_to(result.layers, layers_);
        copy_to(result.contours, contours_);
        copy_to(result.points, points_);
        copy_to(result.stitches, stitches_);
        result.origins.set_size(0);
    }

private:
    void add(const LayerView& view) {
        if (is_full_) {
            return;
        }
        Layer layer = view;
        layer.first_contour = contours_.size();
        const std::uint64_t first_point = points_.size();
        for (Contour contour : view.contours) {
            contour.first_point += first_point - view.first_point;
            contour.parent += contour.parent < 0 ? 0 : static_cast<std::int64_t>(layer.first_contour - view.first_contour);
            contours_.push_back(contour);
        }
        append(points_, view.points);
        append(stitches_, view.stitches);
        layers_.push_back(layer);
    }

    Vector<Layer> layers_;
    Vector<Contour> contours_;
    Vector<Point> points_;
    Vector<Stitch> stitches_;
    bool is_full_ = false;
};

}  // namespace

void collect_layers(const detail::SourceImpl& source, const SliceCall& call, SliceResult& result) {
    Collecting collecting(call.context.memory);
    auto take = [&](const LayerView& layer) noexcept { collecting.take(layer); };
    const LayerSink sink{.take = take};
    SinkTarget target(sink);
    source.slice(target, call, result.info);
    if (collecting.is_full()) {
        throw std::bad_alloc();
    }
    collecting.move_to(result);
}

}  // namespace lamella
