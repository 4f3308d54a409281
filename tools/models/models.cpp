#include "models/models.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <new>
#include <string>
#include <system_error>
#include <utility>

#include "models/numbers.hpp"
#include "models/surface.hpp"

namespace lamella::models {

static_assert(std::endian::native == std::endian::little, "STL is little-endian and written as memory holds it");

std::optional<Shape> shape_from_name(std::string_view name) noexcept {
    for (std::size_t i = 0; i < shape_names.size(); ++i) {
        if (shape_names[i] == name) {
            return static_cast<Shape>(i);
        }
    }
    return std::nullopt;
}

namespace {

constexpr std::size_t header_bytes = 80;
constexpr std::size_t record_bytes = 50;

Status check(const Recipe& recipe) {
    const auto out_of_range = [](const char* what, const char* range) {
        return Error{Code::invalid_argument, std::string(what) + ": must lie " + range};
    };
    const auto length_ok = [](double mm) { return mm >= 1e-3 && mm <= 1e6; };
    if (recipe.triangles < fewest_triangles || recipe.triangles > most_triangles) {
        return out_of_range("triangles", "between 100 and 100000000");
    }
    if (!length_ok(recipe.height_mm) || (recipe.width_mm && !length_ok(*recipe.width_mm))) {
        return out_of_range(length_ok(recipe.height_mm) ? "width" : "height", "between 0.001 and 1000000 mm");
    }
    if (recipe.segments && !(recipe.layer_height_mm > 0 && recipe.layer_height_mm <= recipe.height_mm)) {
        return out_of_range("layer height", "above 0 and within the height where segments are given");
    }
    if (recipe.segments && *recipe.segments == 0) {
        return out_of_range("segments", "above 0");
    }
    return {};
}

Plan plan(const Recipe& recipe) {
    if (const Status status = check(recipe); !status) {
        return status.error();
    }
    const bool rings = recipe.shape == Shape::sphere || recipe.shape == Shape::prism;
    return rings ? plan_rings(recipe) : plan_isosurface(recipe);
}

// All triangles in the recipe's order: Fisher and Yates's shuffle where that is random.
std::vector<Triangle> collect(const Recipe& recipe, Surface& surface) {
    std::vector<Triangle> all;
    all.reserve(surface.triangles());
    surface.emit([&](std::span<const Triangle> batch) {
        all.insert(all.end(), batch.begin(), batch.end());
        return true;
    });
    assert(all.size() == surface.triangles());
    if (recipe.order == Order::random) {
        Random random(recipe.seed);
        for (auto left = static_cast<std::uint32_t>(all.size()); left > 1; --left) {
            std::swap(all[left - 1], all[random.below(left)]);
        }
    }
    return all;
}

Vertex unit_normal(const Triangle& t) noexcept {
    const auto minus = [](float a, float b) { return static_cast<double>(a) - static_cast<double>(b); };
    const double ux = minus(t.b.x, t.a.x);
    const double uy = minus(t.b.y, t.a.y);
    const double uz = minus(t.b.z, t.a.z);
    const double vx = minus(t.c.x, t.a.x);
    const double vy = minus(t.c.y, t.a.y);
    const double vz = minus(t.c.z, t.a.z);
    const double x = uy * vz - uz * vy;
    const double y = uz * vx - ux * vz;
    const double z = ux * vy - uy * vx;
    const double length = std::sqrt(x * x + y * y + z * z);
    const double scale = length > 0 ? 1 / length : 0;
    return {static_cast<float>(x * scale), static_cast<float>(y * scale), static_cast<float>(z * scale)};
}

// A binary STL file under a name of its own until it is complete; removed unless it gets there.
class StlFile {
public:
    StlFile(std::filesystem::path path, std::uint64_t triangles) : path_(std::move(path)), aside_(path_) {
        aside_ += ".part";
        file_.reset(std::fopen(aside_.c_str(), "wb"));
        char header[header_bytes + sizeof(std::uint32_t)] = "binary STL, a sample mesh made by lamella";
        const auto count = static_cast<std::uint32_t>(triangles);
        std::memcpy(header + header_bytes, &count, sizeof count);
        ok_ = file_ != nullptr && std::fwrite(header, sizeof header, 1, file_.get()) == 1;
    }
    StlFile(const StlFile&) = delete;
    StlFile& operator=(const StlFile&) = delete;
    ~StlFile() {
        if (!finished_) {
            file_.reset();
            std::error_code ignored;
            std::filesystem::remove(aside_, ignored);
        }
    }

    bool append(std::span<const Triangle> triangles) {
        constexpr std::size_t records = 4096;
        for (std::size_t at = 0; ok_ && at < triangles.size(); at += records) {
            const auto part = triangles.subspan(at, std::min(records, triangles.size() - at));
            buffer_.assign(part.size() * record_bytes, '\0');
            char* out = buffer_.data();
            for (const Triangle& triangle : part) {
                const Vertex normal = unit_normal(triangle);
                std::memcpy(out, &normal, sizeof normal);
                std::memcpy(out + sizeof normal, &triangle, sizeof triangle);
                out += record_bytes;
            }
            ok_ = std::fwrite(buffer_.data(), buffer_.size(), 1, file_.get()) == 1;
        }
        return ok_;
    }

    Status finish() {
        std::error_code failed;
        if (ok_ && std::fclose(file_.release()) == 0) {
            std::filesystem::rename(aside_, path_, failed);
        } else {
            failed = std::error_code(errno, std::generic_category());
        }
        if (failed) {
            return Error{Code::unwritable_file, path_.string() + ": cannot be written: " + failed.message()};
        }
        finished_ = true;
        return {};
    }

private:
    struct Close {
        void operator()(std::FILE* file) const noexcept { std::fclose(file); }
    };
    std::filesystem::path path_;
    std::filesystem::path aside_;
    std::unique_ptr<std::FILE, Close> file_;
    bool ok_ = false;
    bool finished_ = false;
    std::vector<char> buffer_;
};

}  // namespace

Result<std::uint64_t> write_stl(const Recipe& recipe, const std::filesystem::path& path) try {
    Plan planned = plan(recipe);
    if (!planned) {
        return planned.error();
    }
    Surface& surface = **planned;
    StlFile file(path, surface.triangles());
    if (recipe.order == Order::random) {
        file.append(collect(recipe, surface));
    } else {
        surface.emit([&](std::span<const Triangle> batch) { return file.append(batch); });
    }
    if (const Status status = file.finish(); !status) {
        return status.error();
    }
    return surface.triangles();
} catch (const std::bad_alloc&) {
    return Error{Code::out_of_memory, path.string() + ": out of memory while making the mesh"};
}

std::vector<float> make_soup(const Recipe& recipe) {
    Plan planned = plan(recipe);
    if (!planned) {
        return {};
    }
    const std::vector<Triangle> triangles = collect(recipe, **planned);
    std::vector<float> soup(triangles.size() * 9);
    if (!triangles.empty()) {
        std::memcpy(soup.data(), triangles.data(), soup.size() * sizeof(float));
    }
    return soup;
}

}  // namespace lamella::models
