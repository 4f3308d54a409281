// Tests the functions that allocate by operator new, which this executable replaces. Each call is run with each of its
// allocations failing in turn. It must return an error and release all memory that it took.
#include <array>
#include <atomic>
#include <cstdlib>
#include <limits>
#include <new>

#include "base/parallel.hpp"
#include "input/file_calls.hpp"
#include "input/files.hpp"

namespace {

constexpr std::int64_t never = -1;

std::atomic<std::int64_t> left_until_failure{never};  ///< number of allocations that still succeed, unless it is `never`
std::atomic<bool> fails_once{false};                  ///< only one allocation fails; otherwise all later ones fail too
std::atomic<std::int64_t> failures{0};
std::atomic<std::int64_t> blocks_held{0};
std::atomic<std::int64_t> blocks_taken{0};

bool fails_now() noexcept {
    std::int64_t left = left_until_failure;
    while (left > 0 && !left_until_failure.compare_exchange_weak(left, left - 1)) {
    }
    return left == 0 && (failures++ == 0 || !fails_once);
}

void* take(std::size_t bytes, std::size_t alignment) noexcept {
    if (fails_now()) {
        return nullptr;
    }
    void* const memory = std::aligned_alloc(alignment, (bytes + alignment) / alignment * alignment);
    blocks_held += memory != nullptr ? 1 : 0;
    ++blocks_taken;
    return memory;
}

void* take_or_throw(std::size_t bytes, std::size_t alignment) {
    void* const memory = take(bytes, alignment);
    if (memory == nullptr) {
        throw std::bad_alloc();
    }
    return memory;
}

void give(void* memory) noexcept {
    blocks_held -= memory != nullptr ? 1 : 0;
    std::free(memory);
}

constexpr std::size_t usual = __STDCPP_DEFAULT_NEW_ALIGNMENT__;

}  // namespace

// Those of arrays call these.
void* operator new(std::size_t bytes) {
    return take_or_throw(bytes, usual);
}
void* operator new(std::size_t bytes, std::align_val_t alignment) {
    return take_or_throw(bytes, static_cast<std::size_t>(alignment));
}
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
    return take(bytes, usual);
}
void* operator new[](std::size_t bytes, const std::nothrow_t&) noexcept {
    return take(bytes, usual);
}
void operator delete(void* memory) noexcept {
    give(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
    give(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
    give(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
    give(memory);
}

namespace {

using lamella::ErrorCode;

/// The code with which a call failed, or nothing.
using Call = std::function<std::optional<ErrorCode>()>;

#ifdef LAMELLA_TESTS_SANITIZED
constexpr std::int64_t stride = 2;  // each allocation fails, in one of the two ways
#else
constexpr std::int64_t stride = 1;
#endif

/// Runs `call` with its first, second, ... allocation failing, once or for good, until it succeeds.
void fail_everywhere(const Call& call) {
    const std::optional<ErrorCode> expected = call();  // starts the threads now: they keep their memory
    for (const bool once : {true, false}) {
        std::int64_t succeed = once ? 0 : stride - 1;
        for (bool failed = true; failed; succeed += stride) {
            const std::int64_t held = blocks_held;
            fails_once = once;
            failures = 0;
            left_until_failure = succeed;
            const std::optional<ErrorCode> code = call();
            left_until_failure = never;
            const std::int64_t kept = blocks_held - held;
            failed = failures > 0;
            INFO("after " << succeed << " allocations, failing " << (once ? "once" : "for good"));
            REQUIRE(kept == 0);
            REQUIRE((code == expected || (failed && code == ErrorCode::out_of_memory)));
        }
        CHECK(succeed > 1);
    }
}

}  // namespace

TEST_CASE("every call survives failing operator new", "[faults]") {
    const TempFolder folder;
    const shapes::Soup soup = everything();
    using namespace lamella::input_test;
    const lamella::SliceResult result = sliced(soup, uniform(0.1));
    ContextCalls in_memory(view_of(soup), 0.4);
    const auto file = folder.write("a.stl", binary_stl(numbered_facets(50)));
    for (const ContextCall& call : file_calls(file, result, folder / "a.svg", in_memory.all_and_small())) {
        for (const int threads : {1, 3}) {
            INFO(call.name << ", " << threads << " threads");
            fail_everywhere([&] { return call.run({.threads = threads}); });
        }
    }
}

TEST_CASE("refused slices, and regions, survive failing operator new", "[faults]") {
    const shapes::Soup soup = everything();
    shapes::Soup broken = soup;
    broken[100] = 1e300;
    const lamella::RegionRules rules{.fill_rule = lamella::FillRule::non_zero,
                                     .closing_mm = 0.6,
                                     .offset_mm = -0.2,
                                     .simplify_mm = 0.1,
                                     .flag_closing_mm = 0.3,
                                     .drop_collinear = true};
    const lamella::SliceOptions filled{.layer_height_mm = 0.9, .stitch_mm = 2, .region = rules};
    const lamella::SliceOptions nowhere{.heights_mm = {{2, std::numeric_limits<double>::infinity()}}};
    const auto fails = [](const shapes::Soup& mesh, const lamella::SliceOptions& options, const lamella::Context& context) {
        fail_everywhere([&] { return code_of(slice(view_of(mesh), options, context)); });
    };
    fails(soup, filled, {});
    fails(broken, {}, {.threads = 1});
    fails(soup, nowhere, {.threads = 1});
    fails(soup, {}, {.threads = 1, .memory_limit_bytes = 1000});
    fails(soup, {}, {.threads = -1});
}

TEST_CASE("a slice with a kept Slicer takes no memory but for what it tells", "[faults]") {
    const shapes::Soup soup = GENERATE(shapes::box({0, 0, 0}, {4, 6, 8}), everything());
    const lamella::Result<lamella::PreparedMesh> prepared = prepare(view_of(soup));
    REQUIRE(prepared.ok());
    lamella::SliceOptions options = uniform(0.4);
    std::int64_t copies = 0;  // of listed heights and the layers that they are in, which a SliceInfo holds
    if (GENERATE(true, false)) {
        options.heights_mm = {3};
        copies = 5;
    }
#ifdef LAMELLA_PARALLEL_STD
    const lamella::Context context{.threads = 1};  // a std::thread takes memory
#else
    const lamella::Context context{.threads = GENERATE(1, 2, 0)};
#endif
    lamella::Slicer slicer;
    lamella::SliceResult result;
    // One thread has its memory after three calls. Another one has found nothing to do in some of them, and begins later.
    const int threads = lamella::Parallel::count_for(context);
    for (int call = 0, taking = 0; call < 3 * threads + 3; ++call) {
        const std::int64_t before = blocks_taken;
        REQUIRE(slicer.slice_to(result, view_of(soup), options, context).ok());
        REQUIRE(slicer.slice_to(result, *prepared, options, context).ok());
        const std::int64_t taken = blocks_taken - before;
        taking += taken > copies ? 1 : 0;
        CAPTURE(call, taken, taking);
        CHECK((threads == 1 ? call < 3 || taken <= copies : taking <= 3 * threads));
    }
}

/// How many blocks of operator new the region of so many overlapping squares takes, with the host's memory for all else.
std::int64_t blocks_of_region(std::int32_t squares, const lamella::RegionRules& rules) {
    struct Pool {
        void* allocate(std::size_t bytes, std::size_t) { return std::malloc(bytes); }
        void deallocate(void* memory, std::size_t, std::size_t) { std::free(memory); }
    } pool;
    const lamella::Memory memory = lamella::memory_of(pool);
    std::vector<std::array<lamella::Point, 4>> corners;
    for (std::int32_t i = 0; i < squares; ++i) {
        const std::int32_t at = 700 * i;
        corners.push_back({{{at, at}, {at + 1000, at}, {at + 1000, at + 1000}, {at, at + 1000}}});
        corners.push_back({{{-at - 900, at}, {-at - 200, at}, {-at - 200, at + 650}, {-at - 900, at + 650}}});
    }
    const std::vector<std::span<const lamella::Point>> contours(corners.begin(), corners.end());
    const std::int64_t before = blocks_taken;
    const auto region = lamella::region_of(contours, rules, 1, {.memory = &memory});
    const std::int64_t taken = blocks_taken - before;
    REQUIRE(region.ok());
    return taken;
}

TEST_CASE("regions take what grows with the layer from the host's memory", "[faults]") {
    lamella::RegionRules rules;
    rules.fill_rule = GENERATE(lamella::FillRule::even_odd, lamella::FillRule::outermost);
    rules.closing_mm = GENERATE(0, 40);
    rules.offset_mm = GENERATE(0, -5);
    rules.flag_closing_mm = GENERATE(0, 40);
    rules.drop_collinear = true;
    rules.simplify_mm = GENERATE(0, 3);
    CHECK(blocks_of_region(2, rules) == blocks_of_region(3000, rules));
}

TEST_CASE("reading survives failing operator new", "[faults]") {
    const TempFolder folder;
    const auto facets = lamella::input_test::numbered_facets(50);
    const std::string binary = lamella::input_test::binary_stl(facets);
    const std::string text = lamella::input_test::text_stl(facets);
    const std::vector<std::filesystem::path> paths = {folder.write("binary.stl", binary),
                                                      folder.write("text.stl", text),
                                                      folder.write("other.bin", binary),
                                                      folder.write("trailing.stl", binary + "more"),
                                                      folder.write("cut.stl", binary.substr(0, 1000)),
                                                      folder.write("cut_text.stl", text.substr(0, 1000)),
                                                      folder.write("page.stl", "<html></html>"),
                                                      folder / "missing.stl"};
    for (const std::filesystem::path& path : paths) {
        for (const bool map : {false, true}) {
            INFO(path.string());
            fail_everywhere([&] { return code_of(lamella::read_mesh(path, {.map_file = map}, {.threads = 2})); });
        }
    }
}

TEST_CASE("writing leaves no half-written file if operator new fails", "[faults]") {
    const TempFolder folder;
    const lamella::SliceResult result = sliced(everything(), uniform(0.4));
    const std::filesystem::path path = folder / "out.svg";
    bool tidy = true;  // checked after the loop, because Catch allocates memory too
    const auto left_alone = [&](const lamella::Status& status) {
        const std::int64_t left = left_until_failure.exchange(never);
        tidy = tidy && folder.names().size() == (status.ok() ? 1U : 0U);
        std::filesystem::remove(path);
        left_until_failure = left;
        return code_of(status);
    };
    fail_everywhere([&] { return left_alone(done(write_layers(result, path))); });
    fail_everywhere([&] { return left_alone(lamella::write_text_file(path, "text")); });
    CHECK(tidy);
    fail_everywhere([&] { return code_of(audits::structure_of(result)); });
}

TEST_CASE("reports, and an audit of all questions, survive failing operator new", "[faults]") {
    const TempFolder folder;
    const shapes::Soup soup = everything();
    const lamella::MeshView mesh = view_of(soup);
    const lamella::SliceResult result = sliced(soup, {.layer_height_mm = 0.4, .stitch_mm = 2});
    const auto file =
        lamella::read_mesh(folder.write("a.stl", lamella::input_test::binary_stl(lamella::input_test::numbered_facets(5))));
    const auto welded = lamella::weld(mesh);
    const auto audited = audit(result, mesh);
    const std::vector<std::string> warnings = {"a warning that is longer than a short string is"};
    const lamella::ReportMember member{.key = "warnings", .value = std::span<const std::string>(warnings)};
    const lamella::ReportParts parts = {.mesh_name = "a \xff name that is longer than a short string is",
                                        .file = &file.value(),
                                        .welded = &welded.value(),
                                        .audit = &audited.value(),
                                        .members = {&member, 1}};
    fail_everywhere([&] { return code_of(make_report_json(result, parts)); });
    fail_everywhere([&] { return code_of(audit(result, mesh)); });
    const auto check = lamella::check(mesh);
    fail_everywhere([&] { return code_of(make_check_json(check.value(), parts)); });
}
