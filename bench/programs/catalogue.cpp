#include "catalogue.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/parallel.hpp"
#include "lamella/io.hpp"
#include "lamella/lamella.hpp"
#include "timing.hpp"

namespace lamella::bench {

namespace {

constexpr std::uint64_t few_planes_segments = 5'000'000;
constexpr double few_planes_height_mm = 10;
constexpr double segments_per_triangle = 5;  // for the linear series and for weak scaling

/// Random steps with as many planes as uniform layers on average.
Plan irregular(const Mesh&) {
    return {{}, {.random_heights = RandomHeights{layer_mm / 2, layer_mm * 3 / 2, 1}}};
}

/// Layers of the height that gives `segments_per_triangle`.
Plan constant_ratio(const Mesh& mesh) {
    double rise_mm = 0;  // of all triangles; divided by the layer height, it gives the crossings
    for (std::size_t t = 0; t < mesh.soup.size(); t += 9) {
        const auto [low, high] = std::minmax({mesh.soup[t + 2], mesh.soup[t + 5], mesh.soup[t + 8]});
        rise_mm += static_cast<double>(high) - static_cast<double>(low);
    }
    return {{.layer_height_mm = rise_mm / (segments_per_triangle * static_cast<double>(mesh.triangles()))}};
}

/// `count` planes, evenly spaced between the lowest and the highest vertex.
Plan few(const Mesh& mesh, int count) {
    const Box box = checked(Slicer().outline(mesh.view())).box;
    std::vector<double> heights_mm;
    heights_mm.reserve(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) {
        heights_mm.push_back(box.min_mm[2] + (box.max_mm[2] - box.min_mm[2]) * (i + 0.5) / count);
    }
    return {{.heights_mm = heights_mm}};
}

/// `count` prisms of so many sides on a square lattice of 1 mm.
Mesh make_columns(std::uint32_t count, std::uint32_t sides) {
    const std::vector<float> column = models::make_soup(
        {.shape = models::Shape::prism, .triangles = 4 * sides - 4, .height_mm = few_planes_height_mm, .width_mm = 0.8});
    const auto row = static_cast<std::size_t>(std::ceil(std::sqrt(count)));
    Mesh mesh;
    mesh.soup.resize_discarding(column.size() * count);
    for (std::size_t i = 0; i < mesh.soup.size(); ++i) {
        const std::size_t number = i / column.size();
        const std::size_t shift = i % 3 == 0 ? number % row : i % 3 == 1 ? number / row : 0;
        mesh.soup[i] = column[i % column.size()] + static_cast<float>(shift);
    }
    return mesh;
}

/// Adds cases to a catalogue.
struct Maker {
    Options options;
    std::vector<Case> cases{};

    std::uint64_t scaled(std::uint64_t count) const { return options.quick ? count / 100 : count; }

    Case from_recipe(const std::string& name, const models::Recipe& recipe) const {
        return {.name = name,
                .mesh_name = name,
                .mesh = [=, all = options] { return load_mesh(cached_mesh(all, name, recipe)); },
                .triangles = recipe.triangles,
                .segments = recipe.segments.value_or(0)};
    }

    /// The same mesh at irregular planes.
    void add_irregular(const Case& uniform) {
        cases.push_back(
            {.name = uniform.name + "_irregular", .mesh_name = uniform.mesh_name, .mesh = uniform.mesh, .plan = irregular});
    }

    /// Real meshes. Where one is absent, a bone of about as many triangles replaces it, under a name that says so.
    void add_real(const std::string& name, const std::optional<KnownAnswer>& known) {
        const std::filesystem::path file = options.shared / (name + ".stl");
        const bool there = std::filesystem::exists(file);
        Case real{.name = name, .mesh_name = name, .mesh = [=] { return load_mesh(file); }, .known = known};
        if (!there) {
            real = from_recipe("instead_of_real", {.shape = models::Shape::bone, .triangles = 40'000});
            real.name = "instead_of_" + name;
        }
        real.from_file = true;
        real.hosts = real.regions = real.partition = name != "hip_femur";
        if (there || known) {
            cases.push_back(real);
        }
        if (there) {
            add_irregular(real);
        }
    }

    /// A bone of the stated size. With --quick it is smaller, and its number of segments is not controlled.
    void add_bone(const std::string& name, std::uint64_t triangles, double height_mm, std::uint64_t segments,
                  models::Order order = models::Order::z) {
        models::Recipe recipe{.shape = models::Shape::bone, .triangles = scaled(triangles), .height_mm = height_mm};
        recipe.order = order;
        if (!options.quick) {
            recipe.segments = segments;
            recipe.layer_height_mm = layer_mm;
        }
        Case bone = from_recipe(name, recipe);
        bone.from_file = order == models::Order::z;
        bone.hosts = name == "scan";
        bone.partition = bone.from_file;
        cases.push_back(bone);
        if (bone.hosts) {
            add_irregular(bone);
        }
    }

    /// 5 M segments in so many planes: as many small contours, and as one contour a plane.
    void add_few_planes(int planes) {
        constexpr std::uint32_t sides = 64;
        const std::uint64_t all = scaled(few_planes_segments);
        const std::uint64_t facets = all / static_cast<std::uint64_t>(planes);
        const std::string end = "_planes" + std::to_string(planes);
        Case prism = from_recipe("prism" + end, {.shape = models::Shape::prism,
                                                 .triangles = facets * 2,
                                                 .height_mm = few_planes_height_mm,
                                                 .segments = all,
                                                 .layer_height_mm = few_planes_height_mm / planes});
        prism.plan = [=](const Mesh& at) { return few(at, planes); };
        prism.triangles = 0;
        Case columns = prism;
        columns.name = columns.mesh_name = "columns" + end;
        columns.mesh = [=] { return make_columns(static_cast<std::uint32_t>(facets / (2 * sides)), sides); };
        cases.push_back(columns);
        cases.push_back(prism);
    }

    Case& add_torus(const std::string& name, std::uint64_t triangles) {
        Case torus = from_recipe(name, {.shape = models::Shape::torus, .triangles = triangles / 2 * 2});
        torus.plan = constant_ratio;
        torus.segments = static_cast<std::uint64_t>(segments_per_triangle * static_cast<double>(triangles));
        return cases.emplace_back(torus);
    }
};

}  // namespace

std::vector<int> thread_counts() {
    const int most = Parallel().threads();  // that this process may use
    std::vector<int> counts;
    for (int threads = 1; threads < most; threads *= 2) {
        counts.push_back(threads);
    }
    counts.push_back(most);
    return counts;
}

Mesh load_mesh(const std::filesystem::path& file) {
    const MeshFile stl = checked(read_mesh(file));
    const MeshView view = stl.view();
    Mesh mesh;
    mesh.file = file;
    mesh.soup.resize_discarding(9 * stl.triangle_count);
    Parallel().run_ranges(stl.triangle_count, 1 << 14, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t t = begin; t < end; ++t) {
            std::memcpy(mesh.soup.data() + 9 * t, view.vertex_at(t), 9 * sizeof(float));
        }
    });
    return mesh;
}

std::filesystem::path cached_mesh(const Options& options, const std::string& name, const models::Recipe& recipe) {
    std::filesystem::path file = options.cache / (name + ".stl");
    if (!std::filesystem::exists(file)) {
        std::filesystem::create_directories(options.cache);
        checked(models::write_stl(recipe, file));
    }
    return file;
}

std::vector<Case> make_catalogue(const Options& options) {
    Maker maker{options};
    maker.add_real("liver", KnownAnswer{6'242, 2'342'005, 15'790, 0});
    maker.add_real("femur", KnownAnswer{3'155, 1'180'826, 3'338, 0});
    maker.add_real("brain", {});
    maker.add_real("hip_femur", {});
    maker.add_bone("scan", 3'400'000, 150, 18'000'000);
    maker.add_bone("scan_shuffled", 3'400'000, 150, 18'000'000, models::Order::random);
    maker.add_bone("figure", 8'800'000, 10, 1'100'000);
    maker.add_bone("skull", 16'700'000, 150, 70'000'000);
    for (const int planes : {1, 2, 4}) {
        maker.add_few_planes(planes);
    }
    for (int half_decade = 8; half_decade <= 14; ++half_decade) {  // 10^4 to 10^7 triangles
        const auto triangles = static_cast<std::uint64_t>(std::llround(std::pow(10.0, half_decade / 2.0)));
        maker.add_torus("linear_" + std::to_string(triangles), std::max<std::uint64_t>(maker.scaled(triangles), 1'000));
    }
    for (const int threads : thread_counts()) {  // the same amount of work for each thread
        const std::uint64_t triangles = maker.scaled(1'000'000) * static_cast<std::uint64_t>(threads);
        maker.add_torus("weak_" + std::to_string(threads), std::min(triangles, models::most_triangles)).only_threads =
            threads;
    }
    return std::move(maker.cases);
}

}  // namespace lamella::bench
