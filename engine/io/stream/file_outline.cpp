#include "io/stream/file_outline.hpp"

#include <algorithm>

#include "slicing/repair/gaps.hpp"

namespace lamella {

FileOutline outline_of(const SliceOptions& slicing, const SharedFrame& frame, const PlaneSet& planes) {
    FileOutline outline{SliceResult(slicing.control.memory), planes.size()};
    SliceResult& facts = outline.facts;
    facts.layer_of = layers_of_listed(planes, slicing.control.memory);
    facts.first_layer = planes.first_kept();
    facts.all_layers = planes.planned();
    facts.region = slicing.region;
    facts.close_gaps_mm = gap_length_mm(slicing.close_gaps_mm, frame.bounds);
    facts.gap_sense = slicing.gap_sense;
    facts.unit_mm = frame.unit.mm;
    facts.frame = slicing.transform;
    facts.plan = slicing.plan;
    std::copy_n(frame.bounds.min_mm, 3, facts.summary.min_mm);
    std::copy_n(frame.bounds.max_mm, 3, facts.summary.max_mm);
    return outline;
}

Array<std::uint64_t> layers_of_listed(const PlaneSet& planes, const Memory* memory) {
    const auto& listed = planes.plane_of_listed();
    Array<std::uint64_t> layers(memory);
    layers.resize_discarding(listed.size());
    std::copy(listed.begin(), listed.end(), layers.begin());
    return layers;
}

}  // namespace lamella
