#include "io/read/obj_off/off_tokens.hpp"

#include <cstring>
#include <limits>

#include "io/read/lookout.hpp"
#include "io/read/obj_off/faces.hpp"

namespace lamella {

namespace {

/// How numbers that belong to neither coordinates nor corners are told apart.
enum class OffExtras : std::uint8_t {
    to_line_end,  ///< normals and colours: what is left of the line, of as many numbers for every face
    none,         ///< there are none, and the number of edges is not left out
};

/// Goes through all numbers of the body. Runs twice: first to count and to check, then to write.
class OffTokens : private OffNumbers {
public:
    OffTokens(std::string_view text, OffExtras extras, const Parallel& parallel)
        : OffNumbers(text), extras_(extras), lookout_(parallel) {}

    /// Past the head.
    bool begin(OffCounts& counts);
    /// Counts the faces, with the place of each.
    bool count(FaceRange& faces);
    void write(std::byte* coordinates, FaceWriter& faces);
    /// Where the face of this number begins, of those with three corners or more.
    const char* place_of_face(std::size_t number);

    bool ended_early() const { return ended_early_; }
    /// Where the vertex or face begins that was read last.
    const char* item() const { return item_; }
    using OffNumbers::failure;

private:
    bool to_number(const char* what);
    bool vertex(std::byte* to);
    template <class Corner>
    bool face(std::size_t& corners, Corner corner);
    bool extras(std::size_t most, std::size_t& count);

    OffExtras extras_;
    Lookout lookout_;
    OffCounts counts_;
    std::size_t face_extras_ = std::numeric_limits<std::size_t>::max();  // of the first face
    const char* item_ = nullptr;
    bool ended_early_ = false;
};

bool OffTokens::begin(OffCounts& counts) {
    if (extras_ == OffExtras::to_line_end) {
        if (!header(counts_)) {
            return false;
        }
    } else {
        const std::string_view word = off_header_word({p_, static_cast<std::size_t>(end_ - p_)});
        std::size_t edges = 0;
        p_ = word.empty() ? p_ : word.data() + word.size();
        if (word.find_first_of("STCN4n") != std::string_view::npos) {
            return fail("numbers beside coordinates and corners");
        }
        if (!to_number("the number of vertices") || !whole_number(counts_.vertices, "the number of vertices") ||
            !to_number("the number of faces") || !whole_number(counts_.faces, "the number of faces") ||
            !to_number("the number of edges") || !whole_number(edges, "the number of edges")) {
            return false;
        }
    }
    counts = counts_;
    return true;
}

bool OffTokens::to_number(const char* what) {
    if (next_word()) {
        return true;
    }
    ended_early_ = true;
    return fail(std::string("expected ") + what + ", found the end of the file");
}

bool OffTokens::extras(std::size_t most, std::size_t& count) {
    const char* const begin = p_;
    for (count = 0; extras_ == OffExtras::to_line_end && to_word(); ++count) {
        double ignored = 0;
        if (count == most || !coordinate(ignored)) {
            p_ = begin;
            return fail("expected the end of the line");
        }
    }
    return true;
}

bool OffTokens::vertex(std::byte* to) {
    constexpr std::size_t normal_colour_and_texture = 3 + 4 + 2;
    lookout_.pass();
    next_word();
    item_ = p_;
    double xyz[3];
    for (double& value : xyz) {
        if (!to_number("a coordinate") || !coordinate(value)) {
            return false;
        }
    }
    if (to != nullptr) {
        std::memcpy(to, xyz, sizeof xyz);
    }
    std::size_t count = 0;
    return extras(normal_colour_and_texture, count);
}

template <class Corner>
bool OffTokens::face(std::size_t& corners, Corner corner) {
    constexpr std::size_t colour = 4;
    next_word();
    item_ = p_;
    if (!to_number("the number of a face's corners") || !whole_number(corners, "the number of a face's corners")) {
        return false;
    }
    lookout_.pass();
    for (std::size_t i = 0; i < corners; ++i) {
        lookout_.pass();
        std::uint32_t vertex = 0;
        if (!to_number("a vertex number") || !vertex_number(counts_.vertices, vertex)) {
            return false;
        }
        corner(vertex);
    }
    std::size_t count = 0;
    if (!extras(colour, count)) {
        return false;
    }
    if (face_extras_ != std::numeric_limits<std::size_t>::max() && face_extras_ != count) {
        return fail("expected as many numbers after the corners as in the faces before");
    }
    face_extras_ = count;
    return true;
}

bool OffTokens::count(FaceRange& faces) {
    for (std::size_t i = 0; i < counts_.vertices; ++i) {
        if (!vertex(nullptr)) {
            return false;
        }
    }
    for (std::size_t i = 0; i < counts_.faces; ++i) {
        std::size_t corners = 0;
        if (!face(corners, [](std::uint32_t) {})) {
            return false;
        }
        faces.add(corners, item_);
    }
    return extras_ == OffExtras::to_line_end || !next_word() || fail("expected the end of the file");
}

void OffTokens::write(std::byte* coordinates, FaceWriter& faces) {
    constexpr std::size_t vertex_bytes = 3 * sizeof(double);
    for (std::size_t i = 0; i < counts_.vertices; ++i) {
        vertex(coordinates + i * vertex_bytes);
    }
    for (std::size_t i = 0; i < counts_.faces; ++i) {
        std::size_t corners = 0;
        face(corners, [&faces](std::uint32_t vertex) { faces.add_corner(vertex); });
        if (corners < 3) {
            faces.drop_face();
        } else {
            faces.end_face();
        }
    }
}

const char* OffTokens::place_of_face(std::size_t number) {
    for (std::size_t i = 0; i < counts_.vertices; ++i) {
        vertex(nullptr);
    }
    for (;;) {
        std::size_t corners = 0;
        face(corners, [](std::uint32_t) {});
        if (corners >= 3 && number-- == 0) {
            return item_;
        }
    }
}

}  // namespace

std::optional<Result<MeshFile>> read_off_tokens(const FileSource& source, std::string_view whole, std::string_view text,
                                                std::size_t refused_offset, TextFailure& failure) {
    for (const OffExtras extras : {OffExtras::to_line_end, OffExtras::none}) {
        const auto start = [&](OffTokens& tokens) {
            OffCounts counts;
            return tokens.begin(counts) && counts.fit(text.size()) ? std::optional(counts) : std::nullopt;
        };
        std::vector<FaceRange> faces(1);
        OffTokens counter(text, extras, source.parallel());
        const std::optional<OffCounts> counts = start(counter);
        if (!counts || !counter.count(faces[0])) {
            if (counter.ended_early() && failure.at == nullptr && counter.item() > whole.data() + refused_offset) {
                failure = counter.failure();
            }
            continue;
        }
        return read_faces(
            source, whole, counts->vertices, faces,
            [&](std::size_t, std::byte* coordinates, FaceWriter& writer) {
                OffTokens tokens(text, extras, source.parallel());
                (void)start(tokens);
                tokens.write(coordinates, writer);
                return TextFailure();
            },
            [&](std::size_t, std::size_t face) {
                OffTokens tokens(text, extras, source.parallel());
                (void)start(tokens);
                return tokens.place_of_face(face);
            });
    }
    return std::nullopt;
}

}  // namespace lamella
