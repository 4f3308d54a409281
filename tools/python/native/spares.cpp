#include "spares.hpp"

#include <utility>

namespace lamella::python {

namespace {

std::size_t bytes_of(const SliceResult& result) noexcept {
    return result.points.capacity() * sizeof(Point) + result.origins.capacity() * sizeof(PointOrigin) +
           result.contours.capacity() * sizeof(Contour) + result.layers.capacity() * sizeof(Layer);
}

}  // namespace

Spares& Spares::all() noexcept {
    static Spares& spares = []() -> Spares& {
        auto* const made = new Spares;
        made->workspaces_.reserve(most_workspaces);
        return *made;
    }();
    return spares;
}

Workspace Spares::take_workspace() noexcept {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock || workspaces_.empty()) {
        return {};
    }
    Workspace taken = std::move(workspaces_.back());
    workspaces_.pop_back();
    return taken;
}

SliceResult Spares::take_result() noexcept {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    return lock ? std::exchange(result_, SliceResult{}) : SliceResult{};
}

void Spares::give(Workspace&& workspace) noexcept {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (lock && workspaces_.size() < most_workspaces && workspace.bytes() <= most_bytes) {
        workspaces_.push_back(std::move(workspace));
    }
}

void Spares::give(SliceResult&& result) noexcept {
    const std::size_t bytes = bytes_of(result);
    if (bytes == 0 || bytes > most_bytes) {
        return;
    }
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (lock && bytes > bytes_of(result_)) {
        result_ = std::move(result);
    }
}

}  // namespace lamella::python
