#include "slicing/workspace.hpp"

#include <algorithm>

#include <unistd.h>

namespace lamella {

namespace detail {

std::uint64_t usual_memory_limit() {
    const auto pages = static_cast<std::uint64_t>(std::max(0L, ::sysconf(_SC_PHYS_PAGES)));
    return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE)) / 2;
}

WorkspaceParts::WorkspaceParts(const Memory* host) : counted(host), usual_limit(usual_memory_limit()) {}

WorkspaceParts& WorkspaceParts::of(Workspace& workspace, const Control& control) {
    std::unique_ptr<WorkspaceParts>& kept = workspace.parts_;
    if (kept == nullptr || kept->counted.host() != control.memory) {
        kept = std::make_unique<WorkspaceParts>(control.memory);
    }
    if (kept->parallel == nullptr || !kept->parallel->serves(control)) {
        kept->parallel = std::make_unique<Parallel>(control);
    }
    kept->parallel->follow(control.stop);
    return *kept;
}

std::size_t WorkspaceParts::bytes() const noexcept {
    const auto made = std::count_if(sweeps.begin(), sweeps.end(), [](const auto& sweep) { return sweep != nullptr; });
    return sizeof(*this) + static_cast<std::size_t>(made) * sizeof(BandSweep) + counted.bytes();
}

void WorkspaceParts::trim() {
    const std::size_t most =
        buckets.segments.empty() ? 0 : *std::max_element(buckets.segments.begin(), buckets.segments.end());
    const bool all = sweeps_made_regions && !last_made_regions;
    for (auto& sweep : sweeps) {
        if (sweep != nullptr && (all || sweep->most_segments() > 2 * most)) {
            sweep.reset();
        }
    }
    sweeps_made_regions = last_made_regions;
    output.placement.trim();
    output.outputs.clear();
    bands.trim();
    buckets.trim();
    planes.trim();
}

}  // namespace detail

Workspace::Workspace() noexcept = default;
Workspace::~Workspace() = default;
Workspace::Workspace(Workspace&&) noexcept = default;
Workspace& Workspace::operator=(Workspace&&) noexcept = default;

std::size_t Workspace::bytes() const noexcept {
    return parts_ == nullptr ? 0 : parts_->bytes();
}

void Workspace::trim() noexcept {
    try {
        if (parts_ != nullptr) {
            parts_->trim();
        }
    } catch (...) {
        reset();  // no memory is left even for less
    }
}

void Workspace::reset() noexcept {
    parts_.reset();
}

}  // namespace lamella
