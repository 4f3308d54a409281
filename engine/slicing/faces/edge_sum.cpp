#include "slicing/faces/edge_sum.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <limits>
#include <new>

namespace lamella {

namespace {

constexpr std::size_t look_up_work = 8;  // as StopPace counts it: an entry waits for memory
constexpr std::size_t least_places = 64;
constexpr std::uint32_t taken = std::numeric_limits<std::uint32_t>::max();

/// The same on every platform; the high bits are well mixed.
std::uint64_t hash_of(Point low, Point high) noexcept {
    std::uint64_t h = nesting::key_of(low) * 0x9E3779B97F4A7C15U + nesting::key_of(high) * 0xC2B2AE3D27D4EB4FU;
    h ^= h >> 32;
    return h * 0xD6E8FEB86659FD93U;
}

}  // namespace

void EdgeSum::begin(std::size_t edges) {
    used_ = 0;
    table_.clear();
    resize(std::bit_ceil(std::max(least_places, edges + edges / 2)));
}

void EdgeSum::resize(std::size_t size) {
    table_.reserve(size);
    worker_.in_stretches(table_.size(), size, 1, [&](std::size_t, std::size_t end) { table_.resize(end); });
    shift_ = 64 - std::countr_zero(size);
}

EdgeSum::Entry& EdgeSum::place_of(Point low, Point high) noexcept {
    const std::size_t mask = table_.size() - 1;
    std::size_t i = hash_of(low, high) >> shift_;
    while (table_[i].low != table_[i].high && !(table_[i].low == low && table_[i].high == high)) {
        i = (i + 1) & mask;
    }
    return table_[i];
}

void EdgeSum::add(std::span<const Point> ring) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
        add(ring[i], ring[i + 1 < ring.size() ? i + 1 : 0]);
    }
}

void EdgeSum::add(Point from, Point to) {
    if (from == to) {
        return;
    }
    const bool ascends = from < to;
    Entry& entry = place_of(ascends ? from : to, ascends ? to : from);
    if (entry.low == entry.high) {
        entry = {ascends ? from : to, ascends ? to : from, 0};
        ++used_;
    }
    entry.times += ascends ? 1 : -1;
    worker_.spend(look_up_work);
    if (used_ > table_.size() / 4 * 3) {
        grow();
    }
}

void EdgeSum::grow() {
    Vector<Entry> before(table_.get_allocator());
    before.swap(table_);
    resize(2 * before.size());
    worker_.in_stretches(0, before.size(), look_up_work, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (before[i].low != before[i].high) {
                place_of(before[i].low, before[i].high) = before[i];
            }
        }
    });
}

void EdgeSum::collect() {
    edges_.clear();
    worker_.in_stretches(0, table_.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Entry& entry = table_[i];
            const DirectedEdge edge =
                entry.times > 0 ? DirectedEdge{entry.low, entry.high} : DirectedEdge{entry.high, entry.low};
            edges_.insert(edges_.end(), static_cast<std::size_t>(entry.times > 0 ? entry.times : -entry.times), edge);
        }
    });
    if (edges_.size() >= taken) {
        throw std::bad_alloc();
    }
}

void EdgeSum::sort_ends() {
    leaving_.clear();
    entering_.clear();
    for (std::size_t i = 0; i < edges_.size(); ++i) {
        const auto number = static_cast<std::uint32_t>(i);
        leaving_.push_back({nesting::key_of(edges_[i].from), number});
        entering_.push_back({nesting::key_of(edges_[i].to), number});
        worker_.spend(2);
    }
    nesting::sort_keys(leaving_, spare_, worker_);
    nesting::sort_keys(entering_, spare_, worker_);
    next_.resize(edges_.size());
    for (std::size_t i = 0; i < edges_.size(); ++i) {
        assert(leaving_[i].key == entering_[i].key);
        next_[entering_[i].index] = leaving_[i].index;
        worker_.spend(look_up_work);
    }
}

void EdgeSum::link() {
    collect();
    sort_ends();
    points_.clear();
    ring_ends_.clear();
    for (const nesting::SortKey& first : leaving_) {
        if (next_[first.index] == taken) {
            continue;
        }
        for (std::uint32_t edge = first.index; next_[edge] != taken;) {
            points_.push_back(edges_[edge].from);
            const std::uint32_t next = next_[edge];
            next_[edge] = taken;
            edge = next;
            worker_.spend(look_up_work);
        }
        ring_ends_.push_back(points_.size());
    }
}

}  // namespace lamella
