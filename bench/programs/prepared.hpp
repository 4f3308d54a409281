// A case made ready: its mesh in memory, its answer checked, memory warm.
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
#include "stages.hpp"

namespace lamella::bench {

class Prepared {
public:
    explicit Prepared(const Case& wanted, std::shared_ptr<const Mesh> mesh);

    const Mesh& mesh() const noexcept { return *mesh_; }
    const LayerPlan& plan() const noexcept { return plan_; }
    SliceOptions options(ContourForm form, int threads) const;

    /// The answer of one thread, swept form, that all others must equal.
    const SliceSummary& summary() const noexcept { return summary_; }
    std::uint64_t planes() const noexcept { return layer_count_; }
    std::uint64_t contours() const noexcept { return contour_count_; }
    std::uint64_t points() const noexcept { return point_count_; }
    std::uint64_t result_bytes() const noexcept;

    /// Empty if the mesh is what it is stated to be and its answer is valid; else why not.
    const std::string& failure() const noexcept { return failure_; }
    /// The same for slicing so: the answer must have the same hash. Leaves `workspace` and `result` warm.
    std::string check(ContourForm form, int threads);

    Workspace workspace;
    SliceResult result;

    /// The stages for `threads`, prepared; null if they fail.
    Stages* stages(int threads);

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
    std::set<std::pair<ContourForm, int>> checked_;
    std::unique_ptr<Stages> stages_;
    int stages_threads_ = 0;
};

/// Prepares cases on demand and keeps the last, and its mesh for the next case that has the same.
class Preparer {
public:
    /// Null, with `failure`, if the mesh cannot be had.
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
