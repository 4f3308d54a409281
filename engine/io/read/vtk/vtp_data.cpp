#include "io/read/vtk/vtp_data.hpp"

#include <zlib.h>

#include <atomic>
#include <limits>
#include <new>

#include "io/text/base64.hpp"

namespace lamella {

namespace {

constexpr std::string_view zlib_compressor = "vtkZLibDataCompressor";

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
    ArrayReader(ArrayFile& file, const VtpForm& form, const VtpArray& array) : file_(file), form_(form), array_(array) {}

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

    ArrayFile& file_;
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

NumberArray load_array(ArrayFile& file, const VtpForm& form, const VtpArray& array, std::uint64_t count, NumberType as) {
    if (array.format != VtpArray::Format::ascii) {
        return ArrayReader(file, form, array).read(count);
    }
    return read_all_words(file, array.content, count, as, array.name);
}

}  // namespace lamella
