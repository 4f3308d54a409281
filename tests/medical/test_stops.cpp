// Whoever writes or reads medical files asks whether to stop at the beginning, and from then on by time.
#include <atomic>
#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/shapes.hpp"
#include "lamella/lamella.hpp"
#include "lamella/medical.hpp"
#include "temp_folder.hpp"

namespace stops {

using namespace lamella;

/// A host that is asked whether to stop, and counts how often.
struct Host {
    bool answer = false;
    std::atomic<std::uint64_t> asked{0};

    StopCheck check() {
        return {[](void* context) noexcept {
                    auto* const self = static_cast<Host*>(context);
                    ++self->asked;
                    return self->answer;
                },
                this};
    }
};

template <class Outcome>
std::string outcome_of(const Outcome& outcome) {
    return outcome.ok() ? "done" : outcome.error().message;
}

TEST_CASE("medical calls end when asked to, and ask by time") {
    const TempFolder folder;
    ImageGeometry image;
    image.size = {32, 32, 2000};
    image.spacing_mm = {1, 1, 0.01};
    image.origin_mm = {-16, -16, -10};
    SliceOptions options;
    options.plan.spacing = ExplicitPlanes{image.slice_heights_mm()};
    options.transform = image.slicing_frame(PatientFrame::lps);
    const auto ball = shapes::floats(shapes::octasphere({0, 0, 0}, 9, 3));
    const Result<SliceResult> sliced = slice(MeshView::soup(ball), options);
    REQUIRE(sliced.ok());
    const SliceResult& result = *sliced;
    const std::vector<TablePart> table = {{.result = &result, .name = "a"}};
    const std::vector<MaskPart> organ = {{.result = &result, .name = "a"}};
    const std::vector<Roi> roi = {{.result = &result, .name = "a"}};
    REQUIRE(write_layer_table(table, folder / "whole.csv").ok());

    struct Call {
        const char* name;
        std::function<std::string(const Control&)> run;
    };
    std::vector<Call> calls = {
        {"write_mask",
         [&](const Control& c) { return outcome_of(write_mask(organ, image, folder / "a.nii", {.control = c})); }},
        {"write_structure_set",
         [&](const Control& c) {
             return outcome_of(write_structure_set(roi, image, folder / "a.dcm", {.without_ct = true, .control = c}));
         }},
        {"a table in CSV", [&](const Control& c) { return outcome_of(write_layer_table(table, folder / "a.csv", c)); }},
        {"a table in JSON Lines",
         [&](const Control& c) { return outcome_of(write_layer_table(table, folder / "a.jsonl", c)); }},
        {"seal_file", [&](const Control& c) { return outcome_of(seal_file(folder / "whole.csv", c)); }},
    };
    if (has_archives()) {
        calls.push_back(
            {"write_archive", [&](const Control& c) { return outcome_of(write_archive(result, {}, folder / "a.h5", c)); }});
        calls.push_back({"read_archive", [&](const Control& c) { return outcome_of(read_archive(folder / "a.h5", c)); }});
    }
    for (const Call& call : calls) {
        for (const int threads : {1, 2}) {
            INFO(call.name << " on " << threads << " threads");
            Host patient;
            const auto start = std::chrono::steady_clock::now();
            CHECK(call.run({.threads = threads, .stop = patient.check()}) == "done");
            const std::chrono::duration<double, std::milli> ms = std::chrono::steady_clock::now() - start;
            CHECK(static_cast<double>(patient.asked) <= 2 * threads * (ms.count() / 2 + 1));  // some calls make two passes
            Host hasty;
            hasty.answer = true;
            CHECK(call.run({.threads = threads, .stop = hasty.check()}) == "cancelled");
        }
    }
}

}  // namespace stops
