// A case ready to be timed: its mesh in memory, its answer checked, memory warm. What fails throws std::runtime_error.
#pragma once

#include <cstdint>
#include <memory>
#include <set>
#include <string>

#include "catalogue.hpp"
#include "lamella/io.hpp"
#include "lamella/lamella.hpp"
#include "timing.hpp"

namespace lamella::bench {

/// Bytes read plus bytes written per second when `threads` threads copy warm memory much larger than the caches, to which
/// the `floor` counters refer. The median of several copies, measured once for each run and thread count.
double copy_bandwidth(int threads);

/// Sets the number of bytes that later calls copy.
void set_copy_size(std::size_t bytes);

class Prepared {
public:
    /// Throws unless the mesh has the stated numbers and its answer is valid.
    explicit Prepared(const Case& wanted, std::shared_ptr<const Mesh> mesh);

    const Mesh& mesh() const noexcept { return *mesh_; }
    const Plan& plan() const noexcept { return plan_; }
    /// Slices into `result`: `from`, or the case's mesh.
    SliceInfo slice(const Source& from, int threads) {
        return checked(slice_tuned(slicer, result, from, plan_.options, plan_.tuning, {.threads = threads}));
    }
    SliceInfo slice(int threads) { return slice(mesh_->view(), threads); }

    /// The answer of one thread, which all others must equal.
    const SliceInfo& info() const noexcept { return info_; }
    std::uint64_t result_bytes() const noexcept {
        return info_.layers * sizeof(Layer) + info_.contours * sizeof(Contour) + info_.points * sizeof(Point);
    }

    /// Throws unless slicing on these threads gives the same hash. Leaves `slicer` and `result` warm.
    void check(int threads);

    Slicer slicer;
    SliceResult result;

private:
    void check_known(const KnownAnswer& known);

    std::shared_ptr<const Mesh> mesh_;
    Plan plan_;
    SliceInfo info_;
    std::uint64_t hash_ = 0;
    std::set<int> checked_;
};

/// Prepares cases on demand. Keeps the last case, and its mesh for the next case with the same mesh.
class Preparer {
public:
    Prepared& get(const Case& wanted);

private:
    std::string case_name_;
    std::string mesh_name_;
    std::shared_ptr<const Mesh> mesh_;
    std::unique_ptr<Prepared> prepared_;
};

}  // namespace lamella::bench
