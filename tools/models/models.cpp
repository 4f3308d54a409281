#include "models/models.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>
#include <new>
#include <string>
#include <utility>

#include "io/write/output_file.hpp"
#include "models/numbers.hpp"
#include "models/surface.hpp"

namespace lamella::models {

static_assert(std::endian::native == std::endian::little, "STL is little-endian and written as memory holds it");

namespace {

// Maps floats to unsigned integers of the same order.
std::uint32_t ordered_bits(float value) noexcept {
    const auto bits = std::bit_cast<std::uint32_t>(value + 0.0F);  // -0 becomes +0
    return (bits >> 31) != 0 ? ~bits : bits | 0x80000000U;
}

float centre(float a, float b, float c) noexcept {
    return static_cast<float>((static_cast<double>(a) + static_cast<double>(b) + static_cast<double>(c)) / 3);
}

}  // namespace

Emitter::Emitter(const Consumer& consume, std::uint64_t candidates, std::uint64_t splits)
    : consume_(consume), candidates_(candidates), splits_(splits), due_(candidates - candidates / 4) {
    assert(splits <= candidates);
}

void Emitter::add_splittable(const Triangle& triangle) {
    due_ += splits_;
    if (due_ < candidates_ || splits_ == 0) {
        add(triangle);
        return;
    }
    due_ -= candidates_;
    const auto& [a, b, c] = triangle;
    const Vertex g{centre(a.x, b.x, c.x), centre(a.y, b.y, c.y), centre(a.z, b.z, c.z)};
    add({a, b, g});
    add({b, c, g});
    add({c, a, g});
}

bool Emitter::flush() {
    assert(pending_.size() <= std::numeric_limits<std::uint32_t>::max());
    keys_.resize(pending_.size());
    for (std::size_t i = 0; i < pending_.size(); ++i) {
        const auto& [a, b, c] = pending_[i];
        keys_[i] = std::uint64_t{ordered_bits(std::min({a.z, b.z, c.z}))} << 32 | i;
    }
    std::sort(keys_.begin(), keys_.end());
    sorted_.resize(pending_.size());
    for (std::size_t i = 0; i < keys_.size(); ++i) {
        sorted_[i] = pending_[keys_[i] & 0xffffffffU];
    }
    pending_.clear();
    stopped_ = stopped_ || !consume_(sorted_);
    return !stopped_;
}

Error unreachable(const Recipe& recipe, double nearest) {
    std::string message = "a " + std::string(shape_names[static_cast<std::size_t>(recipe.shape)]) + " of " +
                          std::to_string(recipe.triangles) + " triangles and this size cannot be made";
    if (recipe.segments) {
        message += " with " + std::to_string(*recipe.segments) + " segments at this layer height: the nearest tried has " +
                   std::to_string(static_cast<std::uint64_t>(nearest));
    }
    return {ErrorCode::invalid_argument, std::move(message)};
}

namespace {

constexpr std::size_t header_bytes = 80;
constexpr std::size_t record_bytes = sizeof(Vertex) + sizeof(Triangle) + sizeof(std::uint16_t);
static_assert(record_bytes == 50);

Status check(const Recipe& recipe) {
    const auto out_of_range = [](const char* what, const char* range) {
        return Error{ErrorCode::invalid_argument, std::string(what) + ": must lie " + range};
    };
    const auto length_ok = [](double mm) { return mm >= 1e-3 && mm <= 1e6; };
    if (recipe.triangles < fewest_triangles || recipe.triangles > most_triangles) {
        return out_of_range("triangles", "between 100 and 1000000000");
    }
    if (recipe.order == Order::random && recipe.triangles > most_shuffled) {
        return out_of_range("triangles", "between 100 and 100000000 where their order is random");
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

// All triangles in the recipe's order. The random order is Fisher and Yates's shuffle.
std::vector<Triangle> collect(const Recipe& recipe, const Surface& surface) {
    std::vector<Triangle> all;
    all.reserve(surface.triangles);
    surface.emit([&](std::span<const Triangle> batch) {
        all.insert(all.end(), batch.begin(), batch.end());
        return true;
    });
    assert(all.size() == surface.triangles);
    if (recipe.order == Order::random) {
        Random random(recipe.seed);
        for (auto left = static_cast<std::uint32_t>(all.size()); left > 1; --left) {
            std::swap(all[left - 1], all[random.below(left)]);
        }
    }
    return all;
}

Vertex unit_normal(const Triangle& t) noexcept {
    const auto from_a = [&](const Vertex& to) {
        const auto minus = [](float a, float b) { return static_cast<double>(a) - static_cast<double>(b); };
        return std::array{minus(to.x, t.a.x), minus(to.y, t.a.y), minus(to.z, t.a.z)};
    };
    const auto [ux, uy, uz] = from_a(t.b);
    const auto [vx, vy, vz] = from_a(t.c);
    const std::array<double, 3> normal{uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx};
    const double length = std::sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    const double scale = length > 0 ? 1 / length : 0;
    return {static_cast<float>(normal[0] * scale), static_cast<float>(normal[1] * scale),
            static_cast<float>(normal[2] * scale)};
}

void append_header(std::uint64_t triangles, OutputFile& file) {
    std::array<char, header_bytes> header{"binary STL, a sample mesh made by lamella"};
    const auto count = static_cast<std::uint32_t>(triangles);
    file.append({header.data(), header.size()});
    file.append({reinterpret_cast<const char*>(&count), sizeof count});
}

void append(std::span<const Triangle> triangles, OutputFile& file) {
    for (const Triangle& triangle : triangles) {
        const Vertex normal = unit_normal(triangle);
        char* const record = file.room(record_bytes);
        std::memcpy(record, &normal, sizeof normal);
        std::memcpy(record + sizeof normal, &triangle, sizeof triangle);
        std::memset(record + sizeof normal + sizeof triangle, 0, sizeof(std::uint16_t));
        file.advance(record + record_bytes);
    }
}

}  // namespace

Result<std::uint64_t> write_stl(const Recipe& recipe, const std::filesystem::path& path, const Callback<bool()>& stop) try {
    const auto stopped = [&] { return stop && stop(); };
    Plan planned = plan(recipe);
    if (!planned) {
        return planned.error();
    }
    const Surface& surface = *planned;
    Result<OutputFile> file = OutputFile::create(path);
    if (!file) {
        return file.error();
    }
    append_header(surface.triangles, *file);
    if (recipe.order == Order::random) {
        append(collect(recipe, surface), *file);
    } else {
        surface.emit([&](std::span<const Triangle> batch) {
            append(batch, *file);
            return !stopped() && !file->failed();
        });
    }
    if (stopped()) {
        return Error{ErrorCode::cancelled, path.string() + ": interrupted"};
    }
    if (const Status status = file->commit(); !status) {
        return status.error();
    }
    return surface.triangles;
} catch (const std::bad_alloc&) {
    return Error{ErrorCode::out_of_memory, path.string() + ": out of memory while making the mesh"};
}

std::vector<float> make_soup(const Recipe& recipe) {
    Plan planned = plan(recipe);
    if (!planned) {
        return {};
    }
    const std::vector<Triangle> triangles = collect(recipe, *planned);
    std::vector<float> soup(triangles.size() * 9);
    if (!triangles.empty()) {
        std::memcpy(soup.data(), triangles.data(), soup.size() * sizeof(float));
    }
    return soup;
}

}  // namespace lamella::models
