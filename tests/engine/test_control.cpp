// The promises of context.hpp: threads, memory, stop, progress, and a host's own threads, whatever they do within what is
// asked of them.
#include <chrono>
#include <thread>

#include "base/parallel.hpp"
#include "engine/calls.hpp"
#include "engine/everywhere.hpp"
#include "golden/golden.hpp"

using namespace lamella;

namespace {

TEST_CASE("every call refuses negative threads, ends when asked to, and shows rising progress up to 1, one thread at a time",
          "[engine][control][threads]") {
    const shapes::Soup soup = shapes::octasphere({0, 0, 0}, 5, 4);
    ContextCalls calls(view_of(soup), 0.1);
    for (const ContextCall& call : calls.all_and_small()) {
        require_obedient(call);
    }
}

TEST_CASE("a host is asked once in an interval, and one yes of its is one for all threads", "[engine][control][threads]") {
    LateStop host{2};
    PacedStop paced(host);
    CHECK_FALSE(paced.check()());
    bool answered = false;
    std::thread([&] { answered = paced.check()(); }).join();  // another thread's first look
    CHECK(answered);
    CHECK(host.asked == 2);
    for (int look = 0; look < 3; ++look) {
        CHECK(paced.check()());
    }
    CHECK(host.asked == 2);
    host.from = 9;
    const auto until = std::chrono::steady_clock::now() + PacedStop::interval;
    paced.follow(host);
    CHECK_FALSE(paced.check()());
    CHECK_FALSE(paced.check()());
    CHECK((host.asked == 3 || std::chrono::steady_clock::now() > until));
}

TEST_CASE("the first yes ends a slice, whenever it comes", "[engine][control][cancel][threads]") {
    const shapes::Soup soup = shapes::octasphere({0, 0, 0}, 5, 5);
    const SliceOptions options = uniform(0.001);
    std::uint64_t from = 1;
    for (bool asked = true; asked && from <= 40; ++from) {
        LateStop stop{from};
        const auto outcome = slice(view_of(soup), options, {.threads = 1, .stop = stop});
        asked = stop.asked == from;  // or the slice was over before
        REQUIRE((asked ? error_of(outcome).code == ErrorCode::cancelled : outcome.ok()));
    }
    CHECK(from > 5);
}

TEST_CASE("a slow progress sink holds up no other thread", "[engine][control][threads]") {
    // The sink returns only once all planes but those of its own band are through: a lock that it held would end in a hang.
    const shapes::Soup soup = shapes::octasphere({0, 0, 0}, 10, 5);
    std::atomic<std::uint64_t> layers = 0;
    const auto count = [&](const LayerView&) noexcept { ++layers; };
    std::atomic<bool> waited = false;
    std::uint64_t meanwhile = 0;
    const auto wait = [&](double) noexcept {
        if (layers < 200 || waited.exchange(true)) {  // at the first layers a second thread may not have begun
            return;
        }
        const std::uint64_t before = layers;
        for (int i = 0; i < 20'000 && layers < before + 40; ++i) {
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        meanwhile = layers - before;
    };
    sliced_to(LayerSink{.take = count, .order = SinkOrder::any}, view_of(soup), uniform(0.01),
              {.threads = 2, .progress = wait}, {.band_planes = 20});
    CHECK(meanwhile >= 40);
}

TEST_CASE("a size that memory does not hold leaves an array as it was", "[engine][control][memory]") {
    CountingMemory memory(1000);
    Array<int> array(&memory);
    array.resize_discarding(10);
    array[9] = 7;
    CHECK_THROWS_AS(array.resize_discarding(1000), std::bad_alloc);
    CHECK(array.size() == 10);
    CHECK(array[9] == 7);
}

TEST_CASE("what is documented as noexcept is", "[engine][control]") {
    const MeshView mesh;
    const SliceResult result;
    STATIC_REQUIRE(noexcept(slice(mesh)));
    STATIC_REQUIRE(noexcept(assemble({})));
    STATIC_REQUIRE(noexcept(audit(result)));
    STATIC_REQUIRE(noexcept(Slicer()));
    STATIC_REQUIRE_FALSE(noexcept(std::declval<Array<int>&>().resize_discarding(1)));
}

using Body = Callback<void()>;

/// Shells that overlap, in enough planes for several bands.
const shapes::Soup& closed() {
    static const shapes::Soup soup =
        shapes::joined({shapes::octasphere({0, 0, 0}, 10, 5), shapes::octasphere({1, 2, 3}, 9, 5),
                        shapes::box({5, 5, -9}, {15, 15, 9}), shapes::random_tetrahedra(7, 40, 9)});
    return soup;
}

/// Hashes of the answers of every call that takes threads. Audits do not depend on the order of triangles.
std::vector<std::uint64_t> answers(const Context& context, const shapes::Soup& audited = closed()) {
    using golden::hash_of;
    static const shapes::Soup open = shapes::without(closed(), 100, 3);
    static const SliceResult of_closed = sliced(closed(), uniform(0.05), {.threads = 1});
    static const SliceResult of_open = sliced(open, uniform(0.05), {.threads = 1});
    require_at_every_destination(of_open, view_of(open), uniform(0.05), {context, {.band_planes = 7}});
    const Audit found = value_of(audit(of_closed, view_of(audited), {}, context));
    CHECK(found.volume->verdict == VolumeVerdict::holds);
    golden::Hash faults;
    for (const FaultFinding& finding : value_of(check(view_of(open), {}, context)).findings) {
        faults.add(finding.count, finding.at_least);
        for (const FaultPlace& place : finding.places) {
            faults.add(place.points_mm, place.point_count, place.triangles, place.parts, place.measure, place.closed);
        }
    }
    return {hash_of(*found.ledger), hash_of(*found.volume), hash_of(*found.crossings),
            hash_of(value_of(check(view_of(open), {.counts_only = true}, context))), faults.value()};
}

/// The same by one thread.
const std::vector<std::uint64_t>& expected() {
    static const std::vector<std::uint64_t> hashes = answers({.threads = 1});
    return hashes;
}

/// Calls body() on so many threads of its own.
void run_threads(int count, const Body& body) noexcept {
    std::vector<std::thread> threads;
    for (int i = 0; i < count; ++i) {
        threads.emplace_back([&] { body(); });
    }
    for (std::thread& thread : threads) {
        thread.join();
    }
}

TEST_CASE("answers do not depend on the number of threads, nor audits on the order of triangles",
          "[engine][executor][threads]") {
    const int threads = GENERATE(0, 2, 3);
    CHECK(answers({.threads = threads}) == expected());
    CHECK(answers({.threads = threads}, shapes::shuffled(closed(), 5)) == expected());
}

TEST_CASE("an executor may run as many bodies as asked for, or fewer, or more, on threads or one by one, some of them late",
          "[engine][executor][threads]") {
    int change = 0;
    const auto on_threads = [&](int workers, const Body& body) noexcept { run_threads(workers + change, body); };
    for (const int other : {-3, -1, 0, 1, 9}) {
        change = other;
        CHECK(answers({.executor = on_threads, .executor_threads = 4}) == expected());
    }
    int bodies = 0;
    const auto one_by_one = [&](int, const Body& body) noexcept {
        for (int i = 0; i < bodies; ++i) {
            body();
        }
    };
    for (const int other : {0, 4}) {
        bodies = other;
        CHECK(answers({.executor = one_by_one, .executor_threads = 4}) == expected());
    }
    const auto one_late = [](int workers, const Body& body) noexcept {
        std::thread late([&] {
            std::this_thread::sleep_for(std::chrono::microseconds(200));
            body();
        });
        for (int i = 1; i < workers; ++i) {
            body();
        }
        late.join();
    };
    CHECK(answers({.executor = one_late, .executor_threads = 3}) == expected());
}

TEST_CASE("the number of threads may differ from the executor's", "[engine][executor]") {
    int most = 0;
    const auto pool = [&most](int workers, const Body& body) noexcept {
        most = std::max(most, workers);
        body();
    };
    CHECK(answers({.threads = 5, .executor = pool, .executor_threads = GENERATE(-1, 0, 1, 2, 64)}) == expected());
    CHECK(most == 5);
}

}  // namespace
