#include "stages.hpp"

#include <limits>

#include "base/guard.hpp"

namespace lamella::bench {

Stages::Stages(const MeshView& mesh, const LayerPlan& plan, int threads)
    : plan_(plan), parallel_(Control{.threads = threads}) {
    narrow_to(mesh);
    for (int i = 0; i < threads; ++i) {
        workers_.push_back(std::make_unique<Worker>());
    }
}

Status Stages::measure() {
    return guarded([&]() -> Status {
        bounds_ = source_->measure(0);
        unit_mm_ = require(choose_unit(bounds_, 0)).mm;
        return {};
    });
}

Status Stages::plan_planes() {
    return planes_.build(plan_, bounds_, unit_mm_, source_->info.number, std::numeric_limits<std::uint64_t>::max());
}

void Stages::count() {
    source_->count(unit_mm_);
}

void Stages::scatter() {
    reaching_ = source_->scatter(bands_.band_end, bands_.reaching.span(), false);
}

void Stages::look_at_bounds() {
    (void)source_->measure(0);
}

void Stages::cut_bands() {
    cut_bands_for(parallel_.threads());
}

void Stages::cut_bands_for(int threads) {
    bands_.cut(buckets_, planes_.size(), 0, threads);
}

void Stages::find_seeds() {
    bands_.find_seeds(planes_.size(), reaching_);
}

Status Stages::prepare() {
    if (Status status = measure(); !status) {
        return status;
    }
    if (Status status = plan_planes(); !status) {
        return status;
    }
    count();
    cut_bands();
    scatter();
    find_seeds();
    return {};
}

void Stages::sweep_on(Worker& worker, std::size_t band, ContourForm form) {
    worker.output.begin({worker.output.buffer.data(), worker.output.buffer.capacity()});
    (void)worker.sweep.run(bands_.bands[band], bands_.seeds_of(band), buckets_, planes_, form, {}, worker.output);
    worker.contours += worker.output.contours.size();
    worker.points += worker.output.point_count;
}

void Stages::sweep(ContourForm form) {
    for (const auto& worker : workers_) {
        worker->contours = 0;
        worker->points = 0;
    }
    parallel_.run(bands_.bands.size(),
                  [&](std::size_t band, int worker) { sweep_on(*workers_[static_cast<std::size_t>(worker)], band, form); });
}

void Stages::sweep_band(std::size_t band, ContourForm form) {
    sweep_on(*workers_.front(), band, form);
}

std::uint64_t Stages::swept_contours() const noexcept {
    std::uint64_t all = 0;
    for (const auto& worker : workers_) {
        all += worker->contours;
    }
    return all;
}

std::uint64_t Stages::swept_points() const noexcept {
    std::uint64_t all = 0;
    for (const auto& worker : workers_) {
        all += worker->points;
    }
    return all;
}

}  // namespace lamella::bench
