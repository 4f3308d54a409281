#include "stages.hpp"

#include <limits>

namespace lamella::bench {

Stages::Stages(const MeshView& mesh, const LayerPlan& plan, int threads)
    : mesh_(mesh), plan_(plan), parallel_(Control{.threads = threads}) {
    for (int i = 0; i < threads; ++i) {
        workers_.push_back(std::make_unique<Worker>());
    }
}

Status Stages::measure() {
    const Result<Bounds> bounds = measure_bounds(mesh_, Transform{}, 0, parallel_, blocks_);
    if (!bounds) {
        return bounds.error();
    }
    bounds_ = *bounds;
    const Result<ChosenUnit> unit = choose_unit(bounds_, 0);
    if (!unit) {
        return unit.error();
    }
    unit_mm_ = unit->mm;
    return {};
}

Status Stages::plan_planes() {
    return planes_.build(plan_, bounds_, unit_mm_, mesh_.coordinate_type, std::numeric_limits<std::uint64_t>::max());
}

void Stages::count() {
    count_crossings(mesh_, Transform{}, unit_mm_, blocks_, planes_, parallel_, buckets_);
}

void Stages::scatter() {
    reaching_ = scatter_triangles(mesh_, Transform{}, unit_mm_, planes_, bands_.band_end, parallel_, buckets_,
                                  bands_.reaching.span());
}

void Stages::look_at_bounds() {
    (void)measure_bounds(mesh_, Transform{}, 0, parallel_, blocks_).ok();
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
