// A set's contours in the layers that count for a layer of the answer, and the region that they bound.
#pragma once

#include <cstdint>
#include <span>

#include "base/function_ref.hpp"
#include "base/vector.hpp"
#include "base/worker.hpp"
#include "lamella/overlay.hpp"
#include "slicing/layer/ring_reader.hpp"
#include "slicing/nesting/nest.hpp"
#include "slicing/regions/regions.hpp"

namespace lamella {

/// Layer after layer; scratch is kept. One per thread and set. Paths stay until the next call. All calls throw
/// std::bad_alloc.
class SetReader {
public:
    explicit SetReader(Worker& worker) noexcept : worker_(worker) {}

    /// True if the set's contours in a layer are a region as they are: with the solid on their left, and across nothing.
    static bool is_region(const LayerSet& set) noexcept;
    /// The contours that bound something, in no order.
    std::span<const Path> list_contours(const LayerSet& set, std::uint64_t n);
    /// Those of the region, grown as the set says. Path::hole tells which side of a contour is solid, whichever way it runs.
    std::span<const Path> list_region(const LayerSet& set, std::uint64_t n, double grid_mm, Nester& nester);
    /// All contours as lines: those of the host, of which one may have no points, open, those of layers as they are. Of
    /// items only points and NestItem::closed are set.
    std::span<const Path> list_lines(const LayerSet& set, std::uint64_t n);

private:
    void list_host(const ContourSet& given, bool closed);
    void for_each_contour(const LayerSet& set, std::uint64_t n, FunctionRef<void(const LayerView&, const Contour&)> take);

    Worker& worker_;
    Vector<Path> listed_{worker_.memory()};
    Vector<Path> of_host_{worker_.memory()};  // the same as the host has them
    GivenContours given_{worker_};
    Regions regions_{worker_};
};

/// The order of paths, whatever they were made of.
bool is_before(const Path& a, const Path& b) noexcept;

}  // namespace lamella
