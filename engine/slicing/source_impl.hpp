// A source of another room, such as a file, as a Slicer sees it.
#pragma once

#include "lamella/result.hpp"
#include "slicing/handover/sink_target.hpp"
#include "slicing/slice_layers.hpp"

namespace lamella::detail {

/// The functions throw Refused, Stopped, std::bad_alloc.
class SourceImpl {
public:
    virtual ~SourceImpl() = default;
    /// All layers to the sink, in its order. SinkTarget::announce() is called before the first. Fills in `info`.
    virtual void slice(SinkTarget& target, const SliceCall& call, SliceInfo& info) const = 0;
    /// See Slicer::outline().
    virtual void outline(const SliceCall& call, SliceInfo& info) const = 0;
};

}  // namespace lamella::detail
