#include "slicing/buckets/listed_triangles.hpp"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include "base/system/processor.hpp"
#include "slicing/buckets/thread_shares.hpp"

namespace lamella {

namespace {

void count_from(CrossedTriangle& record, PlaneIndex base) noexcept {
    const PlaneIndex middle = record.middle_plane();
    record.middle_and_source -= std::min(middle, base);
    record.last -= base;
}

/// An American flag sort in parallel, after Cho et al., PARADIS, VLDB 2015: every thread has a stripe of the part of each
/// list that is not sorted yet, and moves records round within its stripes. A record whose list has no more room in the
/// thread's stripe stays; those that stay are gathered at the end of the lists where they lie, for the next round.
///
///     list a              list b                    list c
///     [ sorted | 0  | 1 ] [ sorted |  0   |  1   ]  [ sorted | 0 | 1 ]      stripes of threads 0 and 1
class ListSort {
public:
    ListSort(std::span<CrossedTriangle> records, PlaneIndex base, std::span<const std::uint32_t> list_begin,
             std::size_t threads)
        : records_(records),
          base_(base),
          lists_(list_begin.size() - 1),
          end_(list_begin.subspan(1)),
          sorted_(list_begin.begin(), list_begin.end() - 1),
          stripes_(threads, std::vector<Stripe>(lists_)) {}

    /// On as many threads as there are stripes, or on one, after which all are in their lists.
    void round(const Parallel& parallel, std::size_t threads) {
        for (std::size_t list = 0; list < lists_; ++list) {
            const std::uint64_t left = end_[list] - sorted_[list];
            for (std::size_t t = 0; t < threads; ++t) {
                stripes_[t][list] = {sorted_[list] + static_cast<std::uint32_t>(left * t / threads),
                                     sorted_[list] + static_cast<std::uint32_t>(left * (t + 1) / threads)};
            }
        }
        parallel.run(threads, [&](std::size_t t, int) { move_round(stripes_[t], parallel); });
        if (threads > 1) {
            parallel.run_ranges(lists_, 64, [&](std::size_t begin, std::size_t end, int) {
                for (std::size_t list = begin; list < end; ++list) {
                    gather_rest(list, threads);
                }
            });
        }
    }

    bool done() const noexcept { return std::equal(sorted_.begin(), sorted_.end(), end_.begin()); }

private:
    struct Stripe {
        std::uint32_t next;
        std::uint32_t end;
    };

    std::size_t list_of(const CrossedTriangle& record) const noexcept { return std::max(record.first, base_) - base_; }

    void move_round(std::vector<Stripe>& stripes, const Parallel& parallel) {
        for (std::size_t list = 0; list < lists_; ++list) {
            Stripe& own = stripes[list];
            if (own.next < own.end) {
                parallel.stop_if_asked();
            }
            for (std::uint32_t head = own.next; head < own.end; ++head) {
                CrossedTriangle record = records_[head];
                for (std::size_t to = list_of(record); to != list; to = list_of(record)) {
                    Stripe& there = stripes[to];
                    if (there.next == there.end) {
                        break;
                    }
                    CrossedTriangle& place = records_[there.next++];
                    prefetch_to_write(&place + 2);  // of the same list, and likely the next to be moved
                    std::swap(record, place);
                }
                if (list_of(record) == list) {  // `head` may have a record that stays
                    records_[head] = records_[own.next];
                    records_[own.next++] = record;
                } else {
                    records_[head] = record;
                }
            }
        }
    }

    /// Those that stay in the stripes of a list, from the back.
    void gather_rest(std::size_t list, std::size_t threads) {
        std::uint32_t rest = end_[list];
        for (std::size_t t = threads; t-- > 0;) {
            const Stripe& stripe = stripes_[t][list];
            for (std::uint32_t at = stripe.end; at-- > stripe.next;) {
                if (list_of(records_[at]) != list) {
                    std::swap(records_[at], records_[--rest]);
                }
            }
        }
        sorted_[list] = rest;
    }

    std::span<CrossedTriangle> records_;
    PlaneIndex base_;
    std::size_t lists_;
    std::span<const std::uint32_t> end_;
    std::vector<std::uint32_t> sorted_;  ///< up to where
    std::vector<std::vector<Stripe>> stripes_;
};

}  // namespace

void ListedSource::count(double /*unit_mm*/) {
    buckets_.list_begin.resize_discarding(listed_.list_begin.size());
    std::copy(listed_.list_begin.begin(), listed_.list_begin.end(), buckets_.list_begin.begin());
    buckets_.segments.resize_discarding(listed_.segments.size());
    std::copy(listed_.segments.begin(), listed_.segments.end(), buckets_.segments.begin());
    buckets_.segment_count = std::accumulate(listed_.segments.begin(), listed_.segments.end(), std::uint64_t{0});
    buckets_.degenerate = 0;
    buckets_.crossed.set_size(0);
    buckets_.tier_begin = 0;
}

std::size_t ListedSource::scatter(PlaneRange /*tier*/, std::span<const PlaneIndex> reach_end, std::span<Reaching> reaching,
                                  bool /*origins*/) {
    std::swap(buckets_.records, listed_.records);
    const auto planes = static_cast<PlaneIndex>(listed_.segments.size());
    const std::span<const std::uint32_t> begins = listed_.list_begin;
    const std::size_t count = begins.back() - begins.front();
    const ThreadShares shares(count, parallel_);
    std::atomic<std::size_t> reaching_count = 0;
    parallel_.run(shares.count, [&](std::size_t share, int) {
        const auto at = [&](std::size_t s) { return begins.front() + static_cast<std::uint32_t>(count * s / shares.count); };
        ReachingWriter writer(reaching, reaching_count);
        const std::uint32_t end = at(share + 1);
        std::uint32_t next = at(share);
        const auto own = std::upper_bound(begins.begin(), begins.end(), next) - begins.begin();
        for (auto plane = static_cast<PlaneIndex>(own - 1); next < end; ++plane) {
            for (const std::uint32_t stop = std::min(end, begins[plane + 1]); next < stop; ++next) {
                CrossedTriangle& record = buckets_.records[next];
                if (listed_.base > 0) {
                    count_from(record, listed_.base);
                }
                const PlaneIndex last = std::min(record.last, planes);
                if (last > reach_end[plane]) {
                    writer.add({next, plane, last});
                }
            }
        }
        writer.flush();
    });
    return reaching_count;
}

void ListedSource::give_back() noexcept {
    std::swap(buckets_.records, listed_.records);
}

void sort_into_lists(std::span<CrossedTriangle> records, PlaneIndex base, std::span<const std::uint32_t> list_begin,
                     const Parallel& parallel) {
    const std::size_t threads = parallel.workers_for(records.size() >> 12);
    ListSort sort(records, base, list_begin, threads);
    for (int rounds = 0; threads > 1 && rounds < 3 && !sort.done(); ++rounds) {
        sort.round(parallel, threads);
    }
    if (threads == 1 || !sort.done()) {
        sort.round(parallel, 1);
    }
}

}  // namespace lamella
