// Where the segments at a slot come from.
#pragma once

#include "lamella/result.hpp"

namespace lamella {

/// By port: the origin of the segment there, as its facet runs.
struct SlotOrigins {
    PointOrigin by_port[2];
};

}  // namespace lamella
