// glTF 2.0: the meshes of a scene, each as often as nodes place it. Y stays up, and lengths are metres.
#include <unordered_set>

#include "base/words.hpp"
#include "io/read/faces.hpp"
#include "io/read/gltf/gltf_file.hpp"
#include "io/read/stated.hpp"
#include "io/read/transforms.hpp"

namespace lamella {

namespace {

/// Three points each, or a strip or fan of them. Lower modes are points and lines.
enum class GltfMode : std::uint8_t { triangles = 4, strip, fan };

struct GltfPrimitive {
    GltfMode mode = GltfMode::triangles;
    GltfNumbers points{};
    GltfNumbers indices{};  ///< of the points, a corner each; none: the points in their order
    std::uint64_t triangles = 0;

    std::array<std::uint64_t, 3> corners_of(std::uint64_t triangle) const noexcept {
        const std::uint64_t odd = triangle % 2;  // every other triangle of a strip is listed in reverse
        return mode == GltfMode::strip ? std::array{triangle + odd, triangle + 1 - odd, triangle + 2}
               : mode == GltfMode::fan ? std::array{std::uint64_t{0}, triangle + 1, triangle + 2}
                                       : std::array{3 * triangle, 3 * triangle + 1, 3 * triangle + 2};
    }
};

/// A primitive where a node places it.
struct GltfPlaced {
    GltfPrimitive primitive;
    Transform transform;
    std::uint64_t first_point;
    std::uint64_t first_triangle;
};

/// The numbers of a list. Throws TextErrors.
template <std::size_t n>
std::array<double, n> gltf_numbers(const GltfFile& file, const JsonNode& list, const std::array<double, n>& otherwise) {
    std::array<double, n> numbers = otherwise;
    const auto is_number = [](const JsonNode& item) { return item.kind == JsonNode::Kind::number; };
    if (list && (list.items.size() != n || !std::all_of(list.items.begin(), list.items.end(), is_number))) {
        file.fail(list, "expected " + std::to_string(n) + " numbers as " + in_quotes(list.key));
    }
    std::transform(list.items.begin(), list.items.end(), numbers.begin(), [](const JsonNode& item) { return item.number; });
    return numbers;
}

Transform gltf_transform(const GltfFile& file, const JsonNode& node) {
    if (node["matrix"]) {
        const auto by_columns = gltf_numbers<16>(file, node["matrix"], {});
        if (by_columns[3] != 0 || by_columns[7] != 0 || by_columns[11] != 0 || by_columns[15] != 1) {
            file.fail(node["matrix"], "expected a matrix whose last row is 0 0 0 1");
        }
        Transform transform;
        for (std::size_t i = 0; i < 12; ++i) {
            transform.m[i] = by_columns[i % 4 * 4 + i / 4];
        }
        return transform;
    }
    const std::array<double, 3> t = gltf_numbers<3>(file, node["translation"], {0, 0, 0});
    const auto [x, y, z, w] = gltf_numbers<4>(file, node["rotation"], {0, 0, 0, 1});
    const std::array<double, 3> s = gltf_numbers<3>(file, node["scale"], {1, 1, 1});
    const double f = 2 / (x * x + y * y + z * z + w * w);  // of whatever length the quaternion is
    return {{(1 - f * (y * y + z * z)) * s[0], f * (x * y - z * w) * s[1], f * (x * z + y * w) * s[2], t[0],
             f * (x * y + z * w) * s[0], (1 - f * (x * x + z * z)) * s[1], f * (y * z - x * w) * s[2], t[1],
             f * (x * z - y * w) * s[0], f * (y * z + x * w) * s[1], (1 - f * (x * x + y * y)) * s[2], t[2]}};
}

/// What the nodes of the scene place: all members throw TextErrors and Refused.
class GltfScene {
public:
    explicit GltfScene(GltfFile& file) : file_(file) {}

    /// Goes through the nodes of the default scene, else the first.
    void list() {
        const JsonNode& root = file_.root();
        if (!root["scenes"].items.empty()) {
            const JsonNode& scene = root["scene"] ? file_.item("scenes", root["scene"]) : root["scenes"].items.front();
            for (const JsonNode& index : scene["nodes"].items) {
                place_from(file_.item("nodes", index), index);
            }
        }
        for (const JsonNode& node : root["nodes"].items) {
            hidden += node["mesh"] && !met_.contains(&node) ? 1 : 0;
        }
    }

    std::vector<GltfPlaced> placed;
    std::uint64_t points = 0;
    std::uint64_t triangles = 0;
    PartMarks parts;           ///< one for each node that places a mesh
    std::uint64_t others = 0;  ///< primitives without triangles
    std::uint64_t hidden = 0;  ///< nodes that place meshes in another scene

private:
    struct Open {
        const JsonNode* node;
        const JsonNode* by;
        Transform outer;
    };

    /// A node may be met once, which ends cycles, and nodes in each other that would be met 2^40 times.
    void place_from(const JsonNode& root, const JsonNode& by) {
        open_.push_back({&root, &by, {}});
        while (!open_.empty()) {
            pace_.spend(step_work);
            const Open open = open_.back();
            open_.pop_back();
            if (!met_.insert(open.node).second) {
                file_.fail(*open.by, "this node is within itself, or in two places");
            }
            const Transform transform = open.outer * gltf_transform(file_, *open.node);
            const std::vector<JsonNode>& children = (*open.node)["children"].items;
            std::for_each(children.rbegin(), children.rend(), [&](const JsonNode& index) {
                open_.push_back({&file_.item("nodes", index), &index, transform});
            });
            if ((*open.node)["mesh"]) {
                place_mesh(*open.node, transform);
            }
        }
    }

    void place_mesh(const JsonNode& node, const Transform& transform) {
        const JsonNode& mesh = file_.item("meshes", node["mesh"]);
        if (!std::isfinite(determinant(transform.m))) {
            file_.fail(node, "the transform of this node is no finite one");
        }
        refuse_moved(node);
        refuse_moved(mesh);
        const std::string_view name = (node["name"].text.empty() ? mesh : node)["name"].text;
        add_mark(parts, triangles, false, name.data(), name.data() + name.size());
        const std::size_t before = placed.size();
        for (const JsonNode& own : mesh["primitives"].items) {
            pace_.spend(step_work);
            file_.budget.take(1, 2 * sizeof(GltfPlaced));
            const GltfPrimitive primitive = primitive_of(own);
            const bool shares =
                placed.size() > before && placed.back().primitive.points.accessor == primitive.points.accessor;
            placed.push_back({primitive, transform, shares ? placed.back().first_point : points, triangles});
            points = std::max(points, placed.back().first_point + primitive.points.count);
            triangles += primitive.triangles;
            others += primitive.triangles == 0 ? 1 : 0;
        }
    }

    void refuse_moved(const JsonNode& by) const {
        const std::vector<JsonNode>& weights = by["weights"].items;
        if (by["skin"] || std::any_of(weights.begin(), weights.end(), [](const JsonNode& w) { return w.number != 0; })) {
            file_.fail(by, "a skin or morph targets move the points here, which is not read");
        }
    }

    GltfPrimitive primitive_of(const JsonNode& own) {
        const std::uint64_t mode = file_.integer(own["mode"], 4);
        if (mode > 6) {
            file_.fail(own["mode"], "expected a 'mode' from 0 to 6");
        }
        GltfPrimitive primitive{static_cast<GltfMode>(mode)};
        if (primitive.mode < GltfMode::triangles) {
            return primitive;
        }
        const JsonNode& position = own["attributes"]["POSITION"];
        if (!position) {
            file_.fail(own, "expected the attribute POSITION of this primitive");
        }
        primitive.points = file_.numbers(position, true);
        if (own["indices"]) {
            primitive.indices = file_.numbers(own["indices"], false);
        }
        const std::uint64_t corners = own["indices"] ? primitive.indices.count : primitive.points.count;
        const bool apart = primitive.mode == GltfMode::triangles;
        if (corners < 3 || (apart && corners % 3 != 0)) {
            file_.fail(own, "its " + counted(corners, "corner") + " make no whole triangles");
        }
        primitive.triangles = apart ? corners / 3 : corners - 2;
        return primitive;
    }

    GltfFile& file_;
    StopPace pace_ = pace_of(file_.source.parallel());
    std::vector<Open> open_;
    std::unordered_set<const JsonNode*> met_;
};

/// Writes the points [begin, end) where they are placed.
void put_gltf_points(const GltfPlaced& placed, std::uint64_t begin, std::uint64_t end, MeshFile& mesh) {
    const GltfNumbers& points = placed.primitive.points;
    std::byte* out = mesh.bytes.data() + (placed.first_point + begin) * mesh.stride;
    for (std::uint64_t i = begin; i < end; ++i, out += mesh.stride) {
        const std::byte* const at = points.first + i * points.stride;
        const std::array<double, 3> xyz =
            moved(placed.transform,
                  {load_number<float>(at, false), load_number<float>(at + 4, false), load_number<float>(at + 8, false)});
        std::memcpy(out, xyz.data(), sizeof xyz);
    }
}

/// Writes the triangles [begin, end), turned where the transform mirrors them. Throws TextErrors.
void put_gltf_triangles(const GltfFile& file, const GltfPlaced& placed, std::uint64_t begin, std::uint64_t end,
                        MeshFile& mesh) {
    const GltfPrimitive& primitive = placed.primitive;
    const bool mirrored = determinant(placed.transform.m) < 0;
    std::uint32_t* out = mesh.indices.data() + 3 * (placed.first_triangle + begin);
    for (std::uint64_t i = begin; i < end; ++i, out += 3) {
        const std::array<std::uint64_t, 3> corners = primitive.corners_of(i);
        for (std::size_t k = 0; k < 3; ++k) {
            const bool listed = primitive.indices.count > 0;
            const std::uint64_t point = listed ? primitive.indices.integer(corners[k]) : corners[k];
            if (point >= primitive.points.count) {
                file.fail(*primitive.indices.accessor, "number " + std::to_string(corners[k]) + " of these is point " +
                                                           std::to_string(point) + ", of " +
                                                           std::to_string(primitive.points.count));
            }
            out[k == 0 || !mirrored ? k : 3 - k] = static_cast<std::uint32_t>(placed.first_point + point);
        }
    }
}

void put_gltf(const GltfFile& file, const std::vector<GltfPlaced>& all, MeshFile& mesh) {
    constexpr std::uint64_t grain = std::uint64_t{1} << 14;
    for (const GltfPlaced& placed : all) {
        const std::uint64_t points = placed.primitive.points.count;
        const std::uint64_t triangles = placed.primitive.triangles;
        parse_pieces((std::max(points, triangles) + grain - 1) / grain, file.source.parallel(), [&](std::size_t i, int) {
            const auto bound = [&](std::uint64_t count, std::size_t piece) { return std::min(count, piece * grain); };
            put_gltf_points(placed, bound(points, i), bound(points, i + 1), mesh);
            put_gltf_triangles(file, placed, bound(triangles, i), bound(triangles, i + 1), mesh);
        });
    }
}

/// Numbers of many files are mm, which metres make a thousand times as long.
void warn_of_metres(const FileSource& source, MeshFile& mesh) {
    const VertexCoordinates points = coordinates_of(mesh);
    std::array<double, 3> low = points[0];
    std::array<double, 3> high = low;
    pace_of(source.parallel()).in_stretches(0, mesh.vertex_count, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = 3 * begin; i < 3 * end; ++i) {
            const double value = points[static_cast<std::uint32_t>(i / 3)][i % 3];
            low[i % 3] = std::min(low[i % 3], value);
            high[i % 3] = std::max(high[i % 3], value);
        }
    });
    constexpr double longest_m = 10;
    const std::array<double, 3> sides = {high[0] - low[0], high[1] - low[1], high[2] - low[2]};
    if (*std::max_element(sides.begin(), sides.end()) > longest_m) {
        mesh.warnings.push_back(source.name() + ": is " + exact_text(std::round(sides[0])) + " x " +
                                exact_text(std::round(sides[1])) + " x " + exact_text(std::round(sides[2])) +
                                " m, as glTF is in metres; give the unit mm if its numbers are mm");
    }
}

}  // namespace

bool looks_like_gltf(const FileSource& source) {
    const std::string_view sample = without_byte_order_mark(source.sample());
    constexpr std::array<std::string_view, 5> lists = {"\"asset\"", "\"accessors\"", "\"bufferViews\"", "\"buffers\"",
                                                       "\"meshes\""};
    return source.sample().starts_with("glTF") ||
           (trimmed(sample.substr(0, 64), " \t\r\n").starts_with('{') &&
            std::any_of(lists.begin(), lists.end(), [&](auto name) { return sample.find(name) != std::string_view::npos; }));
}

void parse_gltf(FileContents& contents, MeshFile& mesh) {
    GltfFile file(contents);
    GltfScene scene(file);
    scene.list();
    if (scene.triangles == 0) {
        file.source.refuse(ErrorCode::empty_mesh, "holds no triangles in its scene");
    }
    if (scene.points >= most_vertices) {
        file.source.refuse(ErrorCode::out_of_memory, "places more points than 32-bit indices can tell apart");
    }
    allocate_vertices(scene.points, Number::f64, file.budget, file.source.memory(), mesh);
    file.budget.take(3 * scene.triangles, sizeof(std::uint32_t));
    mesh.indices = Array<std::uint32_t>(file.source.memory());
    mesh.indices.resize_discarding(3 * scene.triangles);
    mesh.triangle_count = scene.triangles;
    put_gltf(file, scene.placed, mesh);
    mesh.mm_per_unit = 1000;
    mesh.states_unit = !file.source.unit_is_given();
    if (mesh.states_unit) {
        warn_of_metres(file.source, mesh);
    }
    if (scene.parts.size() > 1 || !scene.parts.front().name.empty()) {
        give_parts(scene.parts, false, file.source.name(), mesh);
    }
    const auto warn_of = [&](std::uint64_t count, const std::string& what) {
        if (count > 0) {
            mesh.warnings.push_back(file.source.name() + ": " + what + std::to_string(count));
        }
    };
    warn_of(scene.others, "left out primitives of points or lines: ");
    warn_of(scene.hidden, "left out meshes of nodes that are not in the scene: ");
    warn_of(file.ignored_bytes(), "ignored bytes after the end of the binary glTF file: ");
}

}  // namespace lamella
