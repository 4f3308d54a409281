// DICOM segmentations, read back by a reader that was written from PS3.3 and PS3.5 alone; by others: tests/readers.
#include <map>

#include "lamella/io/text_file.hpp"
#include "medical/dicom/cielab.hpp"
#include "medical/support.hpp"

namespace medical_segmentation {

using namespace medical;

/// Elements of a data set in implicit VR by their tags; a sequence is a list of data sets.
struct Element {
    std::string value;
    std::vector<std::map<std::uint32_t, Element>> items;
};
using Elements = std::map<std::uint32_t, Element>;

/// Reads elements until the data or the item ends (PS3.5, 7.5).
class Parser {
public:
    explicit Parser(std::string bytes) : bytes_(std::move(bytes)) {}

    /// The data set behind preamble and meta information, whose length its first element states.
    Elements file() {
        REQUIRE(bytes_.substr(128, 4) == "DICM");
        REQUIRE(bytes_.substr(132, 8) == std::string("\2\0\0\0UL\4\0", 8));
        at_ = 140;
        const std::uint32_t meta_bytes = number(4);
        at_ += meta_bytes;
        Elements all = elements();
        CHECK(at_ == bytes_.size());
        return all;
    }

private:
    std::uint32_t number(std::size_t count) {
        std::uint32_t value = 0;
        for (std::size_t i = 0; i < count; ++i) {
            value |= std::uint32_t{static_cast<unsigned char>(bytes_.at(at_++))} << 8 * i;
        }
        return value;
    }
    std::uint32_t tag() {
        const std::uint32_t group = number(2);
        return group << 16 | number(2);
    }

    Elements elements() {
        Elements found;
        std::uint32_t last = 0;
        while (at_ < bytes_.size()) {
            const std::uint32_t of = tag();
            const std::uint32_t length = number(4);
            if (of == 0xfffee00d) {
                return found;
            }
            REQUIRE(of > last);
            last = of;
            if (length != 0xffffffff) {
                REQUIRE(length % 2 == 0);
                found[of].value = bytes_.substr(at_, length);
                at_ += length;
                continue;
            }
            for (std::uint32_t item = tag(); item != 0xfffee0dd; item = tag()) {
                REQUIRE(item == 0xfffee000);
                REQUIRE(number(4) == 0xffffffff);
                found[of].items.push_back(elements());
            }
            REQUIRE(number(4) == 0);
        }
        return found;
    }

    std::string bytes_;
    std::size_t at_ = 0;
};

std::string text(const Elements& of, std::uint32_t tag) {
    std::string value = of.at(tag).value;
    while (!value.empty() && (value.back() == ' ' || value.back() == '\0')) {
        value.pop_back();
    }
    return value;
}

std::size_t number(const Elements& of, std::uint32_t tag, std::size_t i = 0, std::size_t bytes = 2) {
    std::size_t value = 0;
    for (std::size_t at = bytes; at-- > 0;) {
        value = value << 8 | static_cast<unsigned char>(of.at(tag).value.at(bytes * i + at));
    }
    return value;
}

struct ReadSegmentation {
    Elements data;
    std::vector<std::string> voxels;  ///< of each segment all of the image's, a byte each
};

/// Frames lie on slices by their places, which are sought among those of the image.
ReadSegmentation read(const std::string& bytes, const ImageGeometry& image) {
    ReadSegmentation found{Parser(bytes).file(), {}};
    const Elements& data = found.data;
    const std::size_t size = image.size[0] * image.size[1];
    REQUIRE(number(data, 0x00280010) == image.size[1]);
    REQUIRE(number(data, 0x00280011) == image.size[0]);
    const bool binary = text(data, 0x00620001) == "BINARY";
    REQUIRE(number(data, 0x00280100) == (binary ? 1 : 8));
    for (std::size_t i = 0; i < data.at(0x00620002).items.size(); ++i) {
        REQUIRE(number(data.at(0x00620002).items[i], 0x00620004) == i + 1);
        found.voxels.emplace_back(size * image.size[2], '\0');
    }
    const std::vector<Elements>& frames = data.at(0x52009230).items;
    REQUIRE(text(data, 0x00280008) == std::to_string(frames.size()));
    const std::string& pixels = data.at(0x7fe00010).value;
    const std::size_t used = binary ? (frames.size() * size + 7) / 8 : frames.size() * size;
    REQUIRE(pixels.size() == used + used % 2);
    const std::vector<double> heights = image.slice_heights_mm();
    std::size_t at = 0;
    for (const Elements& frame : frames) {
        const std::size_t segment = number(frame.at(0x0062000a).items.at(0), 0x0062000b);
        REQUIRE(number(frame.at(0x00209111).items.at(0), 0x00209157, 0, 4) == segment);
        const std::string place = text(frame.at(0x00209113).items.at(0), 0x00200032);
        std::array<double, 3> stated{};
        REQUIRE(std::sscanf(place.c_str(), "%lf\\%lf\\%lf", &stated[0], &stated[1], &stated[2]) == 3);
        std::size_t slice = 0;
        for (; slice < heights.size(); ++slice) {
            const std::array<double, 3> there = image.to_lps({0, 0, heights[slice]});
            if (std::hypot(there[0] - stated[0], there[1] - stated[1], there[2] - stated[2]) < 1e-8) {
                break;
            }
        }
        for (std::size_t i = 0; i < size; ++i, ++at) {
            found.voxels.at(segment - 1).at(slice * size + i) =
                binary ? static_cast<char>(static_cast<unsigned char>(pixels.at(at / 8)) >> at % 8 & 1) : pixels.at(at);
        }
    }
    for (; binary && at < 8 * pixels.size(); ++at) {
        REQUIRE((static_cast<unsigned char>(pixels[at / 8]) >> at % 8 & 1) == 0);
    }
    return found;
}

/// What draw_mask() makes of a part alone.
std::string drawn(const SliceResult& result, const ImageGeometry& image, const MaskOptions& options) {
    const MaskPart part{&result, "a"};
    std::vector<unsigned char> voxels(image.size[0] * image.size[1] * image.size[2]);
    value_of(draw_mask({&part, 1}, image, voxels, options));
    return {voxels.begin(), voxels.end()};
}

TEST_CASE("segmentation: overlapping segments, one of them empty, come back bit for bit, mid-byte frames and all") {
    const TempFolder folder;
    std::mt19937 random(5);
    for (int round = 0; round < 40; ++round) {
        const auto side = [&] { return 1 + random() % 9; };
        ImageGeometry image = image_of({side(), side(), 1 + random() % 4}, {0.5, 0.75, 2}, {-2, -2.5, -3});
        if (round % 3 == 0) {  // left-handed and turned
            image.axes = {{{0, 1, 0}, {0.6, 0, 0.8}, {-0.8, 0, 0.6}}};
        }
        std::vector<SliceResult> results;
        const auto number_in = [&] { return static_cast<float>(random() % 1000) / 300.0F; };
        for (int i = 0; i < 3; ++i) {
            results.push_back(
                cut(box({-number_in(), -number_in(), -number_in()}, {number_in(), number_in(), number_in()}), image));
        }
        results.push_back(cut(box({500, 500, 500}, {501, 501, 501}), image));
        std::vector<MaskPart> parts;
        for (const SliceResult& result : results) {
            parts.push_back({&result, "part"});
        }
        for (const bool coverage : {false, true}) {
            const SegmentationOptions options{.coverage = coverage, .without_ct = true};
            const SegmentationSummary written = value_of(write_segmentation(parts, image, folder / "a.seg.dcm", options));
            const ReadSegmentation back = read(bytes_of(folder / "a.seg.dcm"), image);
            REQUIRE(back.data.at(0x52009230).items.size() == written.frames);
            for (std::size_t i = 0; i < results.size(); ++i) {
                const std::string expected = drawn(results[i], image, {.coverage = coverage});
                REQUIRE(back.voxels.at(i) == expected);
                REQUIRE(written.mask.voxels[i] ==
                        expected.size() - static_cast<std::size_t>(std::count(expected.begin(), expected.end(), '\0')));
            }
        }
    }
}

TEST_CASE("segmentation: it states its codes, colours, names and, of a series, the slices that frames are of") {
    ImageGeometry image = image_of({4, 4, 3}, {1, 1, 2}, {0, 0, 0});
    DicomSeries& series = image.series.emplace();
    series.study_uid = "1.2.3";
    series.series_uid = "1.2.4";
    series.frame_of_reference_uid = "1.2.5";
    series.patient_name = "Doe^Jane";
    series.study_date = "20200102";
    series.study_time = "030405.5";
    for (const char* const uid : {"1.2.6.1", "1.2.6.2", "1.2.6.3"}) {
        series.slices.push_back({uid, "1.2.840.10008.5.1.4.1.1.2", uid});
    }
    const SliceResult result = cut(box({1, 1, 1}, {3, 3, 5}), image);  // slices 1 and 2
    std::vector<MaskPart> parts = {{&result, "Oberschenkel r\xc3\xb6t"}, {&result, "b"}};
    parts[0].terms = {.colour = std::array<std::uint8_t, 3>{255, 255, 255},
                      .type = {"SCT", "71341001", "Femur"},
                      .region = {"SCT", "7771000", "Left"}};
    const TempFolder folder;
    value_of(write_segmentation(parts, image, folder / "a.seg.dcm"));
    const Elements data = read(bytes_of(folder / "a.seg.dcm"), image).data;
    CHECK(text(data, 0x00100010) == "Doe^Jane");
    CHECK(text(data, 0x0020000d) == "1.2.3");
    CHECK(text(data, 0x00200052) == "1.2.5");
    CHECK(text(data, 0x00080023) + text(data, 0x00080033) == "20200102030405");
    const Elements& segment = data.at(0x00620002).items[0];
    CHECK(text(segment, 0x00620005) == "Oberschenkel r\xc3\xb6t");
    CHECK(text(segment.at(0x0062000f).items[0], 0x00080100) == "71341001");
    CHECK(text(segment.at(0x00082218).items[0], 0x00080104) == "Left");
    CHECK(segment.at(0x0062000d).value == std::string("\xff\xff\x80\x80\x80\x80"));
    CHECK(text(data.at(0x00620002).items[1].at(0x00620003).items[0], 0x00080104) == "Tissue");
    const Elements& of_series = data.at(0x00081115).items[0];
    CHECK(text(of_series, 0x0020000e) == "1.2.4");
    REQUIRE(of_series.at(0x0008114a).items.size() == 2);
    CHECK(text(of_series.at(0x0008114a).items[0], 0x00081155) == "1.2.6.2");
    const Elements& measures = data.at(0x52009229).items[0].at(0x00289110).items[0];
    CHECK(text(measures, 0x00280030) + " " + text(measures, 0x00180050) + " " + text(measures, 0x00180088) == "1\\1 2 2");
    for (std::size_t i = 0; i < 4; ++i) {
        const Elements& frame = data.at(0x52009230).items[i];
        CHECK(number(frame.at(0x00209111).items[0], 0x00209157, 1, 4) == i % 2 + 1);
        CHECK(text(frame.at(0x00209113).items[0], 0x00200032) == (i % 2 == 0 ? "0\\0\\2" : "0\\0\\4"));
        const Elements& source = frame.at(0x00089124).items[0].at(0x00082112).items[0];
        CHECK(text(source, 0x00081155) == (i % 2 == 0 ? "1.2.6.2" : "1.2.6.3"));
    }
}

TEST_CASE("segmentation: what cannot be one is refused, and leaves nothing") {
    const ImageGeometry image = image_of({4, 4, 6}, {1, 1, 1}, {0, 0, 0});
    const SliceResult whole = cut(box({0, 0, -1}, {3, 3, 4.5}), image);
    const TempFolder folder;
    const auto check_refusal = [&](std::vector<MaskPart> parts, const ImageGeometry& at, SegmentationOptions options,
                                   const char* why) {
        const Error error = error_of(write_segmentation(parts, at, folder / "a.seg.dcm", options));
        CHECK(error.code == ErrorCode::invalid_argument);
        CHECK_THAT(error.message, Contains(why));
        CHECK(folder.names().empty());
    };
    const MaskPart part{&whole, "a"};
    check_refusal({part}, image, {}, "a segmentation is drawn on the slices of a CT");
    check_refusal({}, image, {.without_ct = true}, "1 to 65,535");
    check_refusal({part}, image_of({4, 4, 5}, {1, 1, 1}, {0, 0, 0}), {.without_ct = true}, "not cut at the slices");
    check_refusal({part}, image_of({70000, 4, 6}, {1, 1, 1}, {0, 0, 0}), {.without_ct = true}, "65,535 voxels");
    check_refusal({part}, image, {.subslices = 0, .without_ct = true}, "at least one plane");
}

TEST_CASE("segmentation: colours become CIELab of D50") {
    // By B. Lindbloom's calculator: L, a, b.
    for (const auto& [rgb, lab] : {std::pair<std::array<std::uint8_t, 3>, std::array<double, 3>>{{0, 0, 0}, {0, 0, 0}},
                                   {{255, 0, 0}, {54.2917, 80.8125, 69.8851}},
                                   {{0, 255, 0}, {87.8181, -79.2873, 80.9902}},
                                   {{0, 0, 255}, {29.5676, 68.2986, -112.0294}}}) {
        const std::array<std::uint16_t, 3> found = cielab_of(rgb);
        CHECK(found[0] == Approx(lab[0] * 655.35).margin(1.5));
        CHECK(found[1] == Approx((lab[1] + 128) * 257).margin(1.5));
        CHECK(found[2] == Approx((lab[2] + 128) * 257).margin(1.5));
    }
}

TEST_CASE("labels: a table is read, and what is wrong with one is said with file and line") {
    const TempFolder folder;
    const auto table = [&](const std::string& text) {
        REQUIRE(write_text_file(folder / "l.csv", text).ok());
        return read_label_table(folder / "l.csv");
    };
    const std::vector<LabelRow> rows =
        value_of(table("\xef\xbb\xbf"
                       "Name,label,color,type,voxels\r\n\r\n\"a, \"\"b\"\"\", 2 ,#00ff80,SCT^1^x,7\r\n,1,,,\n"));
    REQUIRE(rows.size() == 2);
    CHECK(rows[0].label == 2);
    CHECK(rows[0].name == "a, \"b\"");
    CHECK(rows[0].terms.colour == std::array<std::uint8_t, 3>{0, 255, 128});
    CHECK(rows[0].terms.type.value == "1");
    CHECK(rows[1].terms.type.meaning == "Tissue");
    CHECK_FALSE(rows[1].terms.colour);
    for (const auto& [text, why] : {std::pair<std::string, const char*>{"", "empty"},
                                    {"name\na\n", "l.csv:1: no column is called label"},
                                    {"label,colour\n", "l.csv:1: the column 'colour'"},
                                    {"label,label\n", "l.csv:1: the column 'label'"},
                                    {"label\n0\n", "l.csv:2: the label '0'"},
                                    {"label\n1\n\n1\n", "l.csv:4: the label 1 has a row already"},
                                    {"label\n1,2\n", "l.csv:2: 2 cells"},
                                    {"label,color\n1,#12345\n", "l.csv:2: the color"},
                                    {"label,color\n1,#-12345\n", "l.csv:2: the color"},
                                    {"label,type\n1,SCT^1\n", "l.csv:2: the type"},
                                    {"label,type\n1,SCT^1^a^b\n", "l.csv:2: the type"},
                                    {"label,region\n1,SCT^1^a~b\n", "l.csv:2: the region"},
                                    {"label,name\n1,\"a\nb\n", "l.csv:2: a quote is not closed"},
                                    {"label,name\n1,\xff\n", "not in UTF-8"}}) {
        const Error error = error_of(table(text));
        CHECK(error.code == ErrorCode::malformed_mesh);
        CHECK_THAT(error.message, Contains(why));
    }
}

}  // namespace medical_segmentation
