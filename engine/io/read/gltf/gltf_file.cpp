#include "io/read/gltf/gltf_file.hpp"

#include "base/words.hpp"
#include "io/text/base64.hpp"

namespace lamella {

namespace {

// A binary file: little-endian, JSON first.
//
//     | "glTF" | version 4 | bytes of the file 4 | bytes 4 | "JSON" | ... | bytes 4 | "BIN\0" | ...
constexpr std::size_t glb_header_bytes = 12;
constexpr std::size_t chunk_header_bytes = 8;

std::size_t glb_word(std::string_view bytes, std::size_t offset) {
    return offset + 4 > bytes.size() ? 0 : load_number<std::uint32_t>(bytes.data() + offset, false);
}

}  // namespace

std::uint64_t GltfNumbers::integer(std::uint64_t index) const noexcept {
    return with_type(type, [&](auto sample) {
        return static_cast<std::uint64_t>(load_number<decltype(sample)>(first + index * stride, false));
    });
}

GltfFile::GltfFile(FileContents& file)
    : source(file.source), budget(file.source), whole_(file.whole), tree_(find_json(), budget, source.parallel()) {
    const std::string_view version = root()["asset"]["version"].text;
    if (!version.starts_with("2.")) {
        fail(root(), "expected an asset of version 2, found " + in_quotes(version));
    }
    for (const JsonNode& extension : root()["extensionsRequired"].items) {
        fail(extension, "needs the extension " + in_quotes(extension.text) + ", which is not read");
    }
}

void GltfFile::fail(const JsonNode& place, const std::string& what) const {
    throw TextError{place ? place.at : root().at, what, !is_binary_};
}

std::string_view GltfFile::find_json() {
    is_binary_ = whole_.starts_with("glTF");
    if (!is_binary_) {
        return without_byte_order_mark(whole_);
    }
    const std::size_t length = glb_word(whole_, 8);
    if (glb_word(whole_, 4) != 2 || length < glb_header_bytes || length > whole_.size()) {
        throw TextError{whole_.data() + 4,
                        "is truncated, or no binary glTF of version 2: has version " + std::to_string(glb_word(whole_, 4)) +
                            ", counts " + counted(length, "byte") + " and has " + std::to_string(whole_.size()),
                        false};
    }
    ignored_bytes_ = whole_.size() - length;
    whole_.remove_suffix(ignored_bytes_);
    const std::string_view json = chunk(glb_header_bytes, "JSON");
    const std::size_t next = glb_header_bytes + chunk_header_bytes + json.size();
    if (next < length) {
        chunk_ = chunk(next, std::string_view("BIN\0", 4));
    }
    return json;
}

std::string_view GltfFile::chunk(std::size_t at, std::string_view kind) const {
    const std::string_view rest = whole_.substr(at);
    const std::size_t bytes = glb_word(rest, 0);
    if (rest.size() < chunk_header_bytes || rest.substr(4, 4) != kind || bytes > rest.size() - chunk_header_bytes) {
        throw TextError{rest.data(),
                        "is truncated, or has no chunk " + in_quotes(kind) + " here: counts " + counted(bytes, "byte") +
                            " of " + std::to_string(rest.size()),
                        false};
    }
    return rest.substr(chunk_header_bytes, bytes);
}

std::uint64_t GltfFile::integer(const JsonNode& value, std::uint64_t otherwise) const {
    constexpr double most = 9007199254740992;  // 2^53
    const bool fits = value.kind == JsonNode::Kind::number && value.number >= 0 && value.number <= most;
    const std::uint64_t whole = fits ? static_cast<std::uint64_t>(value.number) : 0;
    if (value && (!fits || static_cast<double>(whole) != value.number)) {
        fail(value, "expected an integer from 0 on" + (value.key.empty() ? "" : " as " + in_quotes(value.key)));
    }
    return value ? whole : otherwise;
}

const JsonNode& GltfFile::item(std::string_view list, const JsonNode& index) const {
    const std::vector<JsonNode>& items = root()[list].items;
    const std::uint64_t wanted = integer(index, items.size());
    if (wanted >= items.size()) {
        fail(index, "expected an index of the " + std::to_string(items.size()) + " " + std::string(list) +
                        (index ? ", found " + std::to_string(wanted) : ""));
    }
    return items[wanted];
}

// --- Numbers

std::string_view GltfFile::buffer(const JsonNode& index) {
    const JsonNode& own = item("buffers", index);
    const auto [place, is_new] = buffers_.try_emplace(&own);
    if (is_new) {
        const std::uint64_t bytes = integer(own["byteLength"]);
        const std::string_view all = load_buffer(own, bytes);
        if (bytes > all.size()) {
            fail(own,
                 "is truncated: this buffer counts " + counted(bytes, "byte") + ", but has " + std::to_string(all.size()));
        }
        place->second = all.substr(0, bytes);
    }
    return place->second;
}

std::string_view GltfFile::load_buffer(const JsonNode& own, std::uint64_t bytes) {
    const std::string_view uri = own["uri"].text;
    if (!own["uri"] && is_binary_ && &own == root()["buffers"].items.data()) {
        return chunk_;
    }
    if (uri.starts_with("data:")) {
        const std::size_t comma = std::min(uri.find(','), uri.size() - 1);
        const std::string_view text = uri.substr(comma + 1);
        const std::uint64_t size = std::min(bytes, base64_bytes(text, source.parallel()));
        budget.take(size, 1);
        Array<std::byte>& decoded = loaded_.emplace_back(source.memory());
        decoded.resize_discarding(size);
        if (!uri.substr(0, comma).ends_with(";base64") || !decode_base64(text, decoded.span(), source.parallel())) {
            fail(own["uri"], "malformed base64");
        }
        return as_text(decoded.span());
    }
    if (uri.empty()) {
        fail(own, "expected the 'uri' of this buffer");
    }
    loaded_.push_back(source.read_beside(uri));
    budget.give_back(3 * loaded_.back().size());  // it counts as the file's own
    return as_text(loaded_.back().span());
}

GltfNumbers GltfFile::numbers(const JsonNode& index, bool points) {
    constexpr std::array types = {NumberType::int8,  NumberType::uint8,  NumberType::int16,  NumberType::uint16,
                                  NumberType::int32, NumberType::uint32, NumberType::float32};
    constexpr std::uint64_t widest = 252;
    const JsonNode& own = item("accessors", index);
    const std::uint64_t type = integer(own["componentType"]) - 5120;
    const bool is_known = points ? type == 6 : type == 1 || type == 3 || type == 5;
    GltfNumbers numbers{.accessor = &own, .count = integer(own["count"])};
    if (own["type"].text != (points ? "VEC3" : "SCALAR") || !is_known || numbers.count == 0) {
        fail(own, points ? "expected at least one VEC3 of floats" : "expected at least one SCALAR of unsigned integers");
    }
    if (own["sparse"]) {
        fail(own, "a sparse accessor, which is not read");
    }
    const JsonNode& view = item("bufferViews", own["bufferView"]);
    const std::string_view all = buffer(view["buffer"]);
    const std::uint64_t begin = integer(view["byteOffset"]);
    const std::uint64_t bytes = integer(view["byteLength"]);
    const std::uint64_t stride = integer(view["byteStride"]);
    const std::uint64_t offset = integer(own["byteOffset"]);
    if (begin > all.size() || bytes > all.size() - begin) {
        fail(view, "this view ends beyond the " + counted(all.size(), "byte") + " of its buffer");
    }
    numbers.type = types[type];
    const std::uint64_t element_bytes = size_of(numbers.type) * (points ? 3 : 1);
    numbers.stride = stride == 0 ? element_bytes : stride;  // files with 0 mean none
    if (numbers.stride < element_bytes || numbers.stride > widest || offset > bytes || element_bytes > bytes - offset ||
        numbers.count - 1 > (bytes - offset - element_bytes) / numbers.stride) {
        fail(own, counted(numbers.count, "element") + " of " + counted(element_bytes, "byte") + ", " +
                      std::to_string(numbers.stride) + " apart, are not in the " + counted(bytes, "byte") +
                      " of their view");
    }
    numbers.first = reinterpret_cast<const std::byte*>(all.data() + begin + offset);
    return numbers;
}

}  // namespace lamella
