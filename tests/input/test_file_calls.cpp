// What a Context promises, of calls on files.
#include "input/file_calls.hpp"
#include "input/files.hpp"

using namespace lamella;
using namespace input_test;

namespace {

TEST_CASE("reading and writing refuse negative threads, end when asked to, and show rising progress up to 1",
          "[input][control][threads]") {
    const TempFolder folder;
    const SliceResult result = sliced(shapes::octasphere({0, 0, 0}, 5, 4), uniform(0.1));
    const auto file = folder.write("a.stl", binary_stl(numbered_facets(5000)));
    for (const ContextCall& call : file_calls(file, result, folder / "a.svg")) {
        require_obedient(call);
    }
}

TEST_CASE("reading and writing fail cleanly at each of their allocations", "[input][faults]") {
    const TempFolder folder;
    const SliceResult result = sliced(everything(), uniform(0.1));
    for (const std::string& bytes : {binary_stl(numbered_facets(500)), text_stl(numbered_facets(500))}) {
        const auto file = folder.write("a.stl", bytes);
        for (const ContextCall& call : file_calls(file, result, folder / "a.svg")) {
            for (const int threads : {1, 3}) {
                INFO(call.name << ", " << threads << " threads");
                CHECK((fail_everywhere(call.run, {.threads = threads}) > 0 || call.name != "read_mesh"));
            }
        }
    }
}

TEST_CASE("what is documented as noexcept of files and reports is", "[input][control]") {
    const MeshCheck check;
    const SliceResult result;
    STATIC_REQUIRE(noexcept(make_verdict(check)));
    STATIC_REQUIRE(noexcept(make_report_json(result)));
    STATIC_REQUIRE(noexcept(format_names()));
}

}  // namespace
