// Stage 7, where asked for: what is inside by a fill rule, where contours overlap, nest the same way or run backwards. The
// one place that includes the clipping library.
#pragma once

#include <functional>
#include <memory>
#include <span>

#include "base/parallel.hpp"
#include "lamella/grid.hpp"
#include "lamella/result.hpp"

namespace lamella {

/// The region that closed contours of one plane bound by a rule. One per thread.
class Fill {
public:
    Fill();
    ~Fill();
    Fill(const Fill&) = delete;
    Fill& operator=(const Fill&) = delete;

    /// Forgets all contours.
    void clear();
    /// Adds a closed contour as it was walked. What comes out can depend on the order of the calls and on where each
    /// contour starts, so both must be canonical.
    void add(std::span<const Point> before, std::span<const Point> after);
    /// Calls take(contour) for each closed contour of the region, in no particular order, solid on the left.
    /// Throws std::bad_alloc. O((q + c) log q) for q points and c crossings as a rule; the library promises nothing.
    void fill(FillRule rule, FunctionRef<void(std::span<const Point>)> take);

private:
    struct Clipping;
    std::unique_ptr<Clipping> clipping_;
};

}  // namespace lamella
