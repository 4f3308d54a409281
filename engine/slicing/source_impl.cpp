#include "slicing/source_impl.hpp"

#include <new>
#include <string>

#include "base/guard.hpp"
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
    Collecting(const Memory* memory, std::uint64_t limit)
        : limit_(limit), layers_(memory), contours_(memory), points_(memory), stitches_(memory) {}

    void take(const LayerView& view) noexcept {
        try {
            add(view);
        } catch (const std::bad_alloc&) {
            is_full_ = true;
        }
    }
    /// Throws where some layer did not fit.
    void check() const {
        if (is_too_large_) {
            throw Refused{{ErrorCode::result_too_large,
                           "the result exceeds the memory limit of " + std::to_string(limit_) + " bytes"}};
        }
        if (is_full_) {
            throw std::bad_alloc();
        }
    }

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
        const std::uint64_t bytes = (layers_.size() + 1) * sizeof(Layer) + contours_.size() * sizeof(Contour) +
                                    (points_.size() + view.points.size()) * sizeof(Point);
        is_full_ = is_too_large_ = bytes > limit_;
        if (is_full_) {
            return;
        }
        append(points_, view.points);
        append(stitches_, view.stitches);
        layers_.push_back(layer);
    }

    std::uint64_t limit_;
    Vector<Layer> layers_;
    Vector<Contour> contours_;
    Vector<Point> points_;
    Vector<Stitch> stitches_;
    bool is_full_ = false;
    bool is_too_large_ = false;
};

}  // namespace

void collect_layers(const detail::SourceImpl& source, const SliceCall& call, SliceResult& result) {
    Collecting collecting(call.context.memory, call.memory_limit());
    auto take = [&](const LayerView& layer) noexcept { collecting.take(layer); };
    const LayerSink sink{.take = take};
    SinkTarget target(sink);
    source.slice(target, call, result.info);
    collecting.check();
    collecting.move_to(result);
}

}  // namespace lamella
