#include "view_core.hpp"

#include <emscripten.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>

#include "io/write/json.hpp"
#include "lamella/io.hpp"
#include "lamella/lamella.hpp"
#include "lamella/tracks.hpp"

// clang-format off
EM_JS(void, tell_progress, (double fraction), { Module["progress"] && Module["progress"](fraction); });
// clang-format on

namespace lamella::view {

namespace {

constexpr double most_layers = 1e6;  ///< a curve of more takes longer than anyone waits
constexpr std::uint64_t preview_triangles = 200'000;

/// A call that cannot do what it was asked for.
struct Refusal {
    std::string line;
};

template <class T>
T value_of(Result<T> result) {
    if (!result) {
        throw Refusal{result.error().message};
    }
    return std::move(result).value();
}

struct OpenMesh {
    MeshFile file;
    std::optional<PreparedMesh> prepared{};
    Box box{};
    std::array<double, 3> centre{};
};

struct Page {
    std::unique_ptr<OpenMesh> mesh;
    SliceOptions options;
    std::vector<Slab> slabs;  ///< of the plan
    Slicer slicer;
    SliceResult shown, pair;  ///< the layer that is seen; layers that are compared
    std::uint64_t next = 0;   ///< layer of the sweep
    std::optional<LayerHash> hash;
    OpenLayers open;  ///< of the sweep so far
    std::uint64_t gaps = 0;
    double longest_gap_mm = 0;
    // Answers.
    std::string text;
    std::vector<float> floats, more_floats;
    std::vector<double> rows;
    std::vector<std::uint32_t> starts;
};

Page& page() {
    static Page& only = *new Page;
    return only;
}

Context context() {
    static auto tell = [](double fraction) noexcept { tell_progress(fraction); };
    return {.threads = 1, .progress = tell, .memory_limit_bytes = std::uint64_t{1} << 31};
}

template <class Body>
int answer(const Body& body) noexcept {
    Page& p = page();
    try {
        p.text.clear();
        p.floats.clear();
        p.more_floats.clear();
        p.rows.clear();
        p.starts.clear();
        if (!p.mesh) {
            throw Refusal{"no mesh is open"};
        }
        body(p);
        return 1;
    } catch (const Refusal& refusal) {
        p.text = utf8_text(refusal.line);
    } catch (...) {
        p.text = "out of memory";
    }
    return 0;
}

template <class Members>
std::string json(const Members& members) {
    JsonText text;
    text.object([&] { members(text); });
    return std::move(text).take();
}

std::unique_ptr<OpenMesh> read(const char* path, double mm_per_unit, const char* name) {
    auto mesh = std::make_unique<OpenMesh>();
    const std::uint64_t limit = std::uint64_t{3} << 30;  // of the 4 GB that a page has
    mesh->file =
        value_of(read_mesh(path, {.mm_per_unit = mm_per_unit, .name = name, .memory_limit_bytes = limit}, context()));
    mesh->prepared.emplace(value_of(prepare(mesh->file.view(), {}, context())));
    Slicer slicer;
    mesh->box = value_of(slicer.outline(*mesh->prepared, {.heights_mm = std::vector<double>()}, context())).box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        mesh->centre[axis] = (mesh->box.min_mm[axis] + mesh->box.max_mm[axis]) / 2;
    }
    return mesh;
}

std::string describe(const OpenMesh& mesh) {
    return json([&](JsonText& text) {
        text.member("format", name_of(mesh.file.format));
        text.member("triangles", mesh.file.triangle_count);
        text.member("mm_per_unit", mesh.file.mm_per_unit);
        text.member("states_unit", mesh.file.states_unit);
        text.member("min", mesh.box.min_mm);
        text.member("max", mesh.box.max_mm);
        text.list("parts", mesh.file.parts, 10'000, [&](const MeshPart& part) { text.value(utf8_text(part.name)); });
        text.list("warnings", mesh.file.warnings, 100, [&](const std::string& line) { text.value(utf8_text(line)); });
    });
}

/// The slabs of a plan; options that cannot be are refused.
std::vector<Slab> slabs_of(Page& p, SliceOptions& options, double cusp_mm) {
    const double height = options.layer_height_mm;
    const double bottom = p.mesh->box.min_mm[2];
    if (!(height > 0) || !((p.mesh->box.max_mm[2] - bottom) / height <= most_layers)) {
        throw Refusal{"a layer height must be above 0 mm and give at most a million layers"};
    }
    if (cusp_mm > 0) {
        const Array<Slab> made = value_of(adaptive_layers(
            p.mesh->file.view(), {.least_mm = height / 4, .most_mm = height, .step_mm = height / 40, .cusp_mm = cusp_mm},
            context()));
        options.slabs = {made.begin(), made.end()};
    }
    SliceOptions lowest = options;
    lowest.planes.end_layer = 1;
    const SliceInfo info = value_of(p.slicer.slice_to(p.pair, *p.mesh->prepared, lowest, {.threads = 1}));
    std::vector<Slab> slabs = options.slabs;
    for (std::uint64_t i = slabs.size(); i < info.planned_layers; ++i) {
        slabs.push_back({bottom + height * static_cast<double>(i), bottom + height * static_cast<double>(i + 1)});
    }
    return slabs;
}

/// Layers [first, end) of the plan.
void slice_range(Page& p, SliceResult& to, std::uint64_t first, std::uint64_t end, bool origins) {
    if (end > p.slabs.size() || first >= end) {
        throw Refusal{"there is no such layer"};
    }
    SliceOptions options = p.options;
    options.planes.first_layer = first;
    options.planes.end_layer = end;
    options.origins = origins;
    value_of(p.slicer.slice_to(to, *p.mesh->prepared, options, {.threads = 1}));
}

/// Points that lie half a pixel or more from the one before, and both ends.
void append_drawn(Page& p, const LayerView& layer, const Contour& contour, double pixel_mm) {
    const std::span<const Point> points = layer.points_of(contour);
    const double least = pixel_mm * pixel_mm / 4;
    PointMm last{};
    for (std::size_t i = 0; i < points.size(); ++i) {
        const PointMm at = layer.to_mm(points[i]);
        const double dx = at.x - last.x, dy = at.y - last.y;
        if (i == 0 || i + 1 == points.size() || dx * dx + dy * dy >= least) {
            p.floats.push_back(static_cast<float>(at.x - p.mesh->centre[0]));
            p.floats.push_back(static_cast<float>(at.y - p.mesh->centre[1]));
            last = at;
        }
    }
    p.starts.push_back(static_cast<std::uint32_t>(p.floats.size() / 2));
}

double length_of(const LayerView& layer, const Contour& contour) {
    const std::span<const Point> points = layer.points_of(contour);
    double units = 0;
    for (std::size_t i = contour.role == Role::open ? 1 : 0; i < points.size(); ++i) {
        const Point& from = points[i == 0 ? points.size() - 1 : i - 1];
        units += std::hypot(static_cast<double>(points[i].x) - from.x, static_cast<double>(points[i].y) - from.y);
    }
    return units * layer.grid_mm;
}

/// The file's part that a contour begins in; 0 where it states none.
double part_of(const MeshFile& file, const LayerView& layer, const Contour& contour) {
    const std::uint32_t triangle = layer.origins.empty() ? no_triangle : layer.origins_of(contour).front().triangle;
    const auto found = std::find_if(file.parts.begin(), file.parts.end(), [&](const MeshPart& part) {
        return triangle != no_triangle && triangle >= part.first_triangle &&
               triangle - part.first_triangle < part.triangle_count;
    });
    return found == file.parts.end() ? 0 : static_cast<double>(found - file.parts.begin());
}

/// Area of closed contours, contours, holes, open ones: a row of the curve.
std::array<double, 4> sums_of(const LayerView& layer) {
    std::array<double, 4> sums{0, static_cast<double>(layer.contours.size()), 0, 0};
    for (const Contour& contour : layer.contours) {
        sums[0] += layer.area_mm2(contour);
        sums[2] += contour.role == Role::hole ? 1 : 0;
        sums[3] += contour.role == Role::open ? 1 : 0;
    }
    return sums;
}

void append_place(std::vector<float>& to, const std::array<double, 3>& mm, const std::array<double, 3>& centre) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        to.push_back(static_cast<float>(mm[axis] - centre[axis]));
    }
}

}  // namespace

extern "C" {

/// What an answer holds: 0 floats, 1 more floats, 2 rows, 3 starts; -1: the text. `size` counts numbers, or bytes of text.
EMSCRIPTEN_KEEPALIVE const void* view_data(int which) {
    Page& p = page();
    const std::array<const void*, 5> data{p.text.data(), p.floats.data(), p.more_floats.data(), p.rows.data(),
                                          p.starts.data()};
    return data[static_cast<std::size_t>(which + 1)];
}
EMSCRIPTEN_KEEPALIVE std::size_t view_size(int which) {
    Page& p = page();
    const std::array<std::size_t, 5> sizes{p.text.size(), p.floats.size(), p.more_floats.size(), p.rows.size(),
                                           p.starts.size()};
    return sizes[static_cast<std::size_t>(which + 1)];
}

/// Reads a file in place of the mesh, which stays where it cannot be read. Text: what it is.
EMSCRIPTEN_KEEPALIVE int view_open(const char* path, double mm_per_unit, const char* name) {
    std::unique_ptr<OpenMesh> mesh;
    Page& p = page();
    try {
        mesh = read(path, mm_per_unit, name);
    } catch (const Refusal& refusal) {
        p.text = printable(refusal.line);
        return 0;
    } catch (...) {
        p.text = "out of memory";
        return 0;
    }
    p.mesh = std::move(mesh);
    p.slabs.clear();
    return answer([](Page& now) { now.text = describe(*now.mesh); });
}

/// Chooses layers and begins a sweep; `cusp_mm` above 0: as high as the surface allows. Rows: bottom and top of each.
EMSCRIPTEN_KEEPALIVE int view_plan(double height_mm, double cusp_mm, double stitch_mm, double closing_mm, int rule) {
    return answer([&](Page& p) {
        SliceOptions options{.layer_height_mm = height_mm, .stitch_mm = stitch_mm};
        options.region.fill_rule = static_cast<FillRule>(rule);
        options.region.closing_mm = closing_mm;
        std::vector<Slab> slabs = slabs_of(p, options, cusp_mm);
        for (const Slab& slab : slabs) {
            p.rows.insert(p.rows.end(), {slab.bottom_mm, slab.top_mm});
        }
        p.options = std::move(options);
        p.slabs = std::move(slabs);
        p.next = 0;
        p.hash.emplace(p.slabs.size());
        p.open = {};
        p.gaps = 0;
        p.longest_gap_mm = 0;
    });
}

/// One layer as it is seen. Floats: points about the centre; starts: where contours end; rows of contours: role, part,
/// parent, points, length, area; more floats: joined gaps.
EMSCRIPTEN_KEEPALIVE int view_layer(std::uint32_t index, double pixel_mm) {
    return answer([&](Page& p) {
        slice_range(p, p.shown, index, index + 1, p.mesh->file.parts.size() > 1);
        const LayerView layer = p.shown[0];
        for (const Contour& contour : layer.contours) {
            append_drawn(p, layer, contour, pixel_mm);
            p.rows.insert(p.rows.end(), {static_cast<double>(contour.role), part_of(p.mesh->file, layer, contour),
                                         static_cast<double>(contour.parent), static_cast<double>(contour.point_count),
                                         length_of(layer, contour), layer.area_mm2(contour)});
        }
        for (const Stitch& stitch : layer.stitches) {
            for (const Point end : {stitch.from, stitch.to}) {
                const PointMm mm = layer.to_mm(end);
                p.more_floats.push_back(static_cast<float>(mm.x - p.mesh->centre[0]));
                p.more_floats.push_back(static_cast<float>(mm.y - p.mesh->centre[1]));
            }
        }
    });
}

/// The next `count` layers of the sweep. Rows as sums_of(); at its end, text: the hash, the gaps that were joined, and what
/// is said of open layers, a line each.
EMSCRIPTEN_KEEPALIVE int view_sweep(std::uint32_t count) {
    return answer([&](Page& p) {
        const std::uint64_t end = std::min<std::uint64_t>(p.next + count, p.slabs.size());
        if (p.next < end) {
            slice_range(p, p.pair, p.next, end, false);
            for (const LayerView layer : p.pair) {
                p.hash->add(layer);
                const std::array<double, 4> sums = sums_of(layer);
                p.rows.insert(p.rows.end(), sums.begin(), sums.end());
                p.open.add(value_of(find_open_layer(layer, p.options.stitch_direction)));
                p.gaps += layer.stitches.size();
                for (const Stitch& stitch : layer.stitches) {
                    const PointMm from = layer.to_mm(stitch.from);
                    const PointMm to = layer.to_mm(stitch.to);
                    p.longest_gap_mm = std::max(p.longest_gap_mm, std::hypot(to.x - from.x, to.y - from.y));
                }
            }
            p.next = end;
        }
        if (p.next == p.slabs.size()) {
            char words[100];
            std::snprintf(words, sizeof words, "%016llx\n%llu joined, the longest %.4g mm\n",
                          static_cast<unsigned long long>(p.hash->value()), static_cast<unsigned long long>(p.gaps),
                          p.longest_gap_mm);
            p.text = words + (p.open.layers > 0 ? describe(p.open, "stitch ") : std::string());
        }
    });
}

/// Islands of layers [first, end) with nothing below. Rows: layer, contour in it, x, y, area.
EMSCRIPTEN_KEEPALIVE int view_islands(std::uint32_t first, std::uint32_t end) {
    return answer([&](Page& p) {
        const std::uint32_t from = std::max<std::uint32_t>(first, 1) - 1;
        if (end <= from + 1) {
            return;  // the lowest layer stands on the bed
        }
        slice_range(p, p.pair, from, end, false);
        const Tracks tracks = value_of(find_tracks(p.pair, {}, {.threads = 1}));
        for (const Track& island : tracks.islands) {
            if (island.below == 0 && island.layer > 0) {
                const std::uint64_t contour =
                    island.contour - p.pair.layers[static_cast<std::size_t>(island.layer)].first_contour;
                p.rows.insert(p.rows.end(), {static_cast<double>(from + island.layer), static_cast<double>(contour),
                                             island.centroid_mm[0], island.centroid_mm[1], island.area_mm2});
            }
        }
    });
}

/// What of a layer reaches further beyond the one below than walls that lean by so much from upright. Floats and starts as
/// of a layer; rows: its area.
EMSCRIPTEN_KEEPALIVE int view_overhang(std::uint32_t index, double degrees, double pixel_mm) {
    return answer([&](Page& p) {
        if (index == 0) {
            p.rows.push_back(0);
            return;
        }
        slice_range(p, p.pair, index - 1, index + 1, false);
        const double step = p.pair.layers[1].plane_mm - p.pair.layers[0].plane_mm;
        const double reach = std::max(step * std::tan(degrees * 3.14159265358979323846 / 180), 0.001);
        const LayerSet sets[] = {{.layers = p.pair}, {.layers = p.pair, .from = -1, .to = -1, .grow_mm = reach}};
        SliceResult left;
        Overlay overlay;
        value_of(overlay.combine(left, sets, subtract, {}, {.threads = 1}));
        const LayerView layer = left[1];
        for (const Contour& contour : layer.contours) {
            append_drawn(p, layer, contour, pixel_mm);
        }
        p.rows.push_back(sums_of(layer)[0]);
    });
}

/// Floats: triangles to look at, about the centre.
EMSCRIPTEN_KEEPALIVE int view_preview() {
    return answer([](Page& p) { p.floats = preview(p.mesh->file.view(), p.mesh->centre, p.mesh->box, preview_triangles); });
}

/// Floats: lines; more floats: points, about the centre. Text: the verdict, and each kind of fault with its count.
EMSCRIPTEN_KEEPALIVE int view_check(std::uint32_t most_places) {
    return answer([&](Page& p) {
        const MeshCheck check = value_of(lamella::check(p.mesh->file.view(), {.most_places = most_places}, context()));
        const std::string verdict = value_of(make_verdict(check));
        p.text = json([&](JsonText& text) {
            text.member("verdict", std::string_view(verdict));
            text.objects("faults", check.findings, fault_count, [&](const FaultFinding& finding) {
                const auto fault = static_cast<Fault>(&finding - check.findings.data());
                text.member("name", words_for(fault, finding.count));
                text.member("count", finding.count);
            });
        });
        for (const FaultFinding& finding : check.findings) {
            for (const FaultPlace& place : finding.places) {
                const auto points = static_cast<std::size_t>(place.point_count);
                for (std::size_t i = 0; points > 1 && i < points; ++i) {
                    append_place(p.floats, place.points_mm[i], p.mesh->centre);
                    append_place(p.floats, place.points_mm[(i + 1) % points], p.mesh->centre);
                }
                append_place(p.more_floats, place.points_mm[0], p.mesh->centre);
            }
        }
    });
}

/// Writes layers [first, end) as the tool does.
EMSCRIPTEN_KEEPALIVE int view_svg(std::uint32_t first, std::uint32_t end, const char* path) {
    return answer([&](Page& p) {
        slice_range(p, p.pair, first, end, false);
        value_of(write_layers(p.pair, path));
    });
}

}  // extern "C"

}  // namespace lamella::view
