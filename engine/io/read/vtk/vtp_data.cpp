#include "io/read/vtk/vtp_data.hpp"

#include <zlib.h>

#include <atomic>
#include <limits>
#include <new>

namespace lamella {

namespace {

constexpr std::string_view zlib_compressor = "vtkZLibDataCompressor";

/// zlib compresses by a factor of 1032 at most.
constexpr std::uint64_t most_expansion = 1032;

// --- Base64 (RFC 4648), decoded as a stream

constexpr std::uint32_t no_letter = 0xFF;

constexpr std::array<std::uint8_t, 256> values = [] {
    constexpr std::string_view alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::array<std::uint8_t, 256> table{};
    table.fill(no_letter);
    for (std::size_t i = 0; i < alphabet.size(); ++i) {
        table[static_cast<unsigned char>(alphabet[i])] = static_cast<std::uint8_t>(i);
    }
    return table;
}();

std::uint32_t value_of(char letter) {
    return values[static_cast<unsigned char>(letter)];
}

/// Writes the three bytes that four letters are. False: one is no base64.
bool decode_four(const char* letters, std::byte* out) {
    const std::uint32_t a = value_of(letters[0]);
    const std::uint32_t b = value_of(letters[1]);
    const std::uint32_t c = value_of(letters[2]);
    const std::uint32_t d = value_of(letters[3]);
    out[0] = static_cast<std::byte>(a << 2 | b >> 4);
    out[1] = static_cast<std::byte>(b << 4 | c >> 2);
    out[2] = static_cast<std::byte>(c << 6 | d);
    return ((a | b | c | d) & 0x80) == 0;
}

/// Decodes four letters with white space between them, of which the last one or two may be padding, and moves `p` past them.
/// Returns how many bytes of `out` they are; 0: they are no base64.
std::size_t decode_quad(const char*& p, const char* end, std::byte* out) {
    std::array<char, 4> letters{};
    std::size_t padding = 0;
    for (std::size_t i = 0; i < letters.size(); ++i, ++p) {
        p = skip_space(p, end);
        const bool pads = p != end && *p == '=' && i >= 2;
        padding += pads ? 1 : 0;
        if (p == end || (!pads && padding > 0)) {
            return 0;
        }
        letters[i] = pads ? 'A' : *p;
    }
    return decode_four(letters.data(), out) ? 3 - padding : 0;
}

/// Fills `out` from the begin of `text`, which may hold several runs, each padded by '=', and white space anywhere. False:
/// it ends before, or is no base64.
bool decode_base64(std::string_view text, std::span<std::byte> out, const Parallel& parallel) {
    const char* p = text.data();
    const char* const end = p + text.size();
    while (!out.empty()) {
        parallel.stop_if_asked();
        std::size_t quads = std::min({out.size() / 3, static_cast<std::size_t>(end - p) / 4, std::size_t{1} << 18});
        for (; quads > 0 && decode_four(p, out.data()); --quads, p += 4) {
            out = out.subspan(3);
        }
        std::array<std::byte, 3> three{};
        const std::size_t count = out.empty() ? 0 : std::min(out.size(), decode_quad(p, end, three.data()));
        if (count == 0) {
            return out.empty();
        }
        std::memcpy(out.data(), three.data(), count);
        out = out.subspan(count);
    }
    return true;
}

/// Data that are compressed in blocks.
struct Blocks {
    std::uint64_t bytes = 0;  ///< of each but the last
    std::uint64_t last_bytes = 0;
    std::vector<std::uint64_t> ends;  ///< of each, in the compressed data

    /// True if they expand to `total` bytes, more than none.
    bool hold(std::uint64_t total) const noexcept {
        if (ends.empty() || last_bytes > total) {
            return false;
        }
        const std::uint64_t others = ends.size() - 1;
        const std::uint64_t left = total - last_bytes;
        return others == 0 ? left == 0 : left % others == 0 && left / others == bytes;
    }
};

/// Reads the bytes of one array. Throws TextErrors at its element.
class ArrayReader {
public:
    ArrayReader(VtkFile& file, const VtpForm& form, const VtpArray& array) : file_(file), form_(form), array_(array) {}

    /// Its `count` numbers, which lie where they are or in a storage of their own.
    NumberArray read(std::uint64_t count) {
        if (count > std::numeric_limits<std::uint64_t>::max() / sizeof(double)) {
            fail("should have " + std::to_string(count) + " numbers, which no file has");
        }
        const std::uint64_t total = count * size_of(array_.type);
        NumberArray numbers;
        numbers.data = form_.compressor.empty() ? read_plain(total) : read_compressed(total);
        numbers.count = count;
        numbers.type = narrow_ ? NumberType::uint32 : array_.type;
        numbers.big_endian = form_.big_endian && !narrow_;
        const bool in_file = storage_.empty();
        numbers.form = in_file ? NumberArray::Form::bytes : NumberArray::Form::encoded;
        numbers.at = in_file ? reinterpret_cast<const char*>(numbers.data) : array_.element;
        numbers.storage = std::move(storage_);
        return numbers;
    }

private:
    static constexpr std::uint64_t wide = sizeof(std::uint64_t);

    const std::byte* read_plain(std::uint64_t total) {
        const std::uint64_t counted = header(1).front();
        if (counted != total) {
            fail("should have " + std::to_string(total) + " bytes, but counts " + std::to_string(counted));
        }
        return bytes(form_.header_bytes, total, storage_);
    }

    const std::byte* read_compressed(std::uint64_t total) {
        if (form_.compressor != zlib_compressor) {
            fail("is compressed by '" + printable(form_.compressor) + "', which is not read: only " +
                 std::string(zlib_compressor) + " is");
        }
        const Blocks blocks = read_blocks();
        if (!blocks.hold(total) || total / most_expansion > blocks.ends.back()) {
            fail("should have " + std::to_string(total) + " bytes, which its compressed blocks do not hold");
        }
        Array<std::byte> decoded(file_.source.memory());
        const std::byte* const packed = bytes((3 + blocks.ends.size()) * form_.header_bytes, blocks.ends.back(), decoded);
        // Integers of 64 bits compress so well that they would exceed the memory limit of a small file.
        narrow_ = is_integer(array_.type) && size_of(array_.type) == wide && blocks.bytes % wide == 0 &&
                  blocks.last_bytes % wide == 0;
        if (!inflate(blocks, packed, total)) {
            narrow_ = false;
            inflate(blocks, packed, total);
        }
        file_.budget.give_back(decoded.size());
        return storage_.data();
    }

    /// The bytes [begin, begin + count) of those that the file holds, once they are known to be there: where they lie, or in
    /// `decoded`.
    const std::byte* bytes(std::uint64_t begin, std::uint64_t count, Array<std::byte>& decoded) {
        if (begin > most_bytes() || count > most_bytes() - begin) {
            fail_at_end();
        }
        if (!is_base64_) {
            return reinterpret_cast<const std::byte*>(text_.data() + begin);
        }
        decoded.resize_discarding(taken(begin + count));
        if (!decode_base64(text_, decoded.span(), file_.source.parallel())) {
            fail_at_end();
        }
        return decoded.data() + begin;
    }

    /// At least as many as the file holds.
    std::uint64_t most_bytes() const noexcept { return is_base64_ ? text_.size() / 4 * 3 + 3 : text_.size(); }

    /// The `count` numbers that the array begins with.
    std::vector<std::uint64_t> header(std::uint64_t count) {
        Array<std::byte> decoded(file_.source.memory());
        const std::byte* const from = bytes(0, count * form_.header_bytes, decoded);
        std::vector<std::uint64_t> numbers(count);
        for (std::uint64_t i = 0; i < count; ++i) {
            numbers[i] = integer_at(
                {from, count, form_.header_bytes == 4 ? NumberType::uint32 : NumberType::uint64, form_.big_endian}, i);
        }
        file_.budget.give_back(decoded.size());
        return numbers;
    }

    Blocks read_blocks() {
        std::vector<std::uint64_t> numbers = header(3);
        if (numbers[0] > most_bytes() / form_.header_bytes) {
            fail("is truncated: counts " + std::to_string(numbers[0]) + " compressed blocks");
        }
        file_.budget.take(numbers[0], sizeof(std::uint64_t));
        Blocks blocks{numbers[1], numbers[2] == 0 ? numbers[1] : numbers[2], header(3 + numbers[0])};
        blocks.ends.erase(blocks.ends.begin(), blocks.ends.begin() + 3);
        std::uint64_t end = 0;
        for (std::uint64_t& block : blocks.ends) {
            if (block > most_bytes() - end) {
                fail("is truncated within its compressed blocks");
            }
            end += block;
            block = end;
        }
        return blocks;
    }

    /// By `narrow_` into integers of 32 bits. False: some do not fit, and nothing is held.
    bool inflate(const Blocks& blocks, const std::byte* packed, std::uint64_t total) {
        const std::uint64_t held = taken(narrow_ ? total / 2 : total);
        storage_.resize_discarding(held);
        std::atomic<bool> fits{true};
        const std::size_t count = blocks.ends.size();
        const Parallel& parallel = file_.source.parallel();
        const std::uint64_t room_bytes = narrow_ ? std::max(blocks.bytes, blocks.last_bytes) : 0;
        const std::uint64_t rooms_bytes = taken(room_bytes * parallel.workers_for(count));
        std::vector<std::vector<std::byte>> rooms(static_cast<std::size_t>(parallel.threads()));
        parse_pieces(count, parallel, [&](std::size_t i, int worker) {
            std::vector<std::byte>& room = rooms[static_cast<std::size_t>(worker)];
            room.resize(room_bytes);
            const std::uint64_t wanted = i + 1 == count ? blocks.last_bytes : blocks.bytes;
            const std::uint64_t begin = i == 0 ? 0 : blocks.ends[i - 1];
            std::byte* const out = narrow_ ? room.data() : storage_.data() + i * blocks.bytes;
            auto got = static_cast<uLongf>(wanted);  // of which some systems have 32 bits: a larger block is refused
            const int answer =
                uncompress(reinterpret_cast<Bytef*>(out), &got, reinterpret_cast<const Bytef*>(packed + begin),
                           static_cast<uLong>(blocks.ends[i] - begin));
            if (answer == Z_MEM_ERROR) {
                throw std::bad_alloc();
            }
            if (answer != Z_OK || got != wanted) {
                fail("is damaged: its compressed block " + std::to_string(i) + " does not expand to what is counted");
            }
            if (narrow_ && !narrow(out, wanted / wide, storage_.data() + i * blocks.bytes / 2)) {
                fits.store(false, std::memory_order_relaxed);
            }
        });
        file_.budget.give_back(rooms_bytes);
        if (!fits) {
            storage_ = Array<std::byte>(file_.source.memory());
            file_.budget.give_back(held);
        }
        return fits;
    }

    /// False: some integer does not fit.
    bool narrow(const std::byte* from, std::uint64_t count, std::byte* to) const {
        std::uint64_t all = 0;
        for (std::uint64_t i = 0; i < count; ++i) {
            const auto value = load_number<std::uint64_t>(from + i * wide, form_.big_endian);
            const auto narrow = static_cast<std::uint32_t>(value);
            std::memcpy(to + i * sizeof narrow, &narrow, sizeof narrow);
            all |= value;
        }
        return all <= std::numeric_limits<std::uint32_t>::max();
    }

    /// Counts bytes that are about to be allocated.
    std::uint64_t taken(std::uint64_t bytes) const {
        file_.budget.take(bytes, 1);
        return bytes;
    }

    [[noreturn]] void fail(const std::string& what) const { throw TextError{array_.element, array_.name + " " + what}; }
    [[noreturn]] void fail_at_end() const { fail("is truncated, or malformed base64"); }

    VtkFile& file_;
    const VtpForm& form_;
    const VtpArray& array_;
    const bool is_inline_ = array_.format == VtpArray::Format::binary;
    const bool is_base64_ = is_inline_ || form_.appended_as_base64;
    const std::string_view text_ =  // from the array's begin
        is_inline_ ? array_.content
                   : form_.appended.substr(std::min<std::uint64_t>(array_.appended_offset, form_.appended.size()));
    Array<std::byte> storage_{file_.source.memory()};
    bool narrow_ = false;  // its integers of 64 bits became such of 32
};

}  // namespace

NumberArray load_array(VtkFile& file, const VtpForm& form, const VtpArray& array, std::uint64_t count, NumberType as) {
    if (array.format != VtpArray::Format::ascii) {
        return ArrayReader(file, form, array).read(count);
    }
    const char* p = array.content.data();
    const char* const end = p + array.content.size();
    NumberArray numbers = read_words(file, p, end, count, as, array.name);
    p = skip_space(p, end);
    if (p != end) {
        throw TextError{p, "expected the end of the " + std::to_string(count) + " numbers of " + array.name + ", found " +
                               word_at(p, end)};
    }
    return numbers;
}

}  // namespace lamella
