// Runs one method on one mesh and prints a row of the paper's tables as JSON: the times of every run, and whether the
// answer equals the engine's. It is a process of its own, so that a method can be stopped and its memory measured
// alone.
//
//     lamella_paper_row --mesh=FILE (--layer-height=MM | --random-heights=MIN:MAX) --method=NAME[+NAME[+rays]]
//                       [--threads=N] [--limit=S]
//
// NAME is "engine", a whole method, or a slicing method. "+" adds a contour method to a slicing method, and "+rays"
// then adds the orientation of contours by rays. Exit status 75: over the time limit; 78: the method does not apply to
// this mesh.
#include <algorithm>
#include <exception>
#include <iostream>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "answer.hpp"
#include "lamella/io.hpp"
#include "lamella/lamella.hpp"
#include "mesh.hpp"
#include "methods.hpp"
#include "slice_incremental.hpp"
#include "slicing/tuning.hpp"
#include "timing.hpp"

namespace {

using namespace lamella;         // NOLINT(google-build-using-namespace)
using namespace lamella::bench;  // NOLINT(google-build-using-namespace)

struct Request {
    std::string mesh;
    std::string method;
    double layer_height_mm = 0.032;
    std::string random_heights;
    int threads = 1;
    unsigned limit_s = 0;

    SliceInfo slice_to(SliceResult& result, Slicer& slicer, const Mesh& mesh, int on_threads) const {
        Tuning tuning;
        if (const std::size_t colon = random_heights.find(':'); colon != std::string::npos) {
            tuning.random_heights = {std::stod(random_heights.substr(0, colon)),
                                     std::stod(random_heights.substr(colon + 1))};
        }
        return checked(
            slice_tuned(slicer, result, mesh.view(), {.layer_height_mm = layer_height_mm}, tuning, {.threads = on_threads}));
    }
};

struct Run {
    double slicing_s = 0;
    double contours_s = 0;
    double sense_s = 0;
    double sum() const noexcept { return slicing_s + contours_s + sense_s; }
};

/// Each run has the full limit.
template <class RunOnce>
std::vector<Run> repeated_within(unsigned limit_s, const RunOnce& run_once) {
    return repeated([&] {
        end_after(limit_s);
        const Run run = run_once();
        end_after(0);
        return run;
    });
}

/// The engine's answer, and its planes as the baselines take them.
class Reference {
public:
    Reference(const Mesh& mesh, const Request& request) {
        SliceResult result;
        Slicer slicer;
        info = request.slice_to(result, slicer, mesh, 0);
        answer = answer_of(result);
        problem.soup = mesh.soup.span();
        problem.unit_mm = result.info.grid_mm;
        for (const LayerView layer : result) {
            problem.planes.push_back(layer.plane.z());
        }
        if (request.random_heights.empty() && problem.planes.size() > 1) {
            problem.uniform = true;
            problem.first = problem.planes.front();
            problem.step = (static_cast<double>(problem.planes.back()) - problem.first) /
                           static_cast<double>(problem.planes.size() - 1);
        }
    }

    Answer answer;
    SliceInfo info;
    baselines::Problem problem;
};

/// The columns of a row other than its times.
struct Row {
    std::vector<Run> runs;
    std::string source;
    bool joins = true;  ///< false: the method makes only lists of segments
    bool tells_sense = false;
    Answer answer;
};

Row run_engine(const Mesh& mesh, const Request& request) {
    Slicer slicer;
    SliceResult result;
    const auto run_once = [&] {
        const auto start = Clock::now();
        request.slice_to(result, slicer, mesh, request.threads);
        const double all = seconds_since(start);
        const double contours = (result.info.ms.contours + result.info.ms.nesting) / 1000;
        return Run{all - contours, contours};
    };
    run_once();  // warms memory, as in all other measurements
    Row row;
    row.runs = repeated_within(request.limit_s, run_once);
    row.source = "this engine";
    row.answer = answer_of(result);
    return row;
}

Row run_whole(const baselines::WholeMethod& method, const baselines::Problem& problem, unsigned limit_s) {
    baselines::WholeOutcome outcome;
    Row row;
    row.runs = repeated_within(limit_s, [&] {
        outcome = {};
        const auto start = Clock::now();
        outcome = method.run(problem);
        return Run{outcome.slicing_s, seconds_since(start) - outcome.slicing_s};
    });
    row.source = method.source;
    row.answer = answer_of(outcome.contours);
    return row;
}

/// Times a slicing method alone, without a contour method.
Row run_steps(const baselines::SlicingMethod& slicing, const baselines::ContourMethod* contours, bool tells_sense,
              const baselines::Problem& problem, unsigned limit_s) {
    baselines::SegmentLists lists;
    baselines::Contours joined;
    Row row;
    row.runs = repeated_within(limit_s, [&] {
        lists = {};
        joined = {};
        const auto start = Clock::now();
        lists = slicing.slice(problem);
        Run run{seconds_since(start)};
        if (contours != nullptr) {
            joined = contours->join(lists);
            run.contours_s = seconds_since(start) - run.slicing_s;
        }
        if (tells_sense) {
            lists = {};
            const auto turn = Clock::now();
            sense_by_rays(joined);
            run.sense_s = seconds_since(turn);
        }
        return run;
    });
    row.joins = contours != nullptr;
    row.tells_sense = tells_sense;
    row.source = std::string(slicing.source) + (row.joins ? "; " + std::string(contours->source) : "");
    row.answer = row.joins ? answer_of(joined) : answer_of(lists);
    return row;
}

template <class Methods>
auto find(const Methods& methods, const std::string& name) {
    const auto found = std::ranges::find_if(methods, [&](const auto* method) { return method->name == name; });
    return found == std::end(methods) ? nullptr : *found;
}

Row run_method(const Mesh& mesh, const Request& request, const baselines::Problem& problem) {
    if (request.method == "engine") {
        return run_engine(mesh, request);
    }
    if (const auto* whole = find(baselines::whole_methods, request.method)) {
        return run_whole(*whole, problem, request.limit_s);
    }
    const std::vector<std::string> steps = CLI::detail::split(request.method, '+');
    const auto* slicing = find(baselines::slicing_methods, steps[0]);
    const auto* contours = steps.size() > 1 ? find(baselines::contour_methods, steps[1]) : nullptr;
    const bool tells_sense = steps.size() == 3 && steps[2] == "rays";
    if (slicing == nullptr || steps.size() > 3 || (steps.size() > 1 && contours == nullptr) ||
        (steps.size() == 3 && !tells_sense)) {
        fail("no method is called " + request.method);
    }
    return run_steps(*slicing, contours, tells_sense, problem, request.limit_s);
}

nlohmann::ordered_json to_json(const Request& request, const Mesh& mesh, const Reference& reference, const Row& row) {
    const Difference apart = difference(reference.answer, row.answer);
    const auto times = [&](double Run::*member, bool measured) {
        return measured ? nlohmann::ordered_json(values_of(row.runs, member)) : nlohmann::ordered_json();
    };
    return {{"method", request.method},
            {"source", row.source},
            {"threads", request.threads},
            {"uniform", reference.problem.uniform},
            {"n", mesh.triangles()},
            {"k", reference.problem.planes.size()},
            {"m", reference.info.segments},
            {"contours", reference.info.contours},
            {"open", reference.info.open_contours},
            {"slicing_s", times(&Run::slicing_s, true)},
            {"contours_s", times(&Run::contours_s, row.joins)},
            {"sense_s", times(&Run::sense_s, row.tells_sense)},
            {"planes_apart", apart.planes},
            {"contours_apart", row.joins ? nlohmann::ordered_json(apart.contours) : nlohmann::ordered_json()},
            {"peak_bytes", peak_bytes()}};
}

/// Checks the precondition of the merge in Algorithm 2.
bool ascends(const Mesh& mesh) {
    const auto low = [&](std::size_t t) {
        return std::min({mesh.soup[9 * t + 2], mesh.soup[9 * t + 5], mesh.soup[9 * t + 8]});
    };
    for (std::size_t t = 1; t < mesh.triangles(); ++t) {
        if (low(t) < low(t - 1)) {
            return false;
        }
    }
    return true;
}

int run(const Request& request) {
    const Mesh mesh = load_mesh(request.mesh);
    if (request.method == baselines::presorted_slicing.name && !ascends(mesh)) {
        std::cerr << "the triangles do not ascend by z_min\n";
        constexpr int not_for_this_mesh = 78;
        return not_for_this_mesh;
    }
    const Reference reference(mesh, request);
    const Row row = run_method(mesh, request, reference.problem);
    std::cout << to_json(request, mesh, reference, row).dump() << '\n';
    return 0;
}

}  // namespace

int main(int count, char** words) try {
    CLI::App app("Runs one method on one mesh and prints its times and whether its answer equals the engine's");
    Request request;
    app.add_option("--mesh", request.mesh)->required();
    app.add_option("--method", request.method)->required();
    app.add_option("--layer-height", request.layer_height_mm);
    app.add_option("--random-heights", request.random_heights);
    app.add_option("--threads", request.threads)->check(CLI::Range(1, 1024));
    app.add_option("--limit", request.limit_s);
    CLI11_PARSE(app, count, words);
    return run(request);
} catch (const std::exception& failure) {
    std::cerr << "lamella_paper_row: " << failure.what() << '\n';
    return 1;
}
