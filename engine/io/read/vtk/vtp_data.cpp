#include "io/read/vtk/vtp_document.hpp"

#include <zlib.h>

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

/// Six bits each of four letters, the first being the highest; 2^24 and more if one is no base64.
std::uint32_t bits_of(const char* letters) {
    const std::uint32_t a = value_of(letters[0]);
    const std::uint32_t b = value_of(letters[1]);
    const std::uint32_t c = value_of(letters[2]);
    const std::uint32_t d = value_of(letters[3]);
    const std::uint32_t invalid = (a | b | c | d) & 0x80;
    return invalid << 24 | a << 18 | b << 12 | c << 6 | d;
}

void put(std::uint32_t bits, std::byte* out) {
    out[0] = static_cast<std::byte>(bits >> 16);
    out[1] = static_cast<std::byte>(bits >> 8);
    out[2] = static_cast<std::byte>(bits);
}

/// Bytes that are read from front to back: raw, or from base64, which may hold several runs, each padded by '=', and white
/// space anywhere.
class ByteStream {
public:
    ByteStream(std::string_view bytes, bool is_base64) noexcept
        : p_(bytes.data()), end_(bytes.data() + bytes.size()), is_base64_(is_base64) {}

    bool is_raw() const noexcept { return !is_base64_; }

    /// At least as many bytes as are left.
    std::size_t most_left() const noexcept {
        const auto left = static_cast<std::size_t>(end_ - p_);
        return is_base64_ ? left / 4 * 3 + 3 + (read_end_ - read_begin_) : left;
    }

    /// Fills `out`. False: the bytes end before, or are no base64.
    bool read(std::span<std::byte> out) noexcept {
        if (!is_base64_) {
            const bool enough = out.size() <= most_left();
            std::memcpy(out.data(), p_, enough ? out.size() : 0);
            p_ += enough ? out.size() : 0;
            return enough;
        }
        while (!out.empty()) {
            if (read_begin_ == read_end_) {
                while (out.size() >= 3 && end_ - p_ >= 4) {
                    const std::uint32_t bits = bits_of(p_);
                    if (bits >> 24 != 0) {
                        break;
                    }
                    put(bits, out.data());
                    out = out.subspan(3);
                    p_ += 4;
                }
                if (out.empty()) {
                    return true;
                }
                if (!read_quad()) {
                    return false;
                }
            }
            const std::size_t count = std::min(out.size(), read_end_ - read_begin_);
            std::memcpy(out.data(), read_.data() + read_begin_, count);
            read_begin_ += count;
            out = out.subspan(count);
        }
        return true;
    }

    /// The next bytes where they lie. Precondition: is_raw(), and they are there.
    const std::byte* take(std::uint64_t count) noexcept {
        return reinterpret_cast<const std::byte*>(std::exchange(p_, p_ + count));
    }

private:
    /// Four letters with white space between them, of which the last one or two may be padding.
    bool read_quad() noexcept {
        std::array<char, 4> letters{};
        std::size_t padding = 0;
        for (std::size_t i = 0; i < letters.size(); ++i, ++p_) {
            p_ = skip_space(p_, end_);
            if (p_ == end_) {
                return false;
            }
            const bool pads = *p_ == '=' && i >= 2;
            padding += pads ? 1 : 0;
            if (!pads && (value_of(*p_) == no_letter || padding > 0)) {
                return false;
            }
            letters[i] = pads ? 'A' : *p_;
        }
        put(bits_of(letters.data()), read_.data());
        read_begin_ = 0;
        read_end_ = 3 - padding;
        return true;
    }

    const char* p_;
    const char* end_;
    bool is_base64_;
    std::array<std::byte, 3> read_{};  ///< of the last four letters; [read_begin_, read_end_) are yet to be given out
    std::size_t read_begin_ = 0;
    std::size_t read_end_ = 0;
};

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
    ArrayReader(VtkFile& file, const VtpForm& form, const VtpArray& array, ByteStream stream)
        : file_(file), form_(form), array_(array), stream_(stream), storage_(file.source.memory()) {}

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
    const std::byte* read_plain(std::uint64_t total) {
        std::uint64_t counted = 0;
        read_header({&counted, 1});
        if (counted != total) {
            fail("should have " + std::to_string(total) + " bytes, but counts " + std::to_string(counted));
        }
        if (!stream_.is_raw()) {
            storage_ = read_stored(total);
            return storage_.data();
        }
        if (total > stream_.most_left()) {
            fail_at_end();
        }
        return stream_.take(total);
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
        const std::uint64_t packed_bytes = blocks.ends.back();
        Array<std::byte> packed(file_.source.memory());
        if (!stream_.is_raw()) {
            packed = read_stored(packed_bytes);
        }
        const std::byte* const from = stream_.is_raw() ? stream_.take(packed_bytes) : packed.data();
        narrow_ = inflate_narrow(blocks, from);
        if (!narrow_) {
            file_.budget.take(total, 1);
            storage_.resize_discarding(total);
            inflate(blocks, from);
        }
        file_.budget.give_back(packed.size());
        return storage_.data();
    }

    /// Holds integers of 64 bits in 32 if all fit, as they nearly always do: they compress so well that they would exceed
    /// the memory limit of a small file. False: they do not fit or are damaged, and nothing is held.
    bool inflate_narrow(const Blocks& blocks, const std::byte* packed) {
        constexpr std::uint64_t wide = sizeof(std::uint64_t);
        constexpr std::uint64_t most_bytes = std::uint64_t{1} << 20;  // of a block, which each thread holds one of
        const std::uint64_t count = ((blocks.ends.size() - 1) * blocks.bytes + blocks.last_bytes) / wide;
        if (!is_integer(array_.type) || size_of(array_.type) != wide || blocks.bytes % wide != 0 ||
            blocks.last_bytes % wide != 0 || std::max(blocks.bytes, blocks.last_bytes) > most_bytes ||
            !file_.budget.try_take(count, sizeof(std::uint32_t))) {
            return false;
        }
        storage_.resize_discarding(count * sizeof(std::uint32_t));
        auto* const out = reinterpret_cast<std::uint32_t*>(storage_.data());
        const Parallel& parallel = file_.source.parallel();
        std::vector<std::vector<std::byte>> rooms(static_cast<std::size_t>(parallel.threads()));
        std::atomic<bool> good{true};
        parallel.run(blocks.ends.size(), [&](std::size_t i, int worker) {
            std::vector<std::byte>& room = rooms[static_cast<std::size_t>(worker)];
            room.resize(std::max(blocks.bytes, blocks.last_bytes));
            const std::uint64_t numbers = (i + 1 == blocks.ends.size() ? blocks.last_bytes : blocks.bytes) / wide;
            const NumberArray block{room.data(), numbers, array_.type, form_.big_endian};
            if (!good.load(std::memory_order_relaxed) || inflate_block(blocks, i, packed, room.data()) != Z_OK ||
                decode_indices(block, 0, numbers, out + i * blocks.bytes / wide) >
                    std::numeric_limits<std::uint32_t>::max()) {
                good.store(false, std::memory_order_relaxed);
            }
        });
        if (!good) {
            storage_ = Array<std::byte>(file_.source.memory());
            file_.budget.give_back(count * sizeof(std::uint32_t));
        }
        return good;
    }

    void inflate(const Blocks& blocks, const std::byte* packed) {
        parse_pieces(blocks.ends.size(), file_.source.parallel(), [&](std::size_t i, int) {
            const int answer = inflate_block(blocks, i, packed, storage_.data() + i * blocks.bytes);
            if (answer == Z_MEM_ERROR) {
                throw std::bad_alloc();
            }
            if (answer != Z_OK) {
                fail("is damaged: its compressed block " + std::to_string(i) + " does not expand to what is counted");
            }
        });
    }

    int inflate_block(const Blocks& blocks, std::size_t block, const std::byte* packed, std::byte* out) const {
        const std::uint64_t begin = block == 0 ? 0 : blocks.ends[block - 1];
        const std::uint64_t wanted = block + 1 == blocks.ends.size() ? blocks.last_bytes : blocks.bytes;
        uLongf got = wanted;
        const int answer = uncompress(reinterpret_cast<Bytef*>(out), &got, reinterpret_cast<const Bytef*>(packed + begin),
                                      blocks.ends[block] - begin);
        return answer == Z_OK && got != wanted ? Z_DATA_ERROR : answer;
    }

    void read_header(std::span<std::uint64_t> numbers) {
        std::array<std::byte, 8> bytes{};
        Lookout lookout(file_.source.parallel());
        for (std::uint64_t& number : numbers) {
            lookout.pass();
            if (!stream_.read(std::span(bytes).first(form_.header_bytes))) {
                fail_at_end();
            }
            number = form_.header_bytes == 4 ? load_number<std::uint32_t>(bytes.data(), form_.big_endian)
                                             : load_number<std::uint64_t>(bytes.data(), form_.big_endian);
        }
    }

    Blocks read_blocks() {
        std::array<std::uint64_t, 3> counts{};
        read_header(counts);
        if (counts[0] > stream_.most_left() / form_.header_bytes) {
            fail("is truncated: counts " + std::to_string(counts[0]) + " compressed blocks");
        }
        file_.budget.take(counts[0], sizeof(std::uint64_t));
        Blocks blocks{counts[1], counts[2] == 0 ? counts[1] : counts[2], std::vector<std::uint64_t>(counts[0])};
        read_header(blocks.ends);
        std::uint64_t end = 0;
        for (std::uint64_t& block : blocks.ends) {
            if (block > stream_.most_left() - end) {
                fail("is truncated within its compressed blocks");
            }
            end += block;
            block = end;
        }
        return blocks;
    }

    /// Copies the next `count` bytes, once they are known to be there.
    Array<std::byte> read_stored(std::uint64_t count) {
        if (count > stream_.most_left()) {
            fail_at_end();
        }
        file_.budget.take(count, 1);
        Array<std::byte> bytes(file_.source.memory());
        bytes.resize_discarding(count);
        constexpr std::size_t piece_bytes = std::size_t{1} << 20;
        for (std::span<std::byte> rest = bytes.span(); !rest.empty();) {
            file_.source.parallel().stop_if_asked();
            const std::span<std::byte> piece = rest.first(std::min(piece_bytes, rest.size()));
            if (!stream_.read(piece)) {
                fail_at_end();
            }
            rest = rest.subspan(piece.size());
        }
        return bytes;
    }

    [[noreturn]] void fail(const std::string& what) const {
        throw TextError{array_.element, std::string(array_.name) + " " + what};
    }
    [[noreturn]] void fail_at_end() const { fail("is truncated, or malformed base64"); }

    VtkFile& file_;
    const VtpForm& form_;
    const VtpArray& array_;
    ByteStream stream_;
    Array<std::byte> storage_;
    bool narrow_ = false;  // its integers of 64 bits became such of 32
};

ByteStream stream_of(const VtpForm& form, const VtpArray& array) {
    if (array.format == VtpArray::Format::binary) {
        return {array.content, true};
    }
    const std::string_view text = form.appended.substr(std::min<std::uint64_t>(array.appended_offset, form.appended.size()));
    return {text, form.appended_as_base64};
}

}  // namespace

NumberArray load_array(VtkFile& file, const VtpForm& form, const VtpArray& array, std::uint64_t count, NumberType as) {
    if (array.format != VtpArray::Format::ascii) {
        return ArrayReader(file, form, array, stream_of(form, array)).read(count);
    }
    const char* p = array.content.data();
    const char* const end = p + array.content.size();
    NumberArray numbers = read_words(file, p, end, count, as, array.name);
    p = skip_space(p, end);
    if (p != end) {
        throw TextError{p, "expected the end of the " + std::to_string(count) + " numbers of " + std::string(array.name) +
                               ", found " + word_at(p, end)};
    }
    return numbers;
}

}  // namespace lamella
