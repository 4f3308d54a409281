// Files of layers, read back by readers written from the formats' texts alone; by programs of others: tests/readers.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>
#include <functional>
#include <sstream>
#include <thread>

#include "engine/slicing.hpp"
#include "lamella/io/layer_file.hpp"
#include "temp_folder.hpp"

using namespace lamella;
using Catch::Contains;

namespace {

using Xy = std::array<double, 2>;

struct CliLine {
    int label = 0;
    int direction = 0;
    std::vector<Xy> points;

    double area() const {
        double twice = 0;
        for (std::size_t i = 1; i < points.size(); ++i) {
            twice += points[i - 1][0] * points[i][1] - points[i - 1][1] * points[i][0];
        }
        return twice / 2;
    }
};
struct CliLayer {
    double z = 0;
    std::vector<CliLine> lines{};
};

/// CLI 2.0 in both forms, coordinates in mm.
struct CliFile {
    explicit CliFile(const std::string& all) : header(all.substr(0, all.find("$$HEADEREND"))) {
        REQUIRE(header.starts_with("$$HEADERSTART\n"));
        CHECK_THAT(header, Contains("$$VERSION/200\n"));
        unit = std::stod(header.substr(header.find("$$UNITS/") + 8));
        std::string body = all.substr(header.size() + 11);
        if (header.find("$$BINARY") != std::string::npos) {
            read_records(body);
            return;
        }
        std::replace_if(
            body.begin(), body.end(), [](char c) { return c == '/' || c == ','; }, ' ');
        std::istringstream words(body);
        std::vector<std::string> others;
        for (std::string word; words >> word;) {
            if (word == "$$LAYER") {
                layers.push_back({next<double>(words) * unit});
            } else if (word == "$$POLYLINE") {
                const int label = next<int>(words);
                const int direction = next<int>(words);
                add(label, direction, next<std::size_t>(words), [&] { return next<double>(words); });
            } else {
                others.push_back(word);
            }
        }
        CHECK(others == std::vector<std::string>{"$$GEOMETRYSTART", "$$GEOMETRYEND"});
    }

    std::string header;
    double unit = 1;
    std::vector<CliLayer> layers;

private:
    template <class Number>
    static Number next(std::istream& words) {
        Number number{};
        REQUIRE(words >> number);
        return number;
    }

    void add(int label, int direction, std::size_t points, const std::function<double()>& coordinate) {
        CliLine line{label, direction, std::vector<Xy>(points)};
        for (Xy& point : line.points) {
            point[0] = coordinate() * unit;
            point[1] = coordinate() * unit;
        }
        layers.at(layers.size() - 1).lines.push_back(line);
    }

    void read_records(const std::string& body) {
        std::size_t at = 0;
        const auto read = [&](auto number) {
            REQUIRE(at + sizeof number <= body.size());
            std::memcpy(&number, body.data() + at, sizeof number);
            at += sizeof number;
            return number;
        };
        while (at < body.size()) {
            const auto code = read(std::uint16_t{});
            if (code == 127) {
                layers.push_back({read(0.0F) * unit});
                continue;
            }
            REQUIRE(code == 130);
            const int label = read(std::int32_t{});
            const int direction = read(std::int32_t{});
            add(label, direction, static_cast<std::size_t>(read(std::int32_t{})), [&] { return double{read(0.0F)}; });
        }
    }
};

SliceOptions by_rule(double layer_height_mm = 1) {
    SliceOptions options{.layer_height_mm = layer_height_mm};
    options.region.fill_rule = FillRule::non_zero;
    options.region.drop_collinear = true;
    return options;
}

shapes::Soup cube(double x = 0) {
    return shapes::box({x, 0, 0}, {x + 10, 10, 10});
}
shapes::Soup cube_with_hole() {
    return shapes::joined({cube(), shapes::flipped(shapes::box({3, 3, -1}, {7, 7, 11}))});
}
/// Ten layers of a square that lacks an edge.
SliceResult open_cube() {
    return sliced(shapes::without(cube(), 4, 1), by_rule());
}

CliFile cli_of(const SliceResult& result, std::string_view format) {
    const TempFolder folder;
    CHECK(value_of(write_layers(result, folder / "a.cli", {.format = format})).layers == result.size());
    return CliFile(bytes_of(folder / "a.cli"));
}

/// Refused in these words, and nothing is left.
void require_refused(const SliceResult& result, const std::string& name, const std::string& words) {
    const TempFolder folder;
    const Error error = error_of(done(write_layers(result, folder / name)));
    CHECK(error.code == ErrorCode::invalid_argument);
    CHECK_THAT(error.message, Contains(words) && Contains(name));
    CHECK(folder.names().empty());
}

}  // namespace

TEST_CASE("layer files: CLI states upper surfaces above an empty layer, and closes contours", "[write][layers]") {
    const SliceResult result = sliced(cube(), by_rule());
    for (const std::string_view format : {"cli", "cli-text"}) {
        const CliFile file = cli_of(result, format);
        CHECK_THAT(file.header, Contains("\n$$LABEL/1,part 1\n$$DIMENSION/0,0,0,10,10,10\n$$LAYERS/11\n"));
        REQUIRE(file.layers.size() == 11);
        for (std::size_t i = 0; i < file.layers.size(); ++i) {
            CHECK(file.layers[i].z == static_cast<double>(i));
            REQUIRE(file.layers[i].lines.size() == (i == 0 ? 0 : 1));
            for (const CliLine& line : file.layers[i].lines) {
                CHECK((line.label == 1 && line.direction == 1 && line.points.size() == 5));
                CHECK(line.points.front() == line.points.back());
                CHECK(line.area() == 100);
            }
        }
    }
    const TempFolder folder;
    const LayerFileSummary summary = value_of(write_layers(result, folder / "a.cli"));
    CHECK((summary.format->name == "cli" && summary.rounding_mm == 0 && summary.contours == 10));
    const std::string bytes = bytes_of(folder / "a.cli");
    const std::size_t data = bytes.find("$$HEADEREND") + 11;
    CHECK(bytes.size() == data + 11 * 6 + 10 * 54);
    CHECK(bytes.substr(data, 6) == std::string("\x7F\0\0\0\0\0", 6));
}

TEST_CASE("layer files: CLI tells holes, open contours and parts", "[write][layers]") {
    const std::string_view format = GENERATE("cli", "cli-text");
    for (const CliLayer& layer : cli_of(sliced(cube_with_hole(), by_rule()), format).layers) {
        if (layer.z > 0.5 && layer.z <= 10) {
            REQUIRE(layer.lines.size() == 2);
            CHECK((layer.lines[0].direction == 1 && layer.lines[0].area() == 100));
            CHECK((layer.lines[1].direction == 0 && layer.lines[1].area() == -16));
        }
    }
    const SliceResult open = open_cube();
    std::size_t open_lines = 0;
    for (const CliLayer& layer : cli_of(open, format).layers) {
        for (const CliLine& line : layer.lines) {
            CHECK(line.direction == 2);
            CHECK(line.points.front() != line.points.back());
            ++open_lines;
        }
    }
    CHECK(open_lines == open.contours.size());
    const CliFile moved = cli_of(sliced(cube(-5), by_rule()), format);
    CHECK(moved.layers.at(1).lines.at(0).points.at(0)[0] == -5);

    const shapes::Soup first = cube();
    const shapes::Soup second = cube(20);
    const SliceResult both = sliced(std::vector<Part>{{.mesh = view_of(first)}, {.mesh = view_of(second)}}, by_rule());
    const TempFolder folder;
    const std::vector<std::string> names = {"a,b//c"};
    const LayerFileSummary summary = value_of(write_layers(both, folder / "a.cli", {.format = format, .part_names = names}));
    CHECK(summary.names_changed == 1);
    const CliFile parts(bytes_of(folder / "a.cli"));
    CHECK_THAT(parts.header, Contains("\n$$LABEL/1,a_b__c\n$$LABEL/2,part 2\n"));
    REQUIRE(parts.layers.at(1).lines.size() == 2);
    CHECK((parts.layers[1].lines[0].label == 1 && parts.layers[1].lines[1].label == 2));
}

TEST_CASE("layer files: what a format cannot hold is refused with its count", "[write][layers]") {
    const SliceResult open = open_cube();
    require_refused(open, "a.3mf", "10 of 10 layers have open contours, the first at z = 0.5 mm, which 3mf-slices");
    const TempFolder folder;
    const auto left_out = value_of(write_layers(open, folder / "a.3mf", {.leave_out_open = true}));
    CHECK((left_out.open_left_out == 10 && left_out.contours == open.contours.size() - 10));
    CHECK(value_of(write_layers(open, folder / "a.geojson")).open_left_out == 0);

    SliceOptions kept{.layer_height_mm = 1};
    const shapes::Soup crossing = shapes::joined({cube(), cube(5)});
    for (const char* const name : {"a.3mf", "a.geojson"}) {
        require_refused(sliced(crossing, kept), name, "needs a fill rule: without one contours may cross");
        value_of(write_layers(sliced(crossing, by_rule()), folder / name));
        value_of(write_layers(sliced(cube_with_hole(), by_rule()), folder / name));
    }
    value_of(write_layers(sliced(crossing, kept), folder / "a.dxf"));
    SliceOptions close = by_rule();
    close.heights_mm = {1000.00001, 1000.00002};
    require_refused(sliced(shapes::box({0, 0, 900}, {10, 10, 1100}), close), "a.3mf", "do not ascend as 32-bit floats");
    require_refused(open, "a.xyz", "its name ends as no layer file does: .svg, .cli, .3mf, .dxf, .geojson, .vtp");
}

TEST_CASE("layer files: a file a layer is numbered as in the plan", "[write][layers]") {
    SliceOptions options = by_rule();
    options.planes.first_layer = 8;
    const SliceResult result = sliced(cube(), options);
    const TempFolder folder;
    CHECK(value_of(write_layers(result, folder / "{layer:03}.svg")).files == 2);
    CHECK(value_of(write_layers(result, folder / "a{layer}.dxf")).files == 2);
    CHECK(folder.names() == std::vector<std::string>{"008.svg", "009.svg", "a8.dxf", "a9.dxf"});
    CHECK_THAT(bytes_of(folder / "a9.dxf"), Contains("Z00009") && Contains("\n30\n9.5\n") && !Contains("Z00008"));
    require_refused(result, "{layer}.cli", "cli holds all layers in one file");
    require_refused(result, "{layer:5}.svg", "numbers of layers are {layer}, or {layer:05} for five digits");
}

TEST_CASE("layer files: what ends early leaves nothing", "[write][layers][control]") {
    const SliceResult result = sliced(generated(models::Shape::gyroid, 20'000), by_rule(0.1));
    const TempFolder folder;
    for (const LayerFormat& format : layer_formats()) {
        INFO(format.name);
        LayerFileOptions options{.format = format.name};
        if (format.on_screen) {
            options.screen = {.width = 500, .height = 400, .pixel_x_mm = 1, .pixel_y_mm = 1};
        }
        for (const std::string name : {"a", "{layer}"}) {
            const std::filesystem::path path = folder / (name + std::string(format.ending));
            if (name == "{layer}" && !format.single_layers) {
                continue;
            }
            value_of(write_layers(result, path, options));
            CHECK(folder.names().size() == (name == "a" ? 1 : result.size()));
            for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
                std::filesystem::remove(entry);
            }
            for (const std::size_t from : {std::size_t{0}, result.size() / 2, result.size() - 1}) {
                bool asked = false;
                const auto stop = [&asked]() noexcept { return asked; };
                LayerFile file = value_of(LayerFile::begin(result.info, path, options, {.stop = stop}));
                for (std::size_t layer = 0; layer < from; ++layer) {
                    file.add(result[layer]);
                }
                asked = true;
                std::this_thread::sleep_for(std::chrono::milliseconds(3));  // hosts are asked every two
                file.add(result[from]);
                CHECK(code_of(file.finish()) == ErrorCode::cancelled);
            }
            CHECK(folder.names().empty());
            {
                LayerFile file = value_of(LayerFile::begin(result.info, path, options));
                file.add(result[0]);
            }
            CHECK(folder.names().empty());
        }
        CHECK(code_of(write_layers(result, "/dev/full", options)) == ErrorCode::unwritable_file);
    }
}

TEST_CASE("layer files: the table in the docs is that of the formats", "[write][layers]") {
    const std::string table = bytes_of(LAMELLA_LAYER_FILES_PAGE);
    for (const LayerFormat& format : layer_formats()) {
        const auto word = [](bool can) { return can ? " yes |" : " no |"; };
        const std::array<const char*, 3> heights = {"bottom", "plane", "top"};
        const std::string row = "| `" + std::string(format.name) + "` | `" + std::string(format.ending) + "` | " +
                                std::string(format.what) + " | " + heights[static_cast<std::size_t>(format.height)] + " |" +
                                word(format.open_contours) + word(format.uneven_heights) + word(format.single_layers) +
                                word(format.parts) + word(format.crossings) + word(format.on_screen);
        INFO(row);
        CHECK(table.find(row) != std::string::npos);
    }
}
