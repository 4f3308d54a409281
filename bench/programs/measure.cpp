#include "measure.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <map>
#include <utility>

#include "base/dispatch.hpp"
#include "base/parallel.hpp"
#include "lamella/array.hpp"

namespace lamella::bench {

namespace {

/// A line of the cache.
struct Line {
    std::array<std::uint64_t, 8> words;
};

void read_lines(Line* begin, Line* end) {
    Line sum{};
    for (Line* line = begin; line < end; ++line) {
        for (std::size_t i = 0; i < 8; ++i) {
            sum.words[i] += line->words[i];
        }
    }
    benchmark::DoNotOptimize(sum);
}

void write_lines(Line* begin, Line* end) {
    for (Line* line = begin; line < end; ++line) {
#ifdef LAMELLA_SSE2
        for (std::size_t i = 0; i < 8; i += 2) {
            _mm_stream_si128(reinterpret_cast<__m128i*>(&line->words[i]), _mm_set1_epi64x(1));
        }
#else
        line->words.fill(1);
#endif
    }
}

Bandwidth measure_bandwidth(int threads) {
    constexpr std::size_t bytes = std::size_t{1} << 30;
    Array<Line> memory;
    memory.resize_discarding(bytes / sizeof(Line));
    const Parallel parallel({.threads = threads});
    const auto best_of_nine = [&](void (*pass)(Line*, Line*)) {
        const auto pass_all = [&] {
            parallel.run_ranges(memory.size(), 1 << 14, [&](std::size_t begin, std::size_t end, int) {
                pass(memory.data() + begin, memory.data() + end);
            });
        };
        double best_ms = ms_of(pass_all);
        for (int round = 1; round < 9; ++round) {
            best_ms = std::min(best_ms, ms_of(pass_all));
        }
        return 1e3 * static_cast<double>(bytes) / best_ms;
    };
    const double write = best_of_nine(write_lines);
    return {.read = best_of_nine(read_lines), .write = write};
}

void require_near(const char* what, std::uint64_t found, std::uint64_t stated, double tolerance) {
    if (std::abs(static_cast<double>(found) - static_cast<double>(stated)) > tolerance * static_cast<double>(stated)) {
        fail(std::string(what) + ": " + std::to_string(found) + ", stated " + std::to_string(stated));
    }
}

}  // namespace

const Bandwidth& bandwidth(int threads) {
    static std::map<int, Bandwidth> measured;
    if (measured.count(threads) == 0) {
        measured[threads] = measure_bandwidth(threads);
    }
    return measured[threads];
}

Prepared::Prepared(const Case& wanted, std::shared_ptr<const Mesh> of_case)
    : name(wanted.name), mesh_name(wanted.mesh_name), mesh(std::move(of_case)), plan(wanted.plan(*mesh)) {
    if (wanted.triangles != 0) {
        require_near("triangles", mesh->triangles(), wanted.triangles, 0.01);
    }
    if (wanted.known) {
        check_known(*wanted.known);
    }
    info = slice(1);
    const AuditOptions structure{.open = false, .volume = false, .ledger = false, .crossings = false, .structure = true};
    const Audit audited = checked(audit(result, MeshView{}, structure));
    if (!*audited.structure) {
        fail(audited.structure->error().message);
    }
    hash_ = result.hash();
    if (wanted.segments != 0) {
        require_near("segments", info.segments, wanted.segments, 0.05);
    }
}

void Prepared::check_known(const KnownAnswer& known) {
    const SliceOptions exact{.layer_height_mm = 0.032, .planes = {.first_height_mm = 0.008}, .frame = {.grid_mm = 0.004}};
    const SliceInfo sliced = checked(slicer.slice_to(result, mesh->view(), exact, {.threads = 1}));
    require_near("planes", sliced.layers, known.planes, 0);
    require_near("segments", sliced.segments, known.segments, 0);
    require_near("contours", sliced.contours, known.contours, 0);
    require_near("open contours", sliced.open_contours, known.open, 0);
}

void Prepared::check(int threads) {
    slice(threads);
    if (result.hash() != hash_) {
        fail("the answer differs from that of one thread");
    }
}

Prepared& prepared(const Case& wanted) {
    static std::unique_ptr<Prepared> last;
    if (last == nullptr || last->name != wanted.name) {
        std::shared_ptr<const Mesh> mesh = last != nullptr && last->mesh_name == wanted.mesh_name ? last->mesh : nullptr;
        last.reset();  // before another mesh takes memory
        last = std::make_unique<Prepared>(wanted, mesh != nullptr ? mesh : std::make_shared<const Mesh>(wanted.mesh()));
    }
    last->plan.tuning.instructions.reset();  // as a benchmark of one level has left it
    return *last;
}

Figures measure(benchmark::State& state, const std::function<void()>& setup, const std::function<void()>& work) {
    double all_ms = 0;
    for (auto _ : state) {
        setup();
        const double ms = ms_of(work);
        state.SetIterationTime(ms / 1000);
        all_ms += ms;
    }
    return {{"real_time", all_ms / static_cast<double>(state.iterations())}};
}

void add_benchmark(const Options& options, const std::string& name, int threads,
                   const std::function<Figures(benchmark::State&)>& run) {
    const auto run_guarded = [run](benchmark::State& state) {
        try {
            Figures figures = run(state);
            if (figures.erase("real_time") == 0) {  // it took its own times, and has not gone through the iterations
                for (auto _ : state) {
                    state.SetIterationTime(1);
                }
            }
            state.counters.insert(figures.begin(), figures.end());
        } catch (const std::exception& failure) {
            state.SkipWithError(failure.what());
        }
    };
    benchmark::RegisterBenchmark((name + "/threads:" + std::to_string(threads)).c_str(), run_guarded)
        ->UseManualTime()
        ->MeasureProcessCPUTime()
        ->Unit(benchmark::kMillisecond)
        ->MinTime(options.quick ? 0.005 : 0.2)
        ->Repetitions(options.quick ? 1 : 5);
}

}  // namespace lamella::bench
