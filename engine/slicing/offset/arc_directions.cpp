#include "slicing/offset/arc_directions.hpp"

#include <algorithm>
#include <cmath>

namespace lamella {

namespace {

double cross_of(Direction a, Direction b) noexcept {
    return a.x * b.y - a.y * b.x;
}

Direction middle_of(Direction a, Direction b) noexcept {
    const double x = a.x + b.x;
    const double y = a.y + b.y;
    const double length = std::sqrt(x * x + y * y);
    return {x / length, y / length};
}

}  // namespace

void ArcDirections::fit(double distance, double tolerance) {
    constexpr std::size_t most = 1024;
    std::size_t count = 2;                                           // of a quarter turn
    double cosine = middle_of({1, 0}, middle_of({1, 0}, {0, 1})).x;  // of half the angle between two
    for (; cosine * (distance + tolerance) < distance && count < most; count *= 2) {
        cosine = std::sqrt((1 + cosine) / 2);
    }
    quarter_.assign(count + 1, Direction{1, 0});
    quarter_[count] = {0, 1};
    for (std::size_t step = count; step > 1; step /= 2) {
        for (std::size_t i = 0; i < count; i += step) {
            quarter_[i + step / 2] = middle_of(quarter_[i], quarter_[i + step]);
        }
    }
}

Direction ArcDirections::operator[](std::size_t i) const noexcept {
    const std::size_t count = quarter_.size() - 1;
    const Direction at = quarter_[i % count];
    switch (i / count % 4) {
        case 0:
            return at;
        case 1:
            return {-at.y, at.x};
        case 2:
            return {-at.x, -at.y};
        default:
            return {at.y, -at.x};
    }
}

/// The index of the last one that is not past `at`.
std::size_t ArcDirections::last_before(Direction at) const noexcept {
    std::size_t quadrant = 0;
    for (; quadrant < 3 && !(at.x > 0 && at.y >= 0); ++quadrant) {
        at = {at.y, -at.x};  // turned back by a quarter
    }
    const auto past = std::partition_point(quarter_.begin() + 1, quarter_.end() - 1,
                                           [at](Direction own) { return cross_of(own, at) >= 0; });
    return quadrant * (quarter_.size() - 1) + static_cast<std::size_t>(past - quarter_.begin()) - 1;
}

ArcDirections::Between ArcDirections::between(Direction first, Direction last) const noexcept {
    const std::size_t begin = last_before(first) + 1;
    std::size_t end = last_before(last);
    end += cross_of((*this)[end], last) > 0 ? 1 : 0;  // `last` itself is none of them
    const std::size_t count = (end + size() - begin) % size();
    return {begin, count > size() / 2 + 1 ? 0 : count};  // rounding: one more than half, or one before the first
}

}  // namespace lamella
