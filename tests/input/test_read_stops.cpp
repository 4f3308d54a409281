// A stop that comes while a file is read ends the reading soon, in every format and on every way through its reader.
#include <cstdint>
#include <filesystem>
#include <limits>
#include <random>

#include "cpu_time.hpp"
#include "engine/slicing.hpp"
#include "lamella/io.hpp"
#include "sheet_files.hpp"

namespace lamella {
namespace {

using namespace input_test;

#ifdef LAMELLA_TESTS_SANITIZED
constexpr std::uint32_t side = 80;
constexpr double most_ms_late = 2000;
constexpr double always_short_ms = 200;
#else
constexpr std::uint32_t side = 390;  // 304,200 triangles
constexpr double most_ms_late = 100;
constexpr double always_short_ms = 10;  // of a piece of text, and of a row of pages
#endif

Result<MeshFile> read_with(const std::filesystem::path& path, int threads, const Callback<bool()>& stop = {}) {
    return read_mesh(path, {.memory_limit_bytes = std::uint64_t{2} << 30}, {.threads = threads, .stop = stop});
}

double ms_to_read(const std::filesystem::path& path, int threads, const Callback<bool()>& stop = {}) {
    const double start = cpu_ms();
    value_of(read_with(path, threads, stop));
    return cpu_ms() - start;
}

/// All but the slowest of some reads must keep the bound.
void check_stops(const std::filesystem::path& path, int threads, std::mt19937& random) {
    const double whole = ms_to_read(path, threads);
    std::vector<double> late;
    for (int round = 0; round < 3; ++round) {
        const double end = cpu_ms() + std::uniform_real_distribution<double>(0, whole)(random);
        auto stop = [end]() noexcept { return cpu_ms() >= end; };
        const Result<MeshFile> mesh = read_with(path, threads, stop);
        if (!mesh.ok()) {
            CHECK(mesh.error().code == ErrorCode::cancelled);
            late.push_back(cpu_ms() - end);
        }
    }
    std::sort(late.begin(), late.end());
    INFO("of " << whole << " ms");
    CHECK((late.size() < 2 || late[late.size() - 2] <= threads * most_ms_late));
}

/// A file of a gigabyte takes a hundred times as long: what asks only once in each pass over this one would ask too late.
void check_intervals(const std::filesystem::path& path) {
    double longest = std::numeric_limits<double>::max();
    double whole = longest;
    for (int round = 0; round < 3; ++round) {
        double last = cpu_ms();
        double not_asked = 0;
        auto note = [&]() noexcept {
            not_asked = std::max(not_asked, cpu_ms() - last);
            last = cpu_ms();
            return false;
        };
        whole = std::min(whole, ms_to_read(path, 1, note));
        note();
        longest = std::min(longest, not_asked);
    }
    INFO("not asked for " << longest << " of " << whole << " ms");
    CHECK(longest <= std::max(always_short_ms, whole / 4));
}

TEST_CASE("a stop that comes at any moment ends the reading of a file within 100 ms", "[input][control][stops]") {
    const TempFolder dir;
    std::mt19937 random(1);
    for (const SheetFile& file : sheet_files) {
        const std::filesystem::path path = dir.write(file.name, bytes_of(file, side));
        for (const int threads : {1, 2}) {
            INFO(file.name << " on " << threads << " threads");
            check_stops(path, threads, random);
        }
        INFO(file.name);
        check_intervals(path);
    }
}

}  // namespace
}  // namespace lamella
