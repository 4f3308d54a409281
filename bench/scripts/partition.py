"""Computes the speed-up that the partition allows from the measured times of single bands and parts.

Free threads claim bands in ascending order. No thread runs further ahead of the first unfinished band than placement allows
(engine/slicing/result/placement.hpp). Every other stage takes as long as its slowest part. Work of one thread is added in
full. The model assumes that a core, with its memory, is as fast among many as alone."""
import heapq

LEAD_PER_THREAD = 2  # bands; Placement::begin()
POINT_BYTES = 8
CONTOUR_BYTES = 48


def sweep_time(bands, threads):
    """Seconds that the bands take, scheduled in order on the threads."""
    free = [0.0] * threads
    all_done = [0.0]  # by b: when the first b bands are done
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
    if threads > 1:  # every band but the first unfinished one goes through a buffer
        bands = [seconds + 2 * POINT_BYTES * segments / copy
                 for seconds, segments in zip(bands, partition["band_segments"])]
    parts = sum(max(part[stage] for part in partition["parts"]) for stage in ("bounds", "count", "scatter"))
    prefix_sums = (threads - 1) * case["serial_per_part"]
    contours = 2 * CONTOUR_BYTES * case["contours"] / copy
    finish = contours / threads + contours / 2  # all threads place the contours, then one counts them
    return parts + prefix_sums + case["plan_planes"] + partition["plan_bands"] + sweep_time(bands, threads) + finish


def allowed_speedups(case):
    """Pairs of (threads, speed-up over the same sum for one thread)."""
    times = {partition["threads"]: allowed_time(case, partition) for partition in case["partitions"]}
    return [(threads, times[1] / seconds) for threads, seconds in times.items()]


def accounted_for(case):
    """The sum for one thread divided by the measured end-to-end time. Near 1 if the sum leaves nothing out."""
    return allowed_time(case, case["partitions"][0]) / case["end_to_end_1_thread"]
