// A slice that is made for a SliceResult.
#pragma once

#include "slicing/result/slice_output.hpp"

namespace lamella {

class ResultOutput final : public SliceOutput {
public:
    /// Results of more than `memory_limit` bytes are refused.
    explicit ResultOutput(std::uint64_t memory_limit) : memory_limit_(memory_limit) {}

    Status admit(const PlaneSet& planes, const Buckets& buckets, const SliceResult& result) override;
    Status take_bands(const SweepInput& input, FunctionRef<void(BandTarget&)> sweep) override;
    Status finish(const SweepInput& input) override;

private:
    std::uint64_t memory_limit_;
};

}  // namespace lamella
