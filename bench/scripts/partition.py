"""The speed-up that the partition allows: computed from the measured times of single bands and parts, not measured.

Bands are claimed in ascending order by whichever thread is free, and none runs further ahead of the first unfinished one
than the placement lets it (engine/slicing/result/placement.hpp). Every other stage takes as long as its slowest part; what is
done by one thread is added in full. Taken for granted: that a core is as fast among many as alone, memory included."""
import heapq

LEAD_PER_THREAD = 2  # bands; Placement::begin()
POINT_BYTES = 8
CONTOUR_BYTES = 48


def sweep_time(bands, threads):
    """List scheduling in order."""
    free = [0.0] * threads
    all_done = [0.0]  # when the first b bands are done
    for band, seconds in enumerate(bands):
        start = heapq.heappop(free)
        head_needed = band - LEAD_PER_THREAD * threads
        if head_needed > 0:
            start = max(start, all_done[head_needed])
        heapq.heappush(free, start + seconds)
        all_done.append(max(all_done[-1], start + seconds))
    return all_done[-1]


def allowed_time(case, partition):
    threads = partition["threads"]
    copy = case["copy_bytes_per_s"]
    bands = partition["bands"]
    if threads > 1:  # all but the first unfinished band go through a buffer
        bands = [seconds + 2 * POINT_BYTES * segments / copy
                 for seconds, segments in zip(bands, partition["band_segments"])]
    parts = sum(max(part[stage] for part in partition["parts"]) for stage in ("bounds", "count", "scatter"))
    prefix_sums = (threads - 1) * case["serial_per_part"]
    contours = 2 * CONTOUR_BYTES * case["contours"] / copy
    finish = contours / threads + contours / 2  # placed by all threads, then counted by one
    return parts + prefix_sums + case["plan_planes"] + partition["plan_bands"] + sweep_time(bands, threads) + finish


def allowed_speedups(case):
    """[(threads, speed-up over the same sum for one thread)]"""
    times = {partition["threads"]: allowed_time(case, partition) for partition in case["partitions"]}
    return [(threads, times[1] / seconds) for threads, seconds in times.items()]


def accounted_for(case):
    """The sum for one thread over what was measured end to end: near 1 where the sum tells the whole."""
    return allowed_time(case, case["partitions"][0]) / case["end_to_end_1_thread"]
