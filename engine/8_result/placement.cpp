#include "8_result/placement.hpp"

#include <algorithm>
#include <cassert>
#include <cstring>
#include <numeric>
#include <tuple>

#include "base/memory.hpp"

namespace lamella {

void Placement::begin(std::span<const Band> bands, int threads, std::uint64_t segments, std::span<Point> points,
                      const std::function<void(double)>& progress) {
    bands_ = bands;
    points_ = points;
    progress_ = &progress;
    segments_ = segments;
    segments_placed_ = 0;
    lead_ = 2 * static_cast<std::size_t>(threads);
    head_ = 0;
    point_count_ = 0;
    contour_count_ = 0;
    aborted_ = false;
    placed_.clear();
    placed_.reserve(bands.size());
    for (std::size_t b = 0; b < bands.size(); ++b) {
        placed_.emplace_back(resource_or_default(memory_));
    }
    idle_.clear();
    for (const auto& buffer : buffers_) {
        idle_.push_back(buffer.get());
    }
}

BandOutput* Placement::acquire(std::size_t band) {
    std::unique_lock lock(mutex_);
    head_moved_.wait(lock, [&] { return aborted_ || band <= head_ + lead_; });
    if (aborted_) {
        return nullptr;
    }
    if (idle_.empty()) {
        buffers_.push_back(std::make_unique<BandOutput>(memory_));
        idle_.push_back(buffers_.back().get());
    }
    BandOutput* output = idle_.back();
    idle_.pop_back();
    if (band == head_ && point_count_ <= points_.size()) {
        output->begin(points_.subspan(point_count_));
        return output;
    }
    lock.unlock();
    if (output->buffer.capacity() < bands_[band].segments) {
        output->buffer.resize_discarding(bands_[band].segments);
    }
    output->begin({output->buffer.data(), output->buffer.capacity()});
    return output;
}

void Placement::give_back(BandOutput* output) {
    const std::lock_guard lock(mutex_);
    idle_.push_back(output);
}

void Placement::submit(std::size_t band, BandOutput* output) {
    std::unique_lock lock(mutex_);
    placed_[band].waiting = output;
    if (band != head_) {
        return;
    }
    // Fix the places of all that are ready under the lock, copy outside it; the next head may be placed meanwhile.
    const std::size_t begin = head_;
    while (head_ < placed_.size() && placed_[head_].waiting != nullptr) {
        Placed& placed = placed_[head_];
        placed.first_point = point_count_;
        placed.first_contour = contour_count_;
        placed.contours.swap(placed.waiting->contours);
        placed.layer_contours.swap(placed.waiting->layer_contours);
        placed.closed_gaps.swap(placed.waiting->closed_gaps);
        point_count_ += placed.waiting->point_count;
        contour_count_ += placed.contours.size();
        segments_placed_ += bands_[head_].segments;
        ++head_;
    }
    const std::size_t end = head_;
    if (*progress_) {
        (*progress_)(segments_ == 0 ? 1.0 : static_cast<double>(segments_placed_) / static_cast<double>(segments_));
    }
    lock.unlock();
    head_moved_.notify_all();
    for (std::size_t b = begin; b < end; ++b) {
        copy_points(placed_[b], *placed_[b].waiting);
        const std::lock_guard relock(mutex_);
        idle_.push_back(placed_[b].waiting);
    }
}

void Placement::copy_points(const Placed& placed, const BandOutput& output) const {
    const bool fits = placed.first_point + output.point_count <= points_.size();
    if (fits && output.in_buffer() && output.point_count > 0) {
        std::memcpy(points_.data() + placed.first_point, output.points, output.point_count * sizeof(Point));
    }
}

void Placement::abort() {
    {
        const std::lock_guard lock(mutex_);
        aborted_ = true;
    }
    head_moved_.notify_all();
}

std::uint64_t Placement::closed_gap_count() const noexcept {
    return std::accumulate(placed_.begin(), placed_.end(), std::uint64_t{0},
                           [](std::uint64_t sum, const Placed& placed) { return sum + placed.closed_gaps.size(); });
}

void Placement::write_closed_gaps(std::span<ClosedGap> gaps) const {
    ClosedGap* out = gaps.data();
    for (std::size_t b = 0; b < placed_.size(); ++b) {
        for (const ClosedGap& gap : placed_[b].closed_gaps) {
            *out++ = {bands_[b].first + gap.layer, gap.from, gap.to};
        }
    }
    std::sort(gaps.begin(), gaps.end(), [](const ClosedGap& a, const ClosedGap& b) {
        return std::tie(a.layer, a.from, a.to) < std::tie(b.layer, b.from, b.to);
    });
}

void Placement::write_contours(const Parallel& parallel, std::span<Contour> contours, std::span<Layer> layers) const {
    assert(head_ == bands_.size());
    parallel.run(bands_.size(), [&](std::size_t b, int) {
        const Placed& placed = placed_[b];
        Contour* out = contours.data() + placed.first_contour;
        for (const Contour& contour : placed.contours) {
            *out = contour;
            out->first_point += placed.first_point;
            out->parent += contour.parent < 0 ? 0 : static_cast<std::int64_t>(placed.first_contour);
            ++out;
        }
        std::uint64_t first = placed.first_contour;
        for (PlaneIndex plane = bands_[b].first; plane < bands_[b].last; ++plane) {
            layers[plane].first_contour = first;
            layers[plane].contour_count = placed.layer_contours[plane - bands_[b].first];
            first += layers[plane].contour_count;
        }
    });
}

}  // namespace lamella
