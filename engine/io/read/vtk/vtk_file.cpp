#include "io/read/vtk/vtk_file.hpp"

#include <concepts>
#include <limits>
#include <type_traits>

#include "io/read/vtk/number_words.hpp"
#include "io/text/text.hpp"

namespace lamella {

namespace {

template <class Value>
constexpr NumberType type_of() {
    if constexpr (std::is_same_v<Value, float>) {
        return NumberType::float32;
    } else if constexpr (std::is_same_v<Value, double>) {
        return NumberType::float64;
    } else {
        return sizeof(Value) == 4 ? NumberType::uint32 : NumberType::uint64;
    }
}

template <class Value>
std::string complaint(const BadWord& bad, const char* end) {
    const std::string found = word_at(bad.at, end);
    if constexpr (std::floating_point<Value>) {
        return coordinate_problem(bad.why, "number", found);
    } else {
        return "expected an integer from 0 to " + std::to_string(std::numeric_limits<Value>::max()) + ", found " + found;
    }
}

Result<WordRun> find_array(const VtkFile& file, const char* p, const char* end, std::uint64_t count, std::string_view name) {
    WordRun run = find_words(p, end, count, file.source.parallel());
    if (run.count < count) {
        return file.error_at(end, "expected " + std::to_string(count) + " numbers of " + std::string(name) + ", found " +
                                      std::to_string(run.count));
    }
    return run;
}

}  // namespace

Error VtkFile::error_at(const NumberArray& numbers, std::uint64_t index, const std::string& what) const {
    switch (numbers.place.form) {
        case NumberPlace::Form::text:
            return error_at(find_word(text.data() + numbers.place.offset, text.data() + text.size(), index), what);
        case NumberPlace::Form::bytes: {
            const std::uint64_t byte = numbers.place.offset + index * bytes_of(numbers.type);
            return source.error(ErrorCode::malformed_mesh, "byte " + std::to_string(byte) + ": " + what,
                                static_cast<std::int64_t>(byte));
        }
        case NumberPlace::Form::encoded:
            break;
    }
    return error_at(text.data() + numbers.place.offset, "number " + std::to_string(index) + ": " + what);
}

template <class Value>
Result<NumberArray> read_text_array(VtkFile& file, const char*& p, const char* end, std::uint64_t count,
                                    std::string_view name, Array<std::byte>& storage) {
    const Result<WordRun> run = find_array(file, p, end, count, name);
    if (!run) {
        return run.error();
    }
    if (Status room = file.budget.take(count, sizeof(Value)); !room) {
        return room.error();
    }
    storage.resize_discarding(count * sizeof(Value));
    const BadWord bad = read_words(run.value(), reinterpret_cast<Value*>(storage.data()), file.source.parallel());
    if (bad.at != nullptr) {
        return file.error_at(bad.at, complaint<Value>(bad, end));
    }
    const NumberPlace place{NumberPlace::Form::text, file.offset_of(p)};
    p = run.value().end;
    return NumberArray{storage.data(), count, type_of<Value>(), false, place};
}

template Result<NumberArray> read_text_array<float>(VtkFile&, const char*&, const char*, std::uint64_t, std::string_view,
                                                    Array<std::byte>&);
template Result<NumberArray> read_text_array<double>(VtkFile&, const char*&, const char*, std::uint64_t, std::string_view,
                                                     Array<std::byte>&);
template Result<NumberArray> read_text_array<std::uint32_t>(VtkFile&, const char*&, const char*, std::uint64_t,
                                                            std::string_view, Array<std::byte>&);
template Result<NumberArray> read_text_array<std::uint64_t>(VtkFile&, const char*&, const char*, std::uint64_t,
                                                            std::string_view, Array<std::byte>&);

Status skip_text_array(const VtkFile& file, const char*& p, const char* end, std::uint64_t count, std::string_view name) {
    const Result<WordRun> run = find_array(file, p, end, count, name);
    if (!run) {
        return run.error();
    }
    p = run.value().end;
    return {};
}

void convert_coordinates(const NumberArray& numbers, CoordinateType number, std::byte* out, const Parallel& parallel) {
    constexpr std::size_t grain = std::size_t{1} << 16;
    parallel.run_ranges(numbers.count, grain, [&](std::size_t begin, std::size_t end, int) {
        decode_coordinates(numbers, begin, end - begin, number, out + begin * bytes_of(number));
    });
}

}  // namespace lamella
