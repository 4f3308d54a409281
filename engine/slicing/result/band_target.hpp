// Where bands go when they are swept.
#pragma once

#include <cstddef>

#include "slicing/result/band_output.hpp"

namespace lamella {

/// Thrown where a band is no longer wanted, since another thread has called BandTarget::abort().
struct BandDropped {};

class BandTarget {
public:
    /// Where `band` puts its output; may wait for bands before it. Null after abort(). Bands must be acquired in ascending
    /// order, each by a thread that then submits it, gives it back or aborts.
    virtual BandOutput* acquire(std::size_t band) = 0;
    /// Takes back an unused output.
    virtual void give_back(std::size_t band) = 0;
    /// The band is done. Throws Stopped where the host wants the call to end.
    virtual void submit(std::size_t band) = 0;
    /// The run has failed: wakes all that wait.
    virtual void abort() = 0;

protected:
    ~BandTarget() = default;
};

}  // namespace lamella
