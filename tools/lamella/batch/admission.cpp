#include "batch/admission.hpp"

#include <algorithm>

namespace lamella::cli::batch {

namespace {

constexpr double several_threads_from = 3e6;  ///< triangles: below, a second thread earns less than another mesh would

}  // namespace

void Admission::add(std::size_t item, const MeshEstimate& estimate, std::optional<int> threads) {
    if (entries_.size() <= item) {
        entries_.resize(item + 1);
    }
    entries_[item].estimate = estimate;
    entries_[item].asked = threads;
    waiting_.push_back(item);
}

void Admission::sort() {
    std::stable_sort(waiting_.begin(), waiting_.end(), [this](std::size_t a, std::size_t b) {
        return entries_[a].estimate.bytes > entries_[b].estimate.bytes;
    });
}

void Admission::add_again(std::size_t item, bool alone) {
    entries_[item].alone = alone;
    waiting_.push_back(item);
}

double Admission::need_of(std::size_t item) const {
    const MeshEstimate& estimate = entries_[item].estimate;
    return process_bytes + (estimate.bytes - process_bytes) * factor_;
}

bool Admission::fits(const Entry& entry, double need) const {
    if (running_ == 0) {
        return true;
    }
    return !alone_runs_ && !entry.alone && used_threads_ < jobs_ && used_bytes_ + need <= memory_;
}

/// What is left where only few such meshes are left or fit into memory at once; else one for a small mesh.
int Admission::threads_for(const Entry& entry, double need) const {
    if (entry.asked && *entry.asked > 0) {
        return *entry.asked;
    }
    const int left = jobs_ - used_threads_;
    if (entry.alone || need > memory_) {
        return left;
    }
    const auto at_once = static_cast<int>(std::min<double>(jobs_, memory_ / need));
    const int beside = std::max(1, std::min(at_once, static_cast<int>(std::min<std::size_t>(
                                                         running_ + waiting_.size(), static_cast<std::size_t>(jobs_)))));
    const int share = std::max(1, jobs_ / beside);
    const int by_size = entry.estimate.triangles >= several_threads_from ? share : std::min(share, 2);
    return std::clamp(by_size, 1, left);
}

std::optional<Admitted> Admission::next() {
    for (auto at = waiting_.begin(); at != waiting_.end(); ++at) {
        Entry& entry = entries_[*at];
        const double need = need_of(*at);
        if (!fits(entry, need)) {
            continue;
        }
        const bool alone = entry.alone || need > memory_;
        const Admitted admitted{*at, threads_for(entry, need), alone};
        entry.threads = admitted.threads;
        entry.bytes = need;
        used_threads_ += entry.threads;
        used_bytes_ += need;
        ++running_;
        alone_runs_ = alone;
        waiting_.erase(at);
        return admitted;
    }
    return std::nullopt;
}

void Admission::ended(std::size_t item, std::uint64_t peak_bytes) {
    const Entry& entry = entries_[item];
    used_threads_ -= entry.threads;
    used_bytes_ -= entry.bytes;
    --running_;
    alone_runs_ = false;
    constexpr double worth_learning = 64e6;
    const double over = static_cast<double>(peak_bytes) - process_bytes;
    if (over > worth_learning && !entry.alone) {
        constexpr double most = 8;
        factor_ = std::clamp(over / std::max(worth_learning / most, entry.estimate.bytes - process_bytes), factor_, most);
    }
}

}  // namespace lamella::cli::batch
