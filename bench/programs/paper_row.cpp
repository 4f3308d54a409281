// Runs one method on one mesh and prints a row of the paper's tables as JSON: the times of every run, and whether the
// answer equals the engine's. It is a process of its own, so that a method can be stopped.
//
//     lamella_paper_row METHOD MESH SPACING_MM THREADS LIMIT_S
//
// METHOD is "engine", a whole method, or a slicing method. "+NAME" adds a contour method to a slicing method, and "+rays"
// then adds the orientation of contours by rays. SPACING_MM is a layer height, or MIN:MAX for random ones. LIMIT_S bounds
// each run; 0: nothing does. Exit status 75: over the time limit; 78: the method does not apply to this mesh.
#include <algorithm>
#include <array>
#include <cstdlib>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include "base/numbers.hpp"
#include "catalogue.hpp"
#include "lamella/io.hpp"
#include "lamella/lamella.hpp"
#include "methods.hpp"
#include "slicing/tuning.hpp"
#include "timing.hpp"

namespace lamella::bench {

namespace {

/// What two methods must have in common in a plane, as sums of hashes. They depend neither on the order of contours nor on
/// where each begins, and are small enough to be kept for every plane of the largest model.
struct PlaneAnswer {
    std::uint64_t segments = 0;           ///< over all segments of non-zero length, whatever their direction
    std::vector<std::uint64_t> closed{};  ///< one for each closed contour's points in order

    void add(std::span<const Point> points, bool is_closed) {
        const auto hash = [](Point p) {
            return std::uint64_t{static_cast<std::uint32_t>(p.x)} << 32 | static_cast<std::uint32_t>(p.y);
        };
        const auto hash_of_step = [&](Point from, Point to) {
            return mix64(mix64(hash(from) + 0x9E3779B97F4A7C15U) + hash(to));
        };
        std::uint64_t steps = 0;
        for (std::size_t i = 1; i < points.size() + (is_closed ? 1 : 0); ++i) {
            const auto [from, to] = std::pair(points[i - 1], points[i % points.size()]);
            if (from != to) {  // a contour stores two equal successive points as one
                segments += hash_of_step(std::min(from, to), std::max(from, to));
                steps += hash_of_step(from, to);
            }
        }
        if (is_closed) {
            closed.push_back(mix64(steps));
        }
    }
};
using Answer = std::vector<PlaneAnswer>;

Answer answer_of(const SliceResult& result) {
    Answer answer(result.layers.size());
    for (std::size_t l = 0; l < answer.size(); ++l) {
        for (const Contour& contour : result.contours_of(result.layers[l])) {
            answer[l].add(result.points_of(contour), contour.role != Role::open);
        }
    }
    return answer;
}

Answer answer_of(const baselines::Contours& contours) {
    Answer answer(contours.size());
    for (std::size_t l = 0; l < answer.size(); ++l) {
        for (const baselines::Polyline& contour : contours[l]) {
            answer[l].add(contour.points, contour.closed);
        }
    }
    return answer;
}

Answer answer_of(const baselines::SegmentLists& lists) {
    Answer answer(lists.size());
    for (std::size_t l = 0; l < answer.size(); ++l) {
        for (const auto& [from, to] : lists[l]) {
            answer[l].add(std::array{from, to}, false);
        }
    }
    return answer;
}

/// Adds the number of planes whose segments differ, and that of closed contours that only one of the answers has.
void compare(Answer& expected, Answer& found, Json& row) {
    std::uint64_t planes = 0;
    std::vector<std::uint64_t> apart;
    for (std::size_t l = 0; l < expected.size(); ++l) {
        planes += expected[l].segments != found[l].segments ? 1U : 0U;
        std::ranges::sort(expected[l].closed);
        std::ranges::sort(found[l].closed);
        std::ranges::set_symmetric_difference(expected[l].closed, found[l].closed, std::back_inserter(apart));
    }
    row["planes_apart"] = planes;
    row["contours_apart"] = apart.size();
}

struct Request {
    std::string method;
    SliceOptions options;
    Tuning tuning;
    int threads = 1;
    unsigned limit_s = 0;

    explicit Request(const Words& words)
        : method(words[0]), threads(std::stoi(words[3])), limit_s(static_cast<unsigned>(std::stoul(words[4]))) {
        options.layer_height_mm = std::stod(words[2]);
        if (const std::size_t colon = words[2].find(':'); colon != std::string::npos) {
            tuning.random_heights = {options.layer_height_mm, std::stod(words[2].substr(colon + 1))};
        }
    }

    void slice_to(SliceResult& result, Slicer& slicer, const Mesh& mesh, int on_threads) const {
        checked(slice_tuned(slicer, result, mesh.view(), options, tuning, {.threads = on_threads}));
    }
};

/// The engine's planes as the baselines take them.
baselines::Problem problem_of(const Mesh& mesh, const SliceResult& result, bool uniform) {
    baselines::Problem problem;
    problem.soup = mesh.soup.span();
    problem.unit_mm = result.info.grid_mm;
    problem.planes.reserve(result.layers.size());
    for (const Layer& layer : result.layers) {
        problem.planes.push_back(layer.plane.z());
    }
    if (uniform && problem.planes.size() > 1) {
        problem.uniform = true;
        problem.first = problem.planes.front();
        problem.step =
            (static_cast<double>(problem.planes.back()) - problem.first) / static_cast<double>(problem.planes.size() - 1);
    }
    return problem;
}

/// Seconds of slicing, of joining contours, and of orienting them.
using Seconds = std::array<double, 3>;

/// Times the method, and adds the times of the steps that it has to the row.
template <class RunOnce>
void time_runs(Json& row, unsigned limit_s, std::size_t steps, const RunOnce& run_once) {
    const auto times = repeated<3>([&] {
        end_after(limit_s);  // each run has the full limit
        const Seconds run = run_once();
        end_after(0);
        return run;
    });
    constexpr std::array names{"slicing_s", "contours_s", "sense_s"};
    for (std::size_t step = 0; step < steps; ++step) {
        row[names[step]] = times[step];
    }
}

Answer run_engine(const Mesh& mesh, const Request& request, Json& row) {
    Slicer slicer;
    SliceResult result;
    const auto run_once = [&] {
        const double all = seconds_of([&] { request.slice_to(result, slicer, mesh, request.threads); });
        const double contours = (result.info.ms.contours + result.info.ms.nesting) / 1000;
        return Seconds{all - contours, contours};
    };
    run_once();  // warms memory, as in all other measurements
    time_runs(row, request.limit_s, 2, run_once);
    return answer_of(result);
}

Answer run_whole(const baselines::WholeMethod& method, const baselines::Problem& problem, unsigned limit_s, Json& row) {
    baselines::WholeOutcome outcome;
    time_runs(row, limit_s, 2, [&] {
        outcome = {};
        const double all = seconds_of([&] { outcome = method.run(problem); });
        return Seconds{outcome.slicing_s, all - outcome.slicing_s};
    });
    return answer_of(outcome.contours);
}

/// A slicing method alone, with a contour method, or with that and the orientation of contours.
Answer run_steps(const baselines::SlicingMethod& slicing, const baselines::ContourMethod* contours, std::size_t steps,
                 const baselines::Problem& problem, unsigned limit_s, Json& row) {
    baselines::SegmentLists lists;
    baselines::Contours joined;
    time_runs(row, limit_s, steps, [&] {
        joined = {};
        lists = {};
        Seconds run{seconds_of([&] { lists = slicing.slice(problem); })};
        if (steps > 1) {
            run[1] = seconds_of([&] { joined = contours->join(lists); });
        }
        if (steps > 2) {
            lists = {};
            run[2] = seconds_of([&] { sense_by_rays(joined); });
        }
        return run;
    });
    return steps > 1 ? answer_of(joined) : answer_of(lists);
}

template <class Methods>
auto find(const Methods& methods, const std::string& name) {
    const auto found = std::ranges::find_if(methods, [&](const auto* method) { return method->name == name; });
    return found == std::end(methods) ? nullptr : *found;
}

Answer run_method(const Mesh& mesh, const Request& request, const baselines::Problem& problem, Json& row) {
    if (request.method == "engine") {
        return run_engine(mesh, request, row);
    }
    if (const auto* whole = find(baselines::whole_methods, request.method)) {
        return run_whole(*whole, problem, request.limit_s, row);
    }
    std::istringstream words(request.method);
    std::vector<std::string> steps;
    for (std::string step; std::getline(words, step, '+');) {
        steps.push_back(step);
    }
    const auto* slicing = find(baselines::slicing_methods, steps[0]);
    const auto* contours = steps.size() > 1 ? find(baselines::contour_methods, steps[1]) : nullptr;
    if (slicing == nullptr || (steps.size() > 1 && contours == nullptr) || (steps.size() > 2 && steps[2] != "rays")) {
        fail("no method is called " + request.method);
    }
    return run_steps(*slicing, contours, steps.size(), problem, request.limit_s, row);
}

/// Checks the precondition of the merge in Algorithm 2.
bool ascends(const Mesh& mesh) {
    float last = -std::numeric_limits<float>::infinity();
    for (std::size_t t = 0; t < mesh.soup.size(); t += 9) {
        const float low = std::min({mesh.soup[t + 2], mesh.soup[t + 5], mesh.soup[t + 8]});
        if (low < last) {
            return false;
        }
        last = low;
    }
    return true;
}

void run(const Words& words) {
    const Request request(words);
    const Mesh mesh = load_mesh(words[1]);
    if (request.method == baselines::presorted_slicing.name && !ascends(mesh)) {
        constexpr int not_for_this_mesh = 78;
        std::exit(not_for_this_mesh);
    }
    SliceResult result;
    Slicer slicer;
    request.slice_to(result, slicer, mesh, 0);
    const SliceInfo& info = result.info;
    Json row{{"n", mesh.triangles()},
             {"k", info.layers},
             {"m", info.segments},
             {"contours", info.contours},
             {"open", info.open_contours}};
    Answer expected = answer_of(result);
    const baselines::Problem problem = problem_of(mesh, result, !request.tuning.random_heights);
    result = SliceResult();  // its memory is the method's
    Answer found = run_method(mesh, request, problem, row);
    compare(expected, found, row);
    if (!row.contains("contours_s")) {
        row.erase("contours_apart");
    }
    print(row);
}

}  // namespace

}  // namespace lamella::bench

int main(int count, char** words) {
    return lamella::bench::run_program(count, words, "METHOD MESH SPACING_MM THREADS LIMIT_S", lamella::bench::run);
}
