#include "catalogue.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <thread>
#include <utility>

namespace lamella::bench {

namespace {

constexpr double layer_mm = 0.032;
constexpr std::uint64_t few_planes_segments = 5'000'000;
constexpr double few_planes_height_mm = 10;
constexpr double segments_per_triangle = 5;  // for the linear series and for weak scaling

using PlanOf = std::function<Plan(const Mesh&)>;

PlanOf uniform(double height_mm) {
    return [=](const Mesh&) { return Plan{{.layer_height_mm = height_mm}}; };
}

/// Random steps with as many planes as uniform(layer_mm) on average.
PlanOf irregular() {
    return [](const Mesh&) { return Plan{{}, {.random_heights = RandomHeights{layer_mm / 2, layer_mm * 3 / 2, 1}}}; };
}

/// `count` planes, evenly spaced between the lowest and the highest vertex.
PlanOf few(int count) {
    return [=](const Mesh& mesh) {
        std::vector<double> heights_mm;
        for (int i = 0; i < count; ++i) {
            heights_mm.push_back(mesh.low_mm + (mesh.high_mm - mesh.low_mm) * (i + 0.5) / count);
        }
        return Plan{{.heights_mm = heights_mm}};
    };
}

/// Layers of the height that gives `segments_per_triangle`.
PlanOf constant_ratio() {
    return [](const Mesh& mesh) {
        const double crossings = segments_per_triangle * static_cast<double>(mesh.triangles());
        return Plan{{.layer_height_mm = mesh.rise_mm / crossings}};
    };
}

class CatalogueMaker {
public:
    explicit CatalogueMaker(const Options& options) : options_(options) {}

    std::vector<Case> make() {
        add_real("liver", KnownAnswer{6'242, 2'342'005, 15'790, 0});
        add_real("femur", KnownAnswer{3'155, 1'180'826, 3'338, 0});
        add_real("brain", {});
        add_real("hip_femur", {});
        add_bones();
        add_few_planes();
        add_linear();
        add_weak();
        return std::move(cases_);
    }

private:
    std::uint64_t scaled(std::uint64_t count) const { return options_.quick ? count / 100 : count; }

    Case& add(const std::string& name, const std::string& mesh_name, std::function<Mesh()> mesh, PlanOf plan,
              const Measured& measured) {
        return cases_.emplace_back(Case{name, std::move(mesh), mesh_name, std::move(plan), measured});
    }

    std::function<Mesh()> made(const models::Recipe& recipe) const {
        return [recipe, cache = options_.cache] { return load_mesh(cached_mesh(recipe, cache)); };
    }

    /// Real meshes. Where one is absent, a bone of about as many triangles replaces it, under a name that says so.
    void add_real(const std::string& name, const std::optional<KnownAnswer>& known) {
        const std::filesystem::path file = options_.shared / (name + ".stl");
        const bool paper = known.has_value();
        const bool present = !options_.shared.empty() && std::filesystem::exists(file);
        const Measured all{.partition = paper, .cold = true, .from_file = true};
        if (present) {
            const auto load = [file] { return load_mesh(file); };
            add(name, name, load, uniform(layer_mm), all).known = known;
            add(name + "_irregular", name, load, irregular(), {});
        } else if (paper) {
            const auto make = made({.shape = models::Shape::bone, .triangles = 40'000});
            add("instead_of_" + name, "instead_of_real", make, uniform(layer_mm), all);
        }
    }

    /// A bone of the stated size. With --quick it is smaller, and its number of segments is not controlled.
    models::Recipe bone(std::uint64_t triangles, double height_mm, std::uint64_t segments) const {
        models::Recipe recipe{.shape = models::Shape::bone, .triangles = scaled(triangles), .height_mm = height_mm};
        if (!options_.quick) {
            recipe.segments = segments;
            recipe.layer_height_mm = layer_mm;
        }
        return recipe;
    }

    Case& add_bone(const std::string& name, const models::Recipe& recipe, const Measured& measured) {
        Case& added = add(name, name, made(recipe), uniform(layer_mm), measured);
        added.triangles = recipe.triangles;
        added.segments = recipe.segments.value_or(0);
        return added;
    }

    void add_bones() {
        models::Recipe scan = bone(3'400'000, 150, 18'000'000);
        add_bone("scan", scan, {.partition = true, .cold = true, .from_file = true});
        add("scan_irregular", "scan", made(scan), irregular(), {});
        scan.order = models::Order::random;
        add_bone("scan_shuffled", scan, {.partition = true});
        add_bone("figure", bone(8'800'000, 10, 1'100'000), {.partition = true, .cold = true, .from_file = true});
        add_bone("skull", bone(16'700'000, 150, 70'000'000), {.partition = true, .cold = true, .from_file = true});
    }

    /// 5 M segments in one, two and four planes: as one contour a plane, and as many small ones.
    void add_few_planes() {
        constexpr std::uint32_t sides = 64;
        const std::uint64_t all = scaled(few_planes_segments);
        for (const int planes : {1, 2, 4}) {
            const std::uint64_t facets = all / static_cast<std::uint64_t>(planes);
            const auto count = static_cast<std::uint32_t>(facets / (2 * sides));
            const std::string suffix = "_planes" + std::to_string(planes);
            add("columns" + suffix, "columns" + suffix, [=] { return make_columns(count, sides, few_planes_height_mm); },
                few(planes), {})
                .segments = all;
            const models::Recipe prism{.shape = models::Shape::prism,
                                       .triangles = facets * 2,
                                       .height_mm = few_planes_height_mm,
                                       .segments = all,
                                       .layer_height_mm = few_planes_height_mm / planes};
            add("prism" + suffix, "prism" + suffix, made(prism), few(planes), {}).segments = all;
        }
    }

    void add_constant_ratio(const std::string& name, std::uint64_t triangles, const Measured& measured) {
        const models::Recipe recipe{.shape = models::Shape::torus, .triangles = triangles / 2 * 2};
        Case& added = add(name, name, made(recipe), constant_ratio(), measured);
        added.triangles = recipe.triangles;
        added.segments = static_cast<std::uint64_t>(segments_per_triangle * static_cast<double>(triangles));
    }

    /// 10^4 to 10^7 triangles by half decades.
    void add_linear() {
        for (int half_decade = 8; half_decade <= 14; ++half_decade) {
            const auto triangles = static_cast<std::uint64_t>(std::llround(std::pow(10.0, half_decade / 2.0)));
            add_constant_ratio("linear_" + std::to_string(triangles), std::max<std::uint64_t>(scaled(triangles), 1'000), {});
        }
    }

    /// The same amount of work for each thread.
    void add_weak() {
        for (const int threads : thread_counts(options_)) {
            add_constant_ratio("weak_" + std::to_string(threads),
                               std::min(scaled(1'000'000) * static_cast<std::uint64_t>(threads), models::most_triangles),
                               {.single_use = true, .threads = threads});
        }
    }

    Options options_;
    std::vector<Case> cases_;
};

}  // namespace

bool take_option(std::string_view argument, Options& options) {
    const std::size_t equals = std::min(argument.find('='), argument.size());
    const std::string_view name = argument.substr(0, equals);
    const std::string value(argument.substr(std::min(equals + 1, argument.size())));
    if (name == "--quick") {
        options.quick = true;
    } else if (name == "--cache") {
        options.cache = value;
    } else if (name == "--shared") {
        options.shared = value;
    } else if (name == "--max-threads") {
        options.max_threads = std::max(0, std::atoi(value.c_str()));
    } else {
        return false;
    }
    return true;
}

std::vector<int> thread_counts(const Options& options) {
    const int cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
    const int most = options.max_threads > 0 ? options.max_threads : cores;
    std::vector<int> counts;
    for (int threads = 1; threads < most; threads *= 2) {
        counts.push_back(threads);
    }
    counts.push_back(most);
    return counts;
}

std::vector<Case> make_catalogue(const Options& options) {
    return CatalogueMaker(options).make();
}

}  // namespace lamella::bench
