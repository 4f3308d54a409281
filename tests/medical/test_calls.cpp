// What all calls that write or read medical files have in common.
#include <atomic>
#include <chrono>
#include <functional>

#include "medical/support.hpp"

namespace medical_calls {

using namespace medical;

/// A call on a file, and the message that it ends with.
struct Call {
    const char* file;
    std::function<std::string(const std::filesystem::path&, const Context&)> run;
};

template <class Made>
auto ends(const Made& call) {
    return [call](const std::filesystem::path& path, const Context& context) {
        const auto outcome = call(path, context);
        return outcome.ok() ? std::string("done") : outcome.error().message;
    };
}

TEST_CASE("medical calls give the same bytes on any number of threads, end when asked to, ask by time, and leave nothing") {
    using Path = std::filesystem::path;
    const TempFolder folder;
    const TempFolder empty;
    const ImageGeometry image = image_of({64, 32, 2000}, {0.5, 1, 0.01}, {-16, -16, -10});
    const SliceResult one = cut(octasphere({0, 0, 0}, 9, 3), image);
    const SliceResult two = cut(octasphere({2, 0, 0}, 6, 3), image);
    const std::vector<MaskPart> organs = {{&one, "a"}, {&two, "b, \"c\""}};
    const std::vector<Roi> rois = {{.result = &one, .name = "a"}, {.result = &two, .name = "b"}};
    const std::vector<TablePart> table = {{.result = &one, .name = "a"}};
    const std::vector<PicturePart> parts = {{&one, "a"}, {&two, "b"}};
    const auto mask = ends([&](const Path& to, const Context& c) { return write_mask(organs, image, to, {}, c); });
    const auto rows =
        ends([&](const Path& to, const Context& c) { return write_layer_table(table, to, nullptr, false, c); });
    std::vector<Call> calls = {
        {"a.nii", mask},
        {"a.nii.gz", mask},
        {"a.nrrd", mask},
        {"a.seg.nrrd", mask},
        {"a.mha", mask},
        {"a.seg.dcm", ends([&](const Path& to, const Context& c) {
             return write_segmentation(organs, image, to, {.without_ct = true}, c);
         })},
        {"a.csv", rows},
        {"a.jsonl", rows},
        {"a.dcm", ends([&](const Path& to, const Context& c) {
             return write_structure_set(rois, image, to, {.without_ct = true}, c);
         })},
    };
    if (can_write_pictures()) {
        calls.push_back({"s.png", ends([&](const Path& to, const Context& c) {
                             return write_contact_sheet(parts, to, {.width = 1500, .height = 1500}, c);
                         })});
        calls.push_back(
            {"l.png", ends([&](const Path& to, const Context& c) { return write_layer_picture(parts, 1000, to, {}, c); })});
    }
    if (has_archives()) {
        calls.push_back({"a.h5", ends([&](const Path& to, const Context& c) { return write_archive(one, {}, to, c); })});
    }
    const auto require_stops = [&](const Call& call, const Path& path, int threads) {
        INFO(call.file << " on " << threads << " threads");
        std::atomic<std::uint64_t> asked{0};
        const auto never = [&asked]() noexcept { return ++asked == 0; };
        const auto start = std::chrono::steady_clock::now();
        CHECK(call.run(path, {.threads = threads, .stop = never}) == "done");
        const std::chrono::duration<double, std::milli> ms = std::chrono::steady_clock::now() - start;
        CHECK(static_cast<double>(asked) <= 2 * threads * (ms.count() / 2 + 1));  // some calls make two passes
        CHECK(call.run(path, {.threads = threads, .stop = always}) == "cancelled");
    };
    for (const Call& call : calls) {
        std::string first;
        for (const int threads : {1, 2, 7}) {
            require_stops(call, folder / call.file, threads);
            const std::string bytes = bytes_of(folder / call.file);
            CHECK((first.empty() || bytes == first));
            first = bytes;
        }
        CHECK(call.run(empty / call.file, {.stop = always}) == "cancelled");
        CHECK_THAT(call.run(empty / call.file, {.threads = -1}), Contains("threads must not be negative"));
        CHECK_THAT(call.run(empty / "none" / call.file, {}), Contains("No such file or directory"));
        CHECK(empty.names().empty());
    }
    require_stops({"seal_file", ends([](const Path& of, const Context& c) { return seal_file(of, c); })}, folder / "a.csv",
                  1);
    if (has_archives()) {
        require_stops({"read_archive", ends([](const Path& of, const Context& c) { return read_archive(of, c); })},
                      folder / "a.h5", 2);
    }
    CHECK_THAT(bytes_of(folder / "a.labels.csv"), Contains("2,\"b, \"\"c\"\"\","));
}

}  // namespace medical_calls
