// Real meshes, sliced by the engine and in exact arithmetic, at few planes. Half of them are at heights of vertices.
#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "exact/judge.hpp"
#include "exact/meshes.hpp"
#include "lamella/mesh/inspect.hpp"
#include "models_shared/real_meshes.hpp"

namespace {

constexpr std::size_t planes = 6;

}  // namespace

TEST_CASE("contours of real meshes equal the exact ones", "[models]") {
    for (const std::filesystem::path& file : real_meshes()) {
        INFO(file);
        const shapes::Soup soup = soup_of(file);
        const double unit_mm = inspect(view_of(soup))->unit_mm;
        for (const std::uint64_t seed : {0U, 3U}) {
            const lamella::SliceResult result = sliced(soup, exact::through_vertices(soup, unit_mm, seed, planes));
            INFO("seed " << seed);
            REQUIRE_THAT(exact::difference(result, oracle::quantise(soup, unit_mm)), Catch::Equals(""));
        }
    }
}
