#include "io/read/vtk/vtp_document.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <limits>
#include <new>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "io/read/lookout.hpp"
#include "io/read/vtk/base64.hpp"

namespace lamella {

namespace {

constexpr std::string_view zlib_compressor = "vtkZLibDataCompressor";

/// zlib compresses by a factor of 1032 at most.
constexpr std::uint64_t most_expansion = 1032;

/// Bytes that are read from front to back: raw, or from base64.
class ByteStream {
public:
    explicit ByteStream(std::span<const std::byte> bytes) : raw_(bytes) {}
    explicit ByteStream(Base64Reader text) : base64_(text) {}

    bool is_raw() const noexcept { return !base64_; }

    /// Not fewer bytes than are left.
    std::uint64_t most_left() const noexcept { return base64_ ? base64_->most_left() : raw_.size(); }

    /// Fills `out`. False: the bytes end before, or are no base64.
    bool read(std::span<std::byte> out) noexcept {
        if (base64_) {
            return base64_->read(out);
        }
        if (raw_.size() < out.size()) {
            return false;
        }
        const std::span<const std::byte> bytes = take(out.size());
        std::copy(bytes.begin(), bytes.end(), out.begin());
        return true;
    }

    /// The next bytes where they lie. Precondition: is_raw(), and they are there.
    std::span<const std::byte> take(std::uint64_t count) noexcept {
        const std::span<const std::byte> bytes = raw_.first(count);
        raw_ = raw_.subspan(count);
        return bytes;
    }

private:
    std::span<const std::byte> raw_;
    std::optional<Base64Reader> base64_;
};

/// Data that are compressed in blocks.
struct Blocks {
    std::uint64_t bytes = 0;  ///< of each but the last
    std::uint64_t last_bytes = 0;
    std::vector<std::uint64_t> ends;  ///< of each, in the compressed data

    /// Whether they expand to `total` bytes, more than none.
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
    NumberArray read(std::uint64_t count);

private:
    const std::byte* read_plain(std::uint64_t total);
    const std::byte* read_compressed(std::uint64_t total);
    bool inflate_narrow(const Blocks& blocks, const std::byte* packed);
    void inflate(const Blocks& blocks, const std::byte* packed);
    int inflate_block(const Blocks& blocks, std::size_t block, const std::byte* packed, std::byte* out) const;
    void read_header(std::span<std::uint64_t> numbers);
    Blocks read_blocks();
    Array<std::byte> read_stored(std::uint64_t count);

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

NumberArray ArrayReader::read(std::uint64_t count) {
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

void ArrayReader::read_header(std::span<std::uint64_t> numbers) {
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

/// Copies the next `count` bytes, once they are known to be there.
Array<std::byte> ArrayReader::read_stored(std::uint64_t count) {
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

const std::byte* ArrayReader::read_plain(std::uint64_t total) {
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
    return stream_.take(total).data();
}

Blocks ArrayReader::read_blocks() {
    std::array<std::uint64_t, 3> counts{};
    read_header(counts);
    if (counts[0] > stream_.most_left() / form_.header_bytes) {
        fail("is truncated: counts " + std::to_string(counts[0]) + " compressed blocks");
    }
    file_.budget.take(counts[0], sizeof(std::uint64_t) + sizeof(int));
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

const std::byte* ArrayReader::read_compressed(std::uint64_t total) {
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
    const std::byte* const from = stream_.is_raw() ? stream_.take(packed_bytes).data() : packed.data();
    narrow_ = inflate_narrow(blocks, from);
    if (!narrow_) {
        file_.budget.take(total, 1);
        storage_.resize_discarding(total);
        inflate(blocks, from);
    }
    file_.budget.give_back(packed.size());
    return storage_.data();
}

int ArrayReader::inflate_block(const Blocks& blocks, std::size_t block, const std::byte* packed, std::byte* out) const {
    const std::uint64_t begin = block == 0 ? 0 : blocks.ends[block - 1];
    const std::uint64_t wanted = block + 1 == blocks.ends.size() ? blocks.last_bytes : blocks.bytes;
    uLongf got = wanted;
    const int answer = uncompress(reinterpret_cast<Bytef*>(out), &got, reinterpret_cast<const Bytef*>(packed + begin),
                                  blocks.ends[block] - begin);
    return answer == Z_OK && got != wanted ? Z_DATA_ERROR : answer;
}

/// Holds integers of 64 bits in 32 if all fit, as they nearly always do: they compress so well that they would exceed the
/// memory limit of a small file. False: they do not fit or are damaged, and nothing is held.
bool ArrayReader::inflate_narrow(const Blocks& blocks, const std::byte* packed) {
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
            decode_indices(block, 0, numbers, out + i * blocks.bytes / wide) > std::numeric_limits<std::uint32_t>::max()) {
            good.store(false, std::memory_order_relaxed);
        }
    });
    if (!good) {
        storage_ = Array<std::byte>(file_.source.memory());
        file_.budget.give_back(count * sizeof(std::uint32_t));
    }
    return good;
}

void ArrayReader::inflate(const Blocks& blocks, const std::byte* packed) {
    std::vector<int> answers(blocks.ends.size(), Z_OK);
    file_.source.parallel().run(blocks.ends.size(), [&](std::size_t i, int) {
        answers[i] = inflate_block(blocks, i, packed, storage_.data() + i * blocks.bytes);
    });
    const auto failed = std::find_if(answers.begin(), answers.end(), [](int answer) { return answer != Z_OK; });
    if (failed == answers.end()) {
        return;
    }
    if (*failed == Z_MEM_ERROR) {
        throw std::bad_alloc();
    }
    fail("is damaged: its compressed block " + std::to_string(failed - answers.begin()) +
         " does not expand to what is counted");
}

std::span<const std::byte> as_bytes(std::string_view text) {
    return {reinterpret_cast<const std::byte*>(text.data()), text.size()};
}

ByteStream stream_of(const VtpForm& form, const VtpArray& array) {
    if (array.format == VtpArray::Format::binary) {
        return ByteStream(Base64Reader(array.content));
    }
    const std::string_view text = form.appended.substr(std::min<std::uint64_t>(array.appended_offset, form.appended.size()));
    return form.appended_as_base64 ? ByteStream(Base64Reader(text)) : ByteStream(as_bytes(text));
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
