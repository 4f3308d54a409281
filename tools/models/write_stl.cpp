#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <new>

#include "io/write/output_file.hpp"
#include "models/models.hpp"
#include "models/surface.hpp"

namespace lamella::models {

static_assert(std::endian::native == std::endian::little, "STL is little-endian and written as memory holds it");

namespace {

constexpr std::size_t header_bytes = 80;
constexpr std::size_t record_bytes = sizeof(Vertex) + sizeof(Triangle) + sizeof(std::uint16_t);
static_assert(record_bytes == 50);

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

}  // namespace lamella::models
