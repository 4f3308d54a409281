#include "slicing/handover/layer_handout.hpp"

#include <algorithm>
#include <span>
#include <tuple>

#include "base/parallel.hpp"

namespace lamella {

namespace {

/// Walks through the layers of an output.
class LayerCursor {
public:
    LayerCursor(BandOutput& output, std::uint64_t first_index, const StopCheck& stop)
        : output_(output), first_index_(first_index + output.first_layer) {
        pace_.follow(stop);
    }

    /// The next layer's contours, points and gaps, which then count from the layer's own first.
    LayerView next() {
        const std::size_t layer = layer_++;
        LayerView view;
        view.index = first_index_ + layer;
        const std::span<Contour> contours =
            std::span<Contour>(output_.contours).subspan(first_contour_, output_.layer_contours[layer]);
        std::uint64_t points = 0;
        for (Contour& contour : contours) {
            contour.first_point -= first_point_;
            contour.parent -= contour.parent < 0 ? 0 : static_cast<std::int64_t>(first_contour_);
            points += contour.point_count;
        }
        view.contours = contours;
        view.points = {output_.points + first_point_, points};
        if (output_.with_origins) {
            view.origins = {output_.origins + first_point_, points};
        }
        view.closed_gaps = take_gaps(layer, view.index);
        first_contour_ += contours.size();
        first_point_ += points;
        return view;
    }

private:
    std::span<const ClosedGap> take_gaps(std::size_t layer, std::uint64_t index) {
        const std::size_t first = first_gap_;
        while (first_gap_ < output_.closed_gaps.size() && output_.closed_gaps[first_gap_].layer == layer) {
            output_.closed_gaps[first_gap_++].layer = index;
        }
        const std::span<ClosedGap> gaps = std::span<ClosedGap>(output_.closed_gaps).subspan(first, first_gap_ - first);
        std::sort(gaps.begin(), gaps.end(),
                  [](const ClosedGap& a, const ClosedGap& b) { return std::tie(a.from, a.to) < std::tie(b.from, b.to); });
        return gaps;
    }

    BandOutput& output_;
    std::uint64_t first_index_;
    std::size_t layer_ = 0;
    std::size_t first_contour_ = 0;
    std::uint64_t first_point_ = 0;
    std::size_t first_gap_ = 0;
    StopPace pace_;
};

}  // namespace

void HandedOver::add(const HandedOver& other) noexcept {
    layers += other.layers;
    contours += other.contours;
    points += other.points;
    closed_gaps += other.closed_gaps;
    emptied += other.emptied;
    counts.add(other.counts);
}

void LayerHandout::hand_over(BandOutput& output, HandedOver& total) const {
    LayerCursor cursor(output, first_index_, parallel_.stop());
    for (std::size_t i = 0; i < output.layer_contours.size(); ++i) {
        LayerView view = cursor.next();
        view.layer = describe_layer(planes_, buckets_, static_cast<PlaneIndex>(output.first_layer + i));
        view.layer.contour_count = view.contours.size();
        view.unit_mm = unit_mm_;
        sink_.take(sink_.context, view);
        total.closed_gaps += view.closed_gaps.size();
        total.emptied += view.layer.segments > 0 && view.contours.empty() ? 1 : 0;
        parallel_.ask_host();  // so that a sink which ends the call gets no layer more
    }
    total.layers += output.layer_contours.size();
    total.contours += output.contours.size();
    total.points += output.point_count;
    output.drop_layers();
}

}  // namespace lamella
