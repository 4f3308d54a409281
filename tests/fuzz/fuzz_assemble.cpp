// Assembles arbitrary segments with few keys, so that many meet. Every segment must be used exactly once.
#include "bytes.hpp"
#include "lamella/layers.hpp"

using namespace lamella;

namespace {

constexpr std::size_t most_segments = 400;

/// By key: where the ends with this key lie, if the segments agree about it.
Point place_of(const EndKey& key) {
    return {static_cast<std::int32_t>(7 * key.a % 16), static_cast<std::int32_t>(5 * key.a % 16)};
}

/// Makes segments agree as those of a mesh do: ends with one key have one position, and ranks depend only on the
/// segment.
Segment agreeing(fuzz::Bytes& bytes) {
    Segment segment;
    segment.from_key.a = bytes.below(24);
    segment.to_key.a = bytes.below(24);
    segment.from = place_of(segment.from_key);
    segment.to = place_of(segment.to_key);
    segment.from_rank = static_cast<std::uint32_t>(segment.to_key.a % 5);
    segment.to_rank = static_cast<std::uint32_t>(segment.from_key.a % 3);
    return segment;
}

Segment arbitrary(fuzz::Bytes& bytes) {
    // Mixes the largest differences that a grid allows with small ones.
    const auto coordinate = [&bytes] {
        const unsigned byte = bytes.next();
        return byte >= 0xF8 ? (byte % 2 == 0 ? grid_limit : -grid_limit) : static_cast<std::int32_t>(byte % 8);
    };
    Segment segment;
    segment.from_key = {bytes.below(4), bytes.below(2), bytes.below(2)};
    segment.to_key = {bytes.below(4), bytes.below(2), bytes.below(2)};
    segment.from = {coordinate(), coordinate()};
    segment.to = {coordinate(), coordinate()};
    segment.from_rank = bytes.below(3);
    segment.to_rank = bytes.below(3);
    return segment;
}

SliceResult assembled(const std::vector<Segment>& segments) {
    SliceResult layer = fuzz::value_of(assemble(segments));  // any segments can be assembled
    fuzz::require_valid(layer);
    std::uint64_t used = 0;
    for (const Contour& contour : layer.contours) {
        used += contour.segments;
    }
    fuzz::require(used == segments.size(), "every segment is used exactly once");
    return layer;
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::Bytes bytes(data, size);
    const std::uint32_t seed = bytes.next();
    const bool agree = seed % 2 == 0;
    std::vector<Segment> segments;
    while (!bytes.empty() && segments.size() < most_segments) {
        segments.push_back(agree ? agreeing(bytes) : arbitrary(bytes));
    }
    const SliceResult layer = assembled(segments);
    fuzz::shuffle(segments, seed);
    const SliceResult again = assembled(segments);
    fuzz::require(!agree || layer.hash() == again.hash(), "the order of the segments does not change the result");
    return 0;
}
