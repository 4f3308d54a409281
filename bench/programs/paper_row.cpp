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
#include <cstdlib>
#include <exception>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "answer.hpp"
#include "base/clock.hpp"
#include "lamella/io.hpp"
#include "lamella/lamella.hpp"
#include "mesh.hpp"
#include "methods.hpp"
#include "sense_by_rays.hpp"
#include "slice_incremental.hpp"
#include "timed_runs.hpp"

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

    SliceOptions options() const {
        SliceOptions options;
        options.control.threads = threads;
        if (const std::size_t colon = random_heights.find(':'); colon != std::string::npos) {
            options.plan.spacing =
                RandomLayers{std::stod(random_heights.substr(0, colon)), std::stod(random_heights.substr(colon + 1)), 1};
        } else {
            options.plan.spacing = UniformLayers{.layer_height_mm = layer_height_mm};
        }
        return options;
    }
};

struct Run {
    double slicing_s = 0;
    double contours_s = 0;
    double sense_s = 0;
    double sum() const noexcept { return slicing_s + contours_s + sense_s; }
};

double seconds_since(Clock::time_point start) {
    return milliseconds_since(start) / 1000;
}

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
        SliceOptions options = request.options();
        options.control.threads = 0;
        const SliceResult result = checked(slice(mesh.view(), options));
        answer = answer_of(result);
        summary = result.summary;
        contours = result.contours.size();
        problem.soup = mesh.soup.span();
        problem.unit_mm = result.unit_mm;
        for (const Layer& layer : result.layers) {
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
    SliceSummary summary;
    std::uint64_t contours = 0;
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
    const SliceOptions options = request.options();
    Workspace workspace;
    SliceResult result;
    const auto run_once = [&] {
        const auto start = Clock::now();
        if (const Status status = slice(mesh.view(), options, workspace, result); !status) {
            throw std::runtime_error(status.error().message);
        }
        const double all = seconds_since(start);
        const double contours = (result.summary.ms.contours + result.summary.ms.nesting) / 1000;
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

template <class Method>
const Method* find(std::span<const Method* const> methods, const std::string& name) {
    const auto found = std::find_if(methods.begin(), methods.end(), [&](const Method* m) { return m->name == name; });
    return found == methods.end() ? nullptr : *found;
}

Row run_method(const Mesh& mesh, const Request& request, const baselines::Problem& problem) {
    if (request.method == "engine") {
        return run_engine(mesh, request);
    }
    if (const auto* whole = find(baselines::whole_methods(), request.method)) {
        return run_whole(*whole, problem, request.limit_s);
    }
    const std::vector<std::string> steps = CLI::detail::split(request.method, '+');
    const auto* slicing = find(baselines::slicing_methods(), steps[0]);
    const auto* contours = steps.size() > 1 ? find(baselines::contour_methods(), steps[1]) : nullptr;
    const bool tells_sense = steps.size() == 3 && steps[2] == "rays";
    if (slicing == nullptr || steps.size() > 3 || (steps.size() > 1 && contours == nullptr) ||
        (steps.size() == 3 && !tells_sense)) {
        throw std::runtime_error("no method is called " + request.method);
    }
    return run_steps(*slicing, contours, tells_sense, problem, request.limit_s);
}

nlohmann::ordered_json to_json(const Request& request, const Mesh& mesh, const Reference& reference, const Row& row) {
    const Difference apart = difference(reference.answer, row.answer);
    nlohmann::ordered_json slicing = nlohmann::ordered_json::array();
    nlohmann::ordered_json contours = nlohmann::ordered_json::array();
    nlohmann::ordered_json orientation = nlohmann::ordered_json::array();
    for (const Run& run : row.runs) {
        slicing.push_back(run.slicing_s);
        contours.push_back(run.contours_s);
        orientation.push_back(run.sense_s);
    }
    return {{"method", request.method},
            {"source", row.source},
            {"threads", request.threads},
            {"uniform", reference.problem.uniform},
            {"n", mesh.triangles()},
            {"k", reference.problem.planes.size()},
            {"m", reference.summary.segments},
            {"contours", reference.contours},
            {"open", reference.summary.open_contours},
            {"slicing_s", slicing},
            {"contours_s", row.joins ? contours : nlohmann::ordered_json()},
            {"sense_s", row.tells_sense ? orientation : nlohmann::ordered_json()},
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
    const Mesh mesh = checked(load_mesh(request.mesh));
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
