// Pairs of edges that come near one another, where boxes say little: edges that lie side by side aslant, or contours in one
// another, whose boxes all meet.
//
//      :        __..--:      A slab: all between two x. Edges that reach from side to side in one order at both are its
//      :__..--''      :      stairs, here three. Each other edge finds by bisection those that it meets: `a` crosses
//      :\       __..--:      two of them; `b`, which ends within the slab, none. Then the slab is halved, and both
//      :_\..--''      :      halves are searched without the stairs.
//      :  \a    __..--:
//      :__.\--''      :
//      :    \  -b-    :
//
// A pair that is kept for the halves has met a stair: O(e log^2 e + c) for e edges and c pairs (Balaban 1995, the simpler of
// his algorithms). Slower than the search by boxes where boxes lie apart.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/function_ref.hpp"
#include "base/vector.hpp"
#include "base/worker.hpp"
#include "slicing/edges/edge_runs.hpp"

namespace lamella {

/// One layer after another; scratch is kept. One per thread.
class SlabSearch {
public:
    /// Edge i of path a and edge j of path b, as PairSearch::find() numbers them.
    using Meet = FunctionRef<void(std::uint32_t a, std::size_t i, std::uint32_t b, std::size_t j)>;

    explicit SlabSearch(Worker& worker) noexcept : worker_(worker) {}

    /// Calls `meet`, once or a few times and in no order, for each two edges of different runs that come within the runs'
    /// margin of each other on both axes, and for some that lie farther apart. Throws std::bad_alloc.
    void find(const EdgeRuns& runs, Meet meet);

private:
    /// What is so near an edge: between two lines.
    struct Strip {
        double left;
        double right;
        double low;  ///< y at the left
        double high;
        double slope;
        std::uint32_t run;
        std::size_t edge;
    };
    /// A strip within a slab: its ends there, as shares of the slab's width, and y at both.
    struct Piece {
        double at[2];
        double low[2];
        double high[2];
        std::uint32_t strip;

        bool spans() const noexcept { return at[0] == 0 && at[1] == 1; }
    };
    /// The hull of pieces which all meet; it lies above that of the stair before.
    struct Stair {
        Piece hull;
        std::size_t begin;  ///< of its pieces in stair_pieces_
        std::size_t end;
    };

    static Strip strip_of(Point a, Point b, double margin) noexcept;
    void search(std::size_t begin, double left, double right);
    bool list_pieces(std::span<const std::uint32_t> strips, double left, double right);
    void compare_all(std::span<const Piece> pieces) const;
    std::size_t take_stairs(std::span<Piece> spanning);
    std::span<const Piece> pieces_of(const Stair& stair) const noexcept {
        return std::span(stair_pieces_).subspan(stair.begin, stair.end - stair.begin);
    }
    bool joins_last(const Piece& piece) const noexcept;
    void meet_stairs(const Piece& piece) const;
    void meet(const Piece& a, const Piece& b) const;

    Worker& worker_;
    const EdgeRuns* runs_ = nullptr;
    const Meet* meet_ = nullptr;
    Vector<Strip> strips_{worker_.memory()};
    Vector<std::uint32_t> listed_{worker_.memory()};  // strips of a slab, after those of the slabs that it is a part of
    Vector<Piece> pieces_{worker_.memory()};
    Vector<Stair> stairs_{worker_.memory()};
    Vector<Piece> stair_pieces_{worker_.memory()};
    Vector<double> ends_{worker_.memory()};  // x, within a slab
};

}  // namespace lamella
