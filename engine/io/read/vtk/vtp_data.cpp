#include "io/read/vtk/vtp_data.hpp"

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
#include "io/read/vtk/number_words.hpp"
#include "io/text/text.hpp"

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

/// Reads the bytes of one array.
class ArrayReader {
public:
    ArrayReader(VtkFile& file, const VtpForm& form, const VtpArray& array, ByteStream stream)
        : file_(file), form_(form), array_(array), stream_(stream) {}

    /// Its `count` numbers, which lie where they are or in `storage`.
    Result<NumberArray> read(std::uint64_t count, Array<std::byte>& storage);

    Error error(const std::string& what) const {
        return file_.error_at(file_.text.data() + array_.element, std::string(array_.name) + " " + what);
    }

private:
    Result<const std::byte*> read_plain(std::uint64_t total, Array<std::byte>& storage);
    Result<const std::byte*> read_compressed(std::uint64_t total, Array<std::byte>& storage);
    bool inflate_narrow(const Blocks& blocks, const std::byte* packed, Array<std::byte>& storage);
    int inflate_block(const Blocks& blocks, std::size_t block, const std::byte* packed, std::byte* out) const;
    Status read_header(std::span<std::uint64_t> numbers);
    Status read_blocks(Blocks& blocks);
    Status read_stored(std::uint64_t count, Array<std::byte>& storage);
    Status inflate(const Blocks& blocks, const std::byte* packed, Array<std::byte>& storage) const;

    Error ended() const { return error("is truncated, or malformed base64"); }

    VtkFile& file_;
    const VtpForm& form_;
    const VtpArray& array_;
    ByteStream stream_;
    bool narrow_ = false;  // its integers of 64 bits became such of 32
};

Result<NumberArray> ArrayReader::read(std::uint64_t count, Array<std::byte>& storage) {
    const std::uint64_t total = count * bytes_of(array_.type);
    const Result<const std::byte*> bytes =
        form_.compressor.empty() ? read_plain(total, storage) : read_compressed(total, storage);
    if (!bytes) {
        return bytes.error();
    }
    if (narrow_) {
        return NumberArray{bytes.value(), count, NumberType::uint32, false, {NumberPlace::Form::encoded, array_.element}};
    }
    NumberArray numbers{bytes.value(), count, array_.type, form_.big_endian, {NumberPlace::Form::encoded, array_.element}};
    if (storage.empty()) {
        numbers.place = {NumberPlace::Form::bytes, file_.offset_of(reinterpret_cast<const char*>(bytes.value()))};
    }
    return numbers;
}

Status ArrayReader::read_header(std::span<std::uint64_t> numbers) {
    std::array<std::byte, 8> bytes{};
    Lookout lookout(file_.source.parallel());
    for (std::uint64_t& number : numbers) {
        lookout.pass();
        if (!stream_.read(std::span(bytes).first(form_.header_bytes))) {
            return ended();
        }
        const NumberType type = form_.header_bytes == 4 ? NumberType::uint32 : NumberType::uint64;
        decode_integers({bytes.data(), 1, type, form_.big_endian, {}}, 0, 1, &number);
    }
    return {};
}

/// Copies the next `count` bytes, once they are known to be there.
Status ArrayReader::read_stored(std::uint64_t count, Array<std::byte>& storage) {
    if (count > stream_.most_left()) {
        return ended();
    }
    if (Status room = file_.budget.take(count, 1); !room) {
        return room;
    }
    storage.resize_discarding(count);
    constexpr std::size_t piece_bytes = std::size_t{1} << 20;
    for (std::span<std::byte> rest = storage.span(); !rest.empty();) {
        file_.source.parallel().stop_if_asked();
        const std::size_t bytes = std::min(piece_bytes, rest.size());
        if (!stream_.read(rest.first(bytes))) {
            return ended();
        }
        rest = rest.subspan(bytes);
    }
    return {};
}

Result<const std::byte*> ArrayReader::read_plain(std::uint64_t total, Array<std::byte>& storage) {
    std::uint64_t counted = 0;
    if (Status read = read_header({&counted, 1}); !read) {
        return read.error();
    }
    if (counted != total) {
        return error("should have " + std::to_string(total) + " bytes, but counts " + std::to_string(counted));
    }
    if (stream_.is_raw()) {
        return total <= stream_.most_left() ? Result<const std::byte*>(stream_.take(total).data()) : ended();
    }
    if (Status read = read_stored(total, storage); !read) {
        return read.error();
    }
    return storage.data();
}

Status ArrayReader::read_blocks(Blocks& blocks) {
    std::array<std::uint64_t, 3> counts{};
    if (Status read = read_header(counts); !read) {
        return read;
    }
    if (counts[0] > stream_.most_left() / form_.header_bytes) {
        return error("is truncated: counts " + std::to_string(counts[0]) + " compressed blocks");
    }
    if (Status room = file_.budget.take(counts[0], sizeof(std::uint64_t) + sizeof(int)); !room) {
        return room;
    }
    blocks.bytes = counts[1];
    blocks.last_bytes = counts[2] == 0 ? counts[1] : counts[2];
    blocks.ends.resize(counts[0]);
    if (Status read = read_header(blocks.ends); !read) {
        return read;
    }
    std::uint64_t end = 0;
    for (std::uint64_t& block : blocks.ends) {
        if (block > stream_.most_left() - end) {
            return error("is truncated within its compressed blocks");
        }
        end += block;
        block = end;
    }
    return {};
}

Result<const std::byte*> ArrayReader::read_compressed(std::uint64_t total, Array<std::byte>& storage) {
    if (form_.compressor != zlib_compressor) {
        return error("is compressed by '" + printable(form_.compressor) + "', which is not read: only " +
                     std::string(zlib_compressor) + " is");
    }
    Blocks blocks;
    if (Status read = read_blocks(blocks); !read) {
        return read.error();
    }
    if (!blocks.hold(total) || total / most_expansion > blocks.ends.back()) {
        return error("should have " + std::to_string(total) + " bytes, which its compressed blocks do not hold");
    }
    const std::uint64_t packed_bytes = blocks.ends.back();
    Array<std::byte> packed(file_.source.memory());
    if (!stream_.is_raw()) {
        if (Status read = read_stored(packed_bytes, packed); !read) {
            return read.error();
        }
    }
    const std::byte* const from = stream_.is_raw() ? stream_.take(packed_bytes).data() : packed.data();
    narrow_ = inflate_narrow(blocks, from, storage);
    if (!narrow_) {
        if (Status room = file_.budget.take(total, 1); !room) {
            return room.error();
        }
        storage.resize_discarding(total);
        if (Status done = inflate(blocks, from, storage); !done) {
            return done.error();
        }
    }
    file_.budget.give_back(packed.size());
    return storage.data();
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
bool ArrayReader::inflate_narrow(const Blocks& blocks, const std::byte* packed, Array<std::byte>& storage) {
    constexpr std::uint64_t wide = sizeof(std::uint64_t);
    constexpr std::uint64_t most_bytes = std::uint64_t{1} << 20;  // of a block, which each thread holds one of
    const std::uint64_t count = ((blocks.ends.size() - 1) * blocks.bytes + blocks.last_bytes) / wide;
    if (!is_integer(array_.type) || bytes_of(array_.type) != wide || blocks.bytes % wide != 0 ||
        blocks.last_bytes % wide != 0 || std::max(blocks.bytes, blocks.last_bytes) > most_bytes ||
        !file_.budget.take(count, sizeof(std::uint32_t))) {
        return false;
    }
    storage.resize_discarding(count * sizeof(std::uint32_t));
    auto* const out = reinterpret_cast<std::uint32_t*>(storage.data());
    const Parallel& parallel = file_.source.parallel();
    std::vector<std::vector<std::byte>> rooms(static_cast<std::size_t>(parallel.threads()));
    std::atomic<bool> good{true};
    parallel.run(blocks.ends.size(), [&](std::size_t i, int worker) {
        std::vector<std::byte>& room = rooms[static_cast<std::size_t>(worker)];
        room.resize(std::max(blocks.bytes, blocks.last_bytes));
        const std::uint64_t numbers = (i + 1 == blocks.ends.size() ? blocks.last_bytes : blocks.bytes) / wide;
        const NumberArray block{room.data(), numbers, array_.type, form_.big_endian, {}};
        if (!good.load(std::memory_order_relaxed) || inflate_block(blocks, i, packed, room.data()) != Z_OK ||
            decode_indices(block, 0, numbers, out + i * blocks.bytes / wide) > std::numeric_limits<std::uint32_t>::max()) {
            good.store(false, std::memory_order_relaxed);
        }
    });
    if (!good) {
        storage = Array<std::byte>(file_.source.memory());
        file_.budget.give_back(count * sizeof(std::uint32_t));
    }
    return good;
}

Status ArrayReader::inflate(const Blocks& blocks, const std::byte* packed, Array<std::byte>& storage) const {
    std::vector<int> answers(blocks.ends.size(), Z_OK);
    file_.source.parallel().run(blocks.ends.size(), [&](std::size_t i, int) {
        answers[i] = inflate_block(blocks, i, packed, storage.data() + i * blocks.bytes);
    });
    const auto failed = std::find_if(answers.begin(), answers.end(), [](int answer) { return answer != Z_OK; });
    if (failed == answers.end()) {
        return {};
    }
    if (*failed == Z_MEM_ERROR) {
        throw std::bad_alloc();
    }
    return error("is damaged: its compressed block " + std::to_string(failed - answers.begin()) +
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

template <class Value>
Result<NumberArray> VtpData::load(const VtpArray& array, std::uint64_t count) {
    storage_.emplace_back(file_.source.memory());
    return array.format == VtpArray::Format::ascii ? load_decimals<Value>(array, count) : load_bytes(array, count);
}

template Result<NumberArray> VtpData::load<float>(const VtpArray&, std::uint64_t);
template Result<NumberArray> VtpData::load<double>(const VtpArray&, std::uint64_t);
template Result<NumberArray> VtpData::load<std::uint32_t>(const VtpArray&, std::uint64_t);
template Result<NumberArray> VtpData::load<std::uint64_t>(const VtpArray&, std::uint64_t);

template <class Value>
Result<NumberArray> VtpData::load_decimals(const VtpArray& array, std::uint64_t count) {
    const char* p = array.content.data();
    const char* const end = p + array.content.size();
    Result<NumberArray> numbers = read_text_array<Value>(file_, p, end, count, array.name, storage_.back());
    p = skip_space(p, end);
    if (numbers && p != end) {
        return file_.error_at(p, "expected the end of the " + std::to_string(count) + " numbers of " +
                                     std::string(array.name) + ", found " + word_at(p, end));
    }
    return numbers;
}

Result<NumberArray> VtpData::load_bytes(const VtpArray& array, std::uint64_t count) {
    ArrayReader reader(file_, form_, array, stream_of(form_, array));
    if (count > std::numeric_limits<std::uint64_t>::max() / sizeof(double)) {
        return reader.error("should have " + std::to_string(count) + " numbers, which no file has");
    }
    return reader.read(count, storage_.back());
}

}  // namespace lamella
