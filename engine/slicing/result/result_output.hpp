// A slice that is made for a SliceResult.
#pragma once

#include "slicing/result/slice_output.hpp"

namespace lamella {

class ResultOutput final : public SliceOutput {
public:
    explicit ResultOutput(bool origins) noexcept : point_bytes_(sizeof(Point) + (origins ? sizeof(PointOrigin) : 0)) {}

    Status admit(const PlaneSet& planes, const Buckets& buckets, const SliceResult& result,
                 std::uint64_t memory_limit) override;
    Status take_bands(const SweepInput& input, FunctionRef<void(BandTarget&)> sweep) override;
    Status finish(const SweepInput& input) override;

private:
    std::uint64_t point_bytes_;  // of a point and its origin
};

}  // namespace lamella
