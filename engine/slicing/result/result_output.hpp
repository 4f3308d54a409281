// A slice that is made for a SliceResult.
#pragma once

#include "slicing/result/slice_output.hpp"

namespace lamella {

class ResultOutput final : public SliceOutput {
public:
    Status admit(const PlaneSet& planes, const Buckets& buckets, const SliceResult& result,
                 std::uint64_t memory_limit) override;
    Status take_bands(const SweepInput& input, FunctionRef<void(BandTarget&)> sweep) override;
    Status finish(const SweepInput& input) override;
};

}  // namespace lamella
