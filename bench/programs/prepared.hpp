// A case ready to be timed: its mesh in memory, its answer checked, memory warm.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "catalogue.hpp"
#include "lamella/io.hpp"
#include "lamella/lamella.hpp"

namespace lamella::bench {

class Prepared {
public:
    explicit Prepared(const Case& wanted, std::shared_ptr<const Mesh> mesh);

    const Mesh& mesh() const noexcept { return *mesh_; }
    const LayerPlan& plan() const noexcept { return plan_; }
    SliceOptions options(int threads) const;

    /// The answer of one thread, which all others must equal.
    const SliceSummary& summary() const noexcept { return summary_; }
    std::uint64_t planes() const noexcept { return layer_count_; }
    std::uint64_t contours() const noexcept { return contour_count_; }
    std::uint64_t result_bytes() const noexcept;

    /// Empty if the mesh has the stated numbers and its answer is valid; otherwise the reason.
    const std::string& failure() const noexcept { return failure_; }
    /// Checks slicing on these threads: the answer must have the same hash. Leaves `workspace` and `result` warm.
    std::string check(int threads);

    Workspace workspace;
    SliceResult result;

private:
    std::string check_case(const Case& wanted);
    std::string check_known(const KnownAnswer& known);

    std::shared_ptr<const Mesh> mesh_;
    LayerPlan plan_;
    SliceSummary summary_;
    std::uint64_t contour_count_ = 0;
    std::uint64_t point_count_ = 0;
    std::uint64_t layer_count_ = 0;
    std::uint64_t hash_ = 0;
    std::string failure_;
    std::set<int> checked_;
};

/// Prepares cases on demand. Keeps the last case, and its mesh for the next case with the same mesh.
class Preparer {
public:
    /// Null if the mesh is not available; failure() gives the reason.
    Prepared* get(const Case& wanted);
    const std::string& failure() const noexcept { return failure_; }

private:
    std::string case_name_;
    std::string mesh_name_;
    std::shared_ptr<const Mesh> mesh_;
    std::unique_ptr<Prepared> prepared_;
    std::string failure_;
};

}  // namespace lamella::bench
