// Whoever writes or reads medical files asks whether to stop at the beginning, and from then on by time.
#include <atomic>
#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "medical/support.hpp"

namespace stops {

using namespace medical;

/// A host that is asked whether to stop, and counts how often.
struct Host {
    bool answer = false;
    std::atomic<std::uint64_t> asked{0};

    bool operator()() noexcept {
        ++asked;
        return answer;
    }
};

template <class Outcome>
std::string outcome_of(const Outcome& outcome) {
    return outcome.ok() ? "done" : outcome.error().message;
}

TEST_CASE("medical calls end when asked to, and ask by time") {
    const TempFolder folder;
    const ImageGeometry image = image_of({32, 32, 2000}, {1, 1, 0.01}, {-16, -16, -10});
    const SliceResult result = cut(octasphere({0, 0, 0}, 9, 3), image);
    const std::vector<TablePart> table = {{.result = &result, .name = "a"}};
    const std::vector<MaskPart> organ = {{.result = &result, .name = "a"}};
    const std::vector<Roi> roi = {{.result = &result, .name = "a"}};
    REQUIRE(write_layer_table(table, folder / "whole.csv").ok());

    const auto ends = [](const auto& call) { return [call](const Context& context) { return outcome_of(call(context)); }; };
    std::vector<std::pair<const char*, std::function<std::string(const Context&)>>> calls = {
        {"write_mask", ends([&](const Context& c) { return write_mask(organ, image, folder / "a.nii", {}, c); })},
        {"write_structure_set",
         ends([&](const Context& c) { return write_structure_set(roi, image, folder / "a.dcm", {.without_ct = true}, c); })},
        {"CSV", ends([&](const Context& c) { return write_layer_table(table, folder / "a.csv", nullptr, c); })},
        {"JSON Lines", ends([&](const Context& c) { return write_layer_table(table, folder / "a.jsonl", nullptr, c); })},
        {"seal_file", ends([&](const Context& c) { return seal_file(folder / "whole.csv", c); })},
    };
    if (has_archives()) {
        calls.emplace_back("write_archive",
                           ends([&](const Context& c) { return write_archive(result, {}, folder / "a.h5", c); }));
        calls.emplace_back("read_archive", ends([&](const Context& c) { return read_archive(folder / "a.h5", c); }));
    }
    for (const auto& [name, run] : calls) {
        for (const int threads : {1, 2}) {
            INFO(name << " on " << threads << " threads");
            Host patient;
            const auto start = std::chrono::steady_clock::now();
            CHECK(run({.threads = threads, .stop = patient}) == "done");
            const std::chrono::duration<double, std::milli> ms = std::chrono::steady_clock::now() - start;
            CHECK(static_cast<double>(patient.asked) <= 2 * threads * (ms.count() / 2 + 1));  // some calls make two passes
            Host hasty;
            hasty.answer = true;
            CHECK(run({.threads = threads, .stop = hasty}) == "cancelled");
        }
    }
}

}  // namespace stops
