#include "io/read/arrays/array_file.hpp"

#include <concepts>

#include "io/read/faces.hpp"

namespace lamella {

namespace {

constexpr std::size_t word_piece_bytes = std::size_t{256} << 10;

/// Few numbers with the space after them are longer. The first window of a run is cut by this, so that little text beyond
/// the run is counted.
constexpr std::uint64_t usual_word_bytes = 12;

/// Words that follow each other in a text.
struct WordRun {
    std::vector<TextPiece> pieces;  // each begins with space or with a word, and has words
    const char* end = nullptr;      // after the last word
};

/// The next `count` words of [p, end). O(the text that they take). Precondition: `p` is not within a word.
WordRun find_words(const ArrayFile& file, const char* p, const char* end, std::uint64_t count, std::string_view name) {
    WordRun run;
    run.end = p;
    std::uint64_t found = 0;
    while (found < count && p != end) {
        const auto left = static_cast<std::uint64_t>(end - p);
        const std::uint64_t window = std::min(left, std::min(count - found, left) * usual_word_bytes);
        const char* const window_end = skip_word(p + window, end);
        std::vector<TextPiece> pieces =
            cut_text({p, static_cast<std::size_t>(window_end - p)}, word_piece_bytes,
                     [window_end](const char*, const char* from) { return skip_word(from, window_end); });
        file.source.parallel().run(pieces.size(),
                                   [&](std::size_t i, int) { pieces[i].count = count_words(pieces[i].text); });
        for (TextPiece& piece : pieces) {
            piece.first = found;
            piece.count = std::min<std::size_t>(piece.count, count - found);
            found += piece.count;
            if (piece.count > 0) {
                run.pieces.push_back(piece);
            }
        }
        p = window_end;
    }
    if (found < count) {
        throw TextError{end, "expected " + std::to_string(count) + " numbers of " + std::string(name) + ", found " +
                                 std::to_string(found)};
    }
    if (!run.pieces.empty()) {
        run.end = skip_word(find_word(run.pieces.back().begin(), end, run.pieces.back().count - 1), end);
    }
    return run;
}

void read_word(const char*& p, const char* end, std::floating_point auto& value, bool takes_nan) {
    const NumberText got = read_number(p, end, value);
    if (got == NumberText::not_finite && takes_nan) {
        p = skip_word(p, end);
    } else if (got != NumberText::read) {
        throw TextError{p, coordinate_problem(got, "number", word_at(p, end))};
    }
}

template <std::unsigned_integral Value>
void read_word(const char*& p, const char* end, Value& value, bool /*takes_nan*/) {
    constexpr std::ptrdiff_t surely_exact = 9;  // digits, of any type
    std::uint64_t number = 0;
    const char* const word_end = read_digits(p, end, number);
    value = static_cast<Value>(number);
    const bool fits = word_end - p <= surely_exact || std::from_chars(p, end, value).ec == std::errc();
    if (!fits || word_end == p || (word_end != end && !is_space(*word_end))) {
        throw TextError{p, "expected an integer from 0 to " + std::to_string(std::numeric_limits<Value>::max()) +
                               ", found " + word_at(p, end)};
    }
    p = word_end;
}

/// Words are read up to `end`, across cuts.
template <class Value>
void read_run(const WordRun& run, const char* end, std::byte* storage, const ArrayFile& file) {
    auto* const out = reinterpret_cast<Value*>(storage);
    parse_pieces(run.pieces.size(), file.source.parallel(), [&](std::size_t i, int) {
        const TextPiece& piece = run.pieces[i];
        const char* p = piece.begin();
        for (std::size_t word = piece.first; word < piece.end_item(); ++word) {
            p = skip_space(p, end);
            read_word(p, end, out[word], file.takes_nan);
        }
    });
}

template <class Out>
void decode(const NumberArray& numbers, std::uint64_t first, std::uint64_t count, void* to) {
    use_numbers(numbers, first, [&](auto number) {
        auto* out = static_cast<std::byte*>(to);
        for (std::uint64_t i = 0; i < count; ++i, out += sizeof(Out)) {
            const Out value = static_cast<Out>(number(i));  // NOLINT(bugprone-signed-char-misuse): -1 stays -1
            std::memcpy(out, &value, sizeof(Out));
        }
    });
}

/// Converts all of `numbers` in parallel, without alignment. `out` may be where they lie, if that is their type.
void convert_coordinates(const NumberArray& numbers, Number type, std::byte* out, const Parallel& parallel) {
    constexpr std::size_t grain = std::size_t{1} << 16;
    parallel.run_ranges(numbers.count, grain, [&](std::size_t begin, std::size_t end, int) {
        const auto convert = type == Number::f32 ? decode<float> : decode<double>;
        convert(numbers, begin, end - begin, out + begin * size_of(type));
    });
}

}  // namespace

TextError ArrayFile::error_at(const NumberArray& numbers, std::uint64_t index, const std::string& what) const {
    switch (numbers.form) {
        case NumberArray::Form::text:
            return {find_word(numbers.at, text.data() + text.size(), index), what};
        case NumberArray::Form::bytes:
            return {numbers.at + index * size_of(numbers.type), what, false};
        case NumberArray::Form::encoded:
            break;
    }
    return {numbers.at, "number " + std::to_string(index) + ": " + what};
}

// --- text

NumberArray read_words(ArrayFile& file, const char*& p, const char* end, std::uint64_t count, NumberType type,
                       std::string_view name) {
    const WordRun run = find_words(file, p, end, count, name);
    file.budget.take(count, size_of(type));
    NumberArray numbers{nullptr, count, type, false, NumberArray::Form::text, p, Array<std::byte>(file.source.memory())};
    numbers.storage.resize_discarding(count * size_of(type));
    numbers.data = numbers.storage.data();
    const auto read = type == NumberType::float32   ? read_run<float>
                      : type == NumberType::float64 ? read_run<double>
                      : type == NumberType::uint32  ? read_run<std::uint32_t>
                                                    : read_run<std::uint64_t>;
    read(run, end, numbers.storage.data(), file);
    p = run.end;
    return numbers;
}

NumberArray read_all_words(ArrayFile& file, std::string_view text, std::uint64_t count, NumberType type,
                           std::string_view name) {
    const char* p = text.data();
    const char* const end = p + text.size();
    NumberArray numbers = read_words(file, p, end, count, type, name);
    p = skip_space(p, end);
    if (p != end) {
        throw TextError{p, "expected the end of the " + std::to_string(count) + " numbers of " + std::string(name) +
                               ", found " + word_at(p, end)};
    }
    return numbers;
}

void skip_words(const ArrayFile& file, const char*& p, const char* end, std::uint64_t count, std::string_view name) {
    p = find_words(file, p, end, count, name).end;
}

const char* find_word(const char* p, const char* end, std::uint64_t index) {
    p = skip_space(p, end);
    for (; index > 0 && p != end; --index) {
        p = skip_space(skip_word(p, end), end);
    }
    return p;
}

// --- memory

void give_points(ArrayFile& file, std::span<NumberArray> arrays, MeshFile& mesh) {
    bool floats = true;
    std::uint64_t numbers = 0;
    for (const NumberArray& array : arrays) {
        floats = floats && (array.type == NumberType::float32 || size_of(array.type) <= 2);
        mesh.text = mesh.text || array.form == NumberArray::Form::text;
        numbers += array.count;
    }
    // Without loss up to integers of 53 bits.
    mesh.vertex_type = floats ? Number::f32 : Number::f64;
    mesh.vertex_count = numbers / 3;
    mesh.stride = 3 * size_of(mesh.vertex_type);
    if (arrays.size() == 1 && !is_integer(arrays[0].type)) {
        const bool in_file = arrays[0].form == NumberArray::Form::bytes;
        mesh.first_offset =
            in_file ? file.offset_of(arrays[0].at) : static_cast<std::size_t>(arrays[0].data - arrays[0].storage.data());
        mesh.bytes = std::move(in_file ? file.bytes : arrays[0].storage);
    } else {
        allocate_vertices(mesh.vertex_count, mesh.vertex_type, file.budget, file.source.memory(), mesh);
    }
    std::byte* out = mesh.bytes.data() + mesh.first_offset;
    for (const NumberArray& array : arrays) {
        convert_coordinates(array, mesh.vertex_type, out, file.source.parallel());
        out += array.count * size_of(mesh.vertex_type);
    }
}

void give_scalars(ArrayFile& file, VertexScalars scalars, FunctionRef<std::vector<NumberArray>()> load, MeshFile& mesh) {
    file.takes_nan = true;  // coordinates have been read
    try {
        const std::vector<NumberArray> arrays = load();
        std::size_t count = 0;
        std::for_each(arrays.begin(), arrays.end(), [&](const NumberArray& array) { count += array.count; });
        file.budget.take(count, sizeof(double));
        scalars.values = Array<double>(file.source.memory());
        scalars.values.resize_discarding(count);
        auto* out = reinterpret_cast<std::byte*>(scalars.values.data());
        for (const NumberArray& array : arrays) {
            convert_coordinates(array, Number::f64, out, file.source.parallel());
            out += array.count * sizeof(double);
            file.budget.give_back(array.storage.size());  // which go with the arrays
        }
        mesh.scalars.push_back(std::move(scalars));
    } catch (const TextError& error) {
        mesh.warnings.push_back(file.source.error_in_text(file.text, error).message + "; the values " +
                                in_quotes(scalars.name) + " at points are left out");
    }
}

}  // namespace lamella
