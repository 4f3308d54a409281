#include <cstdlib>

#include "engine/polygons.hpp"
#include "medical/dicom/data_set.hpp"
#include "medical/dicom/keyhole.hpp"
#include "medical/support.hpp"
#include "rings.hpp"

using namespace medical;

namespace {

using Polygon = std::vector<Point>;

Polygon rectangle(std::int32_t x, std::int32_t y, std::int32_t width, std::int32_t height, bool hole) {
    const Polygon polygon = polygons::box(x, y, x + width, y + height);
    return rings::from_smallest(hole ? polygons::reversed(polygon) : polygon);
}

Polygon diamond(std::int32_t x, std::int32_t y, std::int32_t radius) {
    return rings::from_smallest({{x - radius, y}, {x, y + radius}, {x + radius, y}, {x, y - radius}});
}

template <class P>
double twice_area(std::span<const P> ring) {
    double sum = 0;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const P& a = ring[i];
        const P& b = ring[(i + 1) % ring.size()];
        sum += static_cast<double>(a.x) * b.y - static_cast<double>(b.x) * a.y;
    }
    return sum;
}

double side(const RingPoint& a, const RingPoint& b, const RingPoint& c) {
    const double twice = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    return std::abs(twice) < 1e-6 ? 0 : twice;
}

/// Whether two edges cross within both.
bool cross_within(const RingPoint& a, const RingPoint& b, const RingPoint& c, const RingPoint& d) {
    return side(a, b, c) * side(a, b, d) < 0 && side(c, d, a) * side(c, d, b) < 0;
}

void check_ring(const std::vector<Polygon>& polygons) {
    Keyhole keyhole;
    const std::vector<std::span<const Point>> contours(polygons.begin(), polygons.end());
    const std::span<const RingPoint> ring = keyhole.join(contours);
    double expected = 0;
    for (const Polygon& polygon : polygons) {
        expected += twice_area(std::span<const Point>(polygon));
        for (const Point& point : polygon) {
            const RingPoint there{static_cast<double>(point.x), static_cast<double>(point.y)};
            REQUIRE(std::find(ring.begin(), ring.end(), there) != ring.end());
        }
    }
    REQUIRE(twice_area(ring) == Approx(expected).margin(1e-6));
    for (std::size_t i = 0; i < ring.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            REQUIRE_FALSE(cross_within(ring[i], ring[(i + 1) % ring.size()], ring[j], ring[(j + 1) % ring.size()]));
        }
    }
}

/// Slices at 0, 2, 4 ... around the origin.
ImageGeometry slices(std::uint64_t count) {
    return image_of({100, 100, count}, {1, 1, 2}, {-50, -50, -static_cast<double>(count)});
}

}  // namespace

TEST_CASE("keyhole: a ring has the region's area and crosses itself nowhere: holes at equal heights, near and touching",
          "[medical]") {
    // Near the end of the grid.
    const std::int32_t far = grid_limit - 2;
    check_ring({rings::from_smallest({{-far, -far}, {far, -far}, {far, far}, {-far + 1, far}}),
                rectangle(far - 9, far - 7, 5, 3, true), rectangle(-far + 9, 3, 5, 3, true)});
    // A hole that touches the outer contour by its leftmost point, one that two others touch.
    check_ring({rectangle(0, 0, 100, 100, false), diamond(10, 50, 10), diamond(40, 50, 10), diamond(60, 50, 10)});
    std::mt19937 random(7);
    const auto pick = [&](int count) { return static_cast<std::int32_t>(random() % static_cast<unsigned>(count)); };
    for (int round = 0; round < 200; ++round) {
        const int cells = 2 + round % 6;
        const int pitch = 12;
        std::vector<Polygon> polygons = {rectangle(0, 0, cells * pitch, cells * pitch, false)};
        for (int cell = 0; cell < cells * cells; ++cell) {
            const int x = cell % cells * pitch;
            const int y = cell / cells * pitch;
            const int kind = pick(4);
            if (kind == 1) {
                polygons.push_back(rectangle(x + 1 + pick(3), y + 1 + pick(3), 2 + pick(6), 2 + pick(6), true));
            } else if (kind > 1) {  // diamonds of the whole cell touch their neighbours
                polygons.push_back(diamond(x + 6, y + 6, 2 + pick(5)));
            }
        }
        std::shuffle(polygons.begin() + 1, polygons.end(), random);
        check_ring(polygons);
    }
}

TEST_CASE("keyhole: thousands of holes", "[medical]") {
    std::vector<Polygon> polygons = {rectangle(0, 0, 4000, 4000, false)};
    for (int i = 0; i < 10000; ++i) {
        polygons.push_back(rectangle(40 * (i % 100) + 10, 40 * (i / 100) + 10 + i % 7, 12, 12, true));
    }
    const std::vector<std::span<const Point>> contours(polygons.begin(), polygons.end());
    Keyhole keyhole;
    CHECK(twice_area(keyhole.join(contours)) == Approx(2.0 * (4000.0 * 4000 - 10000 * 144.0)));
}

TEST_CASE("structure set: decimals have at most 16 characters and no idle zeros", "[medical]") {
    const auto text = [](double value, int decimals) {
        std::string out;
        put_decimal(out, value, decimals);
        return out;
    };
    for (const auto& [value, decimals, expected] : {std::tuple{1.5, 7, "1.5"},
                                                    {-0.00000001, 7, "0"},
                                                    {-123.45678912, 7, "-123.4567891"},
                                                    {100.0, 7, "100"},
                                                    {1000.0, 0, "1000"},
                                                    {-123456789.123456, 7, "-123456789.12346"}}) {
        CHECK(text(value, decimals) == expected);
    }
    std::mt19937_64 random(3);
    for (int i = 0; i < 20000; ++i) {
        const double value = std::ldexp(static_cast<double>(static_cast<std::int64_t>(random())), -63 + i % 31);
        const std::string number = text(value, i % 15);
        REQUIRE(number.size() <= 16);
        REQUIRE(std::abs(std::stod(number) - value) <= 0.5000001 * std::pow(10, -std::min(i % 15, 4)));
    }
}

TEST_CASE("structure set: bytes depend on content; dates are asked for", "[medical]") {
    const ImageGeometry image = slices(20);
    const SliceResult result = cut(box({-10, -12, -15}, {11, 9, 14}), image);
    const TempFolder folder;
    const auto written = [&](const std::string& name, StructureSetOptions options = {}) {
        options.without_ct = true;
        const Roi roi{.result = &result, .name = name};
        const StructureSetSummary done = value_of(write_structure_set({&roi, 1}, image, folder / "a.dcm", options));
        CHECK(done.contours > 10);
        CHECK(done.open_contours == 0);
        return bytes_of(folder / "a.dcm");
    };
    const std::string one = written("liver");
    CHECK(one == written("liver"));
    CHECK(one != written("Leber"));
    std::array<unsigned char, 32> content{};
    const std::string uid = uid_of(content, "instance");
    CHECK(uid.starts_with("2.25."));
    CHECK((uid.size() >= 38 && uid.size() <= 44));
    CHECK(uid != uid_of(content, "series"));
    content[31] = 1;
    CHECK(uid != uid_of(content, "instance"));
    CHECK(one.find("20260102") == std::string::npos);
    const std::string with_date = written("liver", {.seconds_since_1970 = 1767323045});
    CHECK_THAT(with_date, Contains("20260102"));
    CHECK_THAT(with_date, Contains("030405"));
    // Names: UTF-8 is declared, backslashes and what is no text are not written.
    const std::string named = written("L\xc3\xa4ppchen\\\x01\xff");
    CHECK_THAT(named, Contains("ISO_IR 192"));
    CHECK_THAT(named, Contains("L\xc3\xa4ppchen___"));
    CHECK(written(std::string(500, 'x')).find(std::string(65, 'x')) == std::string::npos);
}

TEST_CASE("structure set: what cannot be one is refused, and nothing is written", "[medical]") {
    const ImageGeometry image = slices(20);
    const SliceResult result = cut(box({-10, -12, -15}, {11, 9, 14}), image);
    const TempFolder folder;
    const auto check_refusal = [&](const SliceResult* of, const ImageGeometry& on, const char* why,
                                   const StructureSetOptions& options = {.without_ct = true}) {
        const Roi roi{.result = of, .name = "liver"};
        const Error error = error_of(write_structure_set({&roi, 1}, on, folder / "a.dcm", options));
        CHECK(error.code == ErrorCode::invalid_argument);
        CHECK_THAT(error.message, Contains(why));
        CHECK(folder.names().empty());
    };
    check_refusal(&result, image, "slices of a CT", {});
    check_refusal(&result, slices(21), "not cut at the slices");
    check_refusal(nullptr, image, "not cut at the slices");
    ImageGeometry elsewhere = image;
    elsewhere.origin_mm[2] = 500;
    const SliceResult nothing = cut(box({-10, -12, -15}, {11, 9, 14}), elsewhere);
    check_refusal(&nothing, elsewhere, "no closed contour on any slice");
    ImageGeometry ct = image;
    ct.series.emplace();
    check_refusal(&result, ct, "other slices");
    ct.series->slices.resize(20);
    check_refusal(&result, ct, "StudyInstanceUID");
    ct.series->study_uid = ct.series->series_uid = "1.2";
    ct.series->frame_of_reference_uid = "1.2\\3";
    check_refusal(&result, ct, "FrameOfReferenceUID");
    check_refusal(&result, image, "beyond the year 9999", {.without_ct = true, .seconds_since_1970 = std::int64_t{1} << 60});
}
