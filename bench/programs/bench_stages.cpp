// Times each stage alone, in memory that it has used before.
#include "base/parallel.hpp"
#include "copy_bandwidth.hpp"
#include "io/read/input_file.hpp"
#include "lamella/array.hpp"
#include "measure.hpp"

namespace lamella::bench {

namespace {

/// Reads a file in the page cache into memory that was touched before.
void run_read(benchmark::State& state, const Prepared& prepared, int threads) {
    const Parallel parallel({.threads = threads});
    Array<std::byte> bytes;
    bool ok = !prepared.mesh().file.empty();
    const auto read = [&] {
        const Result<InputFile> file = InputFile::open(prepared.mesh().file);
        if (!file) {
            ok = false;
            return;
        }
        bytes.resize_discarding(file->size());
        ok = ok && file->read(bytes.span(), parallel).ok() && file->unchanged().ok();
    };
    read();
    const double seconds = measure(state, [&] {
        if (ok) {
            read();
        }
    });
    if (!ok) {
        state.SkipWithError("the file cannot be read");
    }
    count(state, {.triangles = prepared.mesh().triangles(), .bytes = 2 * bytes.size()}, seconds, threads);
}

/// Whether the stages, run one after the other, find the same counts as slice().
std::string check_stages(const Prepared& prepared, Stages* stages) {
    if (stages == nullptr) {
        return "a stage failed";
    }
    const Buckets& buckets = stages->buckets();
    const SliceSummary& known = prepared.summary();
    const bool same = buckets.segment_count == known.segments && buckets.records.size() == known.crossed &&
                      buckets.degenerate == known.degenerate;
    return same ? "" : "the stages and slice() count different crossings";
}

using StageWork = void (*)(Stages&);
using StageBytes = std::uint64_t (*)(const Prepared&);

struct Stage {
    const char* name;
    StageWork before;  ///< run untimed before `work`; null for none
    StageWork work;
    StageBytes bytes;  ///< bytes that the stage must read and write
};

std::uint64_t record_bytes(const Prepared& prepared) {
    return prepared.summary().crossed * sizeof(CrossedTriangle);
}

constexpr Stage stages_before_sweep[] = {
    {"bounds", nullptr, [](Stages& s) { (void)s.measure().ok(); }, [](const Prepared& p) { return p.mesh().bytes(); }},
    {"planes", nullptr, [](Stages& s) { (void)s.plan_planes().ok(); }, [](const Prepared&) { return std::uint64_t{0}; }},
    {"count", nullptr, [](Stages& s) { s.count(); }, [](const Prepared& p) { return p.mesh().bytes(); }},
    // Scattering consumes the counters.
    {"scatter", [](Stages& s) { s.count(); }, [](Stages& s) { s.scatter(); },
     [](const Prepared& p) { return p.mesh().bytes() + record_bytes(p); }},
    {"bands",
     [](Stages& s) {
         s.count();
         s.scatter();
     },
     [](Stages& s) {
         s.cut_bands();
         s.find_seeds();
     },
     [](const Prepared&) { return std::uint64_t{0}; }},
};

void run_stage(benchmark::State& state, Prepared& prepared, const Stage& stage, int threads) {
    Stages* stages = prepared.stages(threads);
    if (const std::string failure = check_stages(prepared, stages); !failure.empty()) {
        state.SkipWithError(failure.c_str());
        return;
    }
    const double seconds = measure(
        state,
        [&] {
            if (stage.before != nullptr) {
                stage.before(*stages);
            }
        },
        [&] { stage.work(*stages); });
    if (const std::string failure = check_stages(prepared, stages); !failure.empty()) {
        state.SkipWithError(failure.c_str());
    }
    count(
        state,
        {.segments = prepared.summary().segments, .triangles = prepared.mesh().triangles(), .bytes = stage.bytes(prepared)},
        seconds, threads);
}

void run_sweep(benchmark::State& state, Prepared& prepared, ContourForm form, int threads) {
    Stages* stages = prepared.stages(threads);
    std::string failure = check_stages(prepared, stages);
    if (failure.empty()) {
        stages->sweep(form);
        const bool same = stages->swept_contours() == prepared.contours() && stages->swept_points() == prepared.points();
        failure = same ? "" : "the bands and slice() find different contours";
    }
    if (!failure.empty()) {
        state.SkipWithError(failure.c_str());
        return;
    }
    const double seconds = measure(state, [&] { stages->sweep(form); });
    count(state,
          {.segments = prepared.summary().segments,
           .triangles = prepared.mesh().triangles(),
           .bytes = record_bytes(prepared) + prepared.result_bytes()},
          seconds, threads);
}

}  // namespace

void add_copies(const Options& options) {
    for (const int threads : thread_counts(options)) {
        add_benchmark("copy/memory/warm/threads:" + std::to_string(threads), options, [=](benchmark::State& state) {
            const double bytes_per_s = copy_bandwidth(threads);
            for (auto _ : state) {
                state.SetIterationTime(1e-3);
            }
            state.counters["bytes/s"] = benchmark::Counter(bytes_per_s);
            state.counters["threads"] = benchmark::Counter(threads);
        });
    }
}

void add_stages(const Options& options, const Case& wanted) {
    if (!wanted.measured.stages) {
        return;
    }
    for (const int threads : thread_counts(options)) {
        add_case_benchmark(benchmark_name("stage", wanted.name, "read", threads), options, wanted,
                           [=](benchmark::State& state, const Prepared& p) { run_read(state, p, threads); });
        for (const Stage& stage : stages_before_sweep) {
            add_case_benchmark(benchmark_name("stage", wanted.name, stage.name, threads), options, wanted,
                               [=](benchmark::State& state, Prepared& p) { run_stage(state, p, stage, threads); });
        }
        for (const ContourForm form : {ContourForm::swept, ContourForm::assembled}) {
            add_case_benchmark(benchmark_name("stage", wanted.name, std::string("sweep_") + name_of(form), threads), options,
                               wanted, [=](benchmark::State& state, Prepared& p) { run_sweep(state, p, form, threads); });
        }
    }
}

}  // namespace lamella::bench
