// read_mesh(): finds the reader for a file, decompresses it where needed, and completes what the reader returns.
#include "lamella/io/mesh_file.hpp"

#include <array>

#include "base/clock.hpp"
#include "base/words.hpp"
#include "io/read/chunk_list.hpp"
#include "io/read/inflater.hpp"
#include "io/read/reader.hpp"

namespace lamella {

namespace {

/// The reader of the file's own name is asked first, then all in this order. OBJ takes any text that begins with one of its
/// statements, so that a format which might too stands before it; STL most binary files, whatever they begin with.
constexpr std::array all_readers = {
    Reader{MeshFormat::freesurfer, "FreeSurfer", {".pial", ".white"}, looks_like_freesurfer, parse_freesurfer},
    Reader{MeshFormat::gltf, "glTF", {".glb", ".gltf"}, looks_like_gltf, parse_gltf},
    Reader{MeshFormat::stl, "STL", {".stl"}, looks_like_stl, parse_stl, false, nullptr, check_stl},
    Reader{MeshFormat::obj, "OBJ", {".obj"}, looks_like_obj, parse_obj, true, may_be_obj},
    Reader{MeshFormat::off, "OFF", {".off"}, looks_like_off, parse_off, true, looks_like_headless_off},
    Reader{MeshFormat::ply, "PLY", {".ply"}, looks_like_ply, parse_ply},
    Reader{MeshFormat::vtk, "VTK", {".vtk"}, looks_like_vtk, parse_vtk},
    Reader{MeshFormat::vtp, "VTP", {".vtp"}, looks_like_vtp, parse_vtp},
    Reader{MeshFormat::gifti, "GIfTI", {".gii"}, looks_like_gifti, parse_gifti},
    Reader{MeshFormat::three_mf, "3MF", {".3mf"}, looks_like_3mf, parse_3mf},
};

/// How much of the file its format is recognised by.
constexpr std::size_t sample_bytes = std::size_t{64} << 10;

std::uint64_t memory_limit(const ReadOptions& options, std::uint64_t file_bytes) {
    constexpr std::uint64_t allowance = std::uint64_t{256} << 20;
    return options.memory_limit_bytes != 0 ? options.memory_limit_bytes : 3 * file_bytes + allowance;
}

constexpr std::string_view gz = ".gz";

/// The first that passes; null where none does.
template <class Passes>
const Reader* first_reader(Passes passes) {
    const auto* const found = std::find_if(all_readers.begin(), all_readers.end(), passes);
    return found == all_readers.end() ? nullptr : found;
}

/// By the name, ".gz" left out.
const Reader* reader_for_name(PathView path) noexcept {
    path.remove_suffix(has_extension(path, gz) ? gz.size() : 0);
    return first_reader([path](const Reader& reader) {
        return std::any_of(reader.extensions.begin(), reader.extensions.end(), [path](std::string_view extension) {
            return !extension.empty() && has_extension(path, extension);
        });
    });
}

const Reader* reader_for_content(const FileSource& source) {
    return first_reader([&](const Reader& reader) { return reader.recognises(source); });
}

std::string known_formats() {
    std::string names;
    for (const std::string_view& name : format_names()) {
        names += (names.empty() ? "" : (&name == &format_names().back() ? " or " : ", ")) + std::string(name);
    }
    return names;
}

bool is_html(std::string_view text) {
    text.remove_prefix(static_cast<std::size_t>(skip_space(text.begin(), text.end()) - text.begin()));
    return begins_in_any_case(text, "<!doctype html") || begins_in_any_case(text, "<html");
}

/// Names a file that begins so for what it is, where it can be no mesh: "is text in UTF-16; ...". Else empty.
std::string foreign_content(std::string_view sample) {
    if (sample.starts_with("\xFF\xFE") || sample.starts_with("\xFE\xFF")) {
        return "is text in UTF-16; only ASCII and UTF-8 are read";
    }
    if (sample.starts_with("version https://git-lfs.github.com/spec/")) {
        return "is a Git LFS pointer in place of the mesh, which 'git lfs pull' fetches";
    }
    if (is_html(without_byte_order_mark(sample))) {
        return "is an HTML page, as a failed download leaves it";
    }
    return {};
}

[[noreturn]] void refuse_unrecognised(const FileSource& source) {
    const std::string_view sample = without_byte_order_mark(source.sample());
    constexpr std::size_t quoted = 32;
    const std::string_view line = sample.substr(0, std::min(sample.find_first_of("\r\n"), quoted));
    source.refuse(ErrorCode::malformed_mesh,
                  "is no " + known_formats() + " file: " +
                      (is_text(source.sample()) ? "text that begins with '" + printable(line) + "'" : "unknown binary data"),
                  0);
}

/// The reader that recognises the content, else the one for the file's extension. Warns where the two differ.
const Reader* choose_reader(const FileSource& source, const std::filesystem::path& path,
                            std::vector<std::string>& warnings) {
    const Reader* const by_name = reader_for_name(path.native());
    // The extension's reader is asked first: it decides where the beginning fits several formats.
    if (by_name != nullptr && by_name->recognises(source)) {
        return by_name;
    }
    const Reader* const found = reader_for_content(source);
    if (found == nullptr) {
        if (by_name != nullptr && by_name->recognises_by_name != nullptr && by_name->recognises_by_name(source)) {
            return by_name;
        }
        // A file that is not text may be a damaged file of the format in its name, whose reader will say what is wrong.
        return is_text(source.sample()) ? nullptr : by_name;
    }
    if (by_name != nullptr) {
        warnings.push_back(source.name() + ": is a file of format " + std::string(found->name) + ", not " +
                           std::string(by_name->name) + " as its name says");
    }
    return found;
}

MeshFile parse(FileSource& source, const Reader& reader) {
    if (reader.only_text && !is_text(source.sample())) {
        const std::string name(reader.name);
        source.refuse(ErrorCode::malformed_mesh, "is no " + name + " file as text; no other " + name + " is read", 0);
    }
    if (reader.check != nullptr) {
        reader.check(source);
    }
    FileContents file{source, source.take()};
    source.parallel().begin_stage(0.99, 2);  // formats differ in their runs: some more or fewer do no harm
    const Clock::time_point start = Clock::now();
    MeshFile mesh;  // may take the file's bytes, in which errors count lines
    try {
        reader.parse(file, mesh);
    } catch (const TextError& error) {
        throw Refused{source.error_in_text(file.whole, error)};
    }
    mesh.parse_ms = milliseconds_since(start);
    return mesh;
}

/// `path` is the one whose name speaks of the content, or empty.
MeshFile read_source(FileSource& source, const std::filesystem::path& path, const ReadOptions& options) {
    if (source.size() == 0) {
        source.refuse(ErrorCode::empty_mesh, "is empty");
    }
    std::vector<std::string> warnings;
    const Reader* const reader = choose_reader(source, path, warnings);
    if (reader == nullptr || !reader->recognises(source)) {
        if (const std::string foreign = foreign_content(source.sample()); !foreign.empty()) {
            source.refuse(ErrorCode::malformed_mesh, foreign, 0);
        }
    }
    if (reader == nullptr) {
        refuse_unrecognised(source);
    }
    MeshFile mesh = parse(source, *reader);
    mesh.format = reader->format;
    mesh.mm_per_unit = mesh.states_unit ? mesh.mm_per_unit : options.mm_per_unit != 0 ? options.mm_per_unit : 1;
    mesh.warnings.insert(mesh.warnings.begin(), warnings.begin(), warnings.end());
    std::vector<std::string> names;
    for (const VertexScalars& scalars : mesh.scalars) {
        names.push_back(scalars.name);
    }
    names = distinct_names(names);
    for (std::size_t i = 0; i < names.size(); ++i) {
        mesh.scalars[i].name = std::move(names[i]);
    }
    return mesh;
}

constexpr std::size_t chunk_bytes = std::size_t{4} << 20;
constexpr int gzip_window = 16 + MAX_WBITS;  // 16: the format is gzip, not zlib

/// All members of the gzip file whose bytes these are, one after the other, and how many bytes after the last are none.
/// Memory: the contents, once, and a few megabytes; nothing is allocated by what the file says of its size. Throws Refused,
/// also of what expands beyond the source's memory limit, and std::bad_alloc.
Array<std::byte> unzip(const FileSource& source, std::span<const std::byte> bytes, std::uint64_t& ignored_bytes) {
    const Parallel& parallel = source.parallel();
    Inflater inflater(gzip_window);
    ChunkList<std::byte, chunk_bytes, chunk_bytes> chunks(source.memory());  // the size is known only at the end
    for (;;) {
        parallel.stop_if_asked();
        std::span<std::byte> room = chunks.room();
        const std::size_t before = room.size();
        const int answer = inflater.step(bytes, room);
        chunks.add(before - room.size());
        MemoryBudget(source).take(chunks.size(), 1);
        if (answer == Z_STREAM_END && (!as_text(bytes).starts_with(gzip_magic) || inflateReset(&inflater.stream) != Z_OK)) {
            break;  // the last member
        }
        if (answer == Z_BUF_ERROR && bytes.empty()) {
            source.refuse(ErrorCode::malformed_mesh, "is truncated: its gzip data end too early");
        }
        if (answer != Z_OK && answer != Z_STREAM_END && answer != Z_BUF_ERROR) {
            source.refuse(ErrorCode::malformed_mesh,
                          "is damaged: no valid gzip data" +
                              (inflater.stream.msg != nullptr ? std::string(": ") + inflater.stream.msg : ""));
        }
    }
    ignored_bytes = bytes.size();
    return chunks.joined([&parallel] { parallel.stop_if_asked(); });
}

MeshFile read_compressed(FileSource& packed, const InputFile& file, const std::filesystem::path& path,
                         const ReadOptions& options) {
    const Array<std::byte> bytes = packed.take();
    const Clock::time_point start = Clock::now();
    std::uint64_t ignored_bytes = 0;
    Array<std::byte> contents = unzip(packed, bytes.span(), ignored_bytes);
    if (as_text(contents.span()).starts_with(gzip_magic)) {
        packed.refuse(ErrorCode::malformed_mesh, "is compressed twice: its gzip data are gzip data again");
    }
    const double unzip_ms = milliseconds_since(start);
    FileSource source(file, options, packed.parallel(), std::move(contents));
    MeshFile mesh = read_source(source, path, options);
    mesh.compressed = true;
    mesh.parse_ms += unzip_ms;
    if (ignored_bytes > 0) {
        mesh.warnings.push_back(file.name() + ": ignored " + counted(ignored_bytes, "byte") + " after the gzip data");
    }
    return mesh;
}

MeshFile read(const std::filesystem::path& path, const ReadOptions& options, const Context& context) {
    const Clock::time_point start = Clock::now();
    const InputFile file = require(InputFile::open(path, options.name));
    const Parallel parallel(context);
    parallel.begin_stage(0.6);
    FileSource source(file, options, parallel);
    const std::filesystem::path named = options.name.empty() ? path : std::filesystem::path();
    MeshFile mesh = source.sample().starts_with(gzip_magic) ? read_compressed(source, file, named, options)
                                                            : read_source(source, named, options);
    if (options.name.empty() && mesh.compressed != has_extension(path.native(), gz)) {
        mesh.warnings.insert(mesh.warnings.begin(),
                             file.name() + (mesh.compressed ? ": is compressed by gzip, which its name does not say"
                                                            : ": is not compressed by gzip, as its name says"));
    }
    mesh.file_bytes = file.size();
    mesh.read_ms = milliseconds_since(start) - mesh.parse_ms;
    parallel.finish();
    return mesh;
}

}  // namespace

std::string_view format_of(const FileSource& source) {
    const Reader* const found = reader_for_content(source);
    return found == nullptr ? std::string_view() : found->name;
}

std::string_view name_of(MeshFormat format) noexcept {
    return format_names()[static_cast<std::size_t>(format)];
}

std::span<const std::string_view> format_names() noexcept {
    static constexpr auto names = [] {
        std::array<std::string_view, all_readers.size()> each{};
        for (const Reader& reader : all_readers) {
            each[static_cast<std::size_t>(reader.format)] = reader.name;
        }
        return each;
    }();
    return names;
}

bool is_named_as_mesh(const std::filesystem::path& path) noexcept {
    return reader_for_name(path.native()) != nullptr;
}

std::string_view name_of(PatientFrame frame) noexcept {
    constexpr std::array<std::string_view, 3> names = {"", "LPS", "RAS"};
    return names[static_cast<std::size_t>(frame)];
}

bool is_text(std::string_view sample) noexcept {
    return std::none_of(sample.begin(), sample.end(), [](unsigned char c) { return c < ' ' && !(c >= '\t' && c <= '\r'); });
}

// --- FileSource

FileSource::FileSource(const InputFile& file, const ReadOptions& options, const Parallel& parallel,
                       std::optional<Array<std::byte>> contents)
    : file_(file),
      options_(options),
      parallel_(parallel),
      size_(contents ? contents->size() : file.size()),
      memory_limit_(lamella::memory_limit(options, size_)),
      contents_(std::move(contents)),
      sample_(std::min<std::uint64_t>(size_, sample_bytes), '\0') {
    if (contents_) {
        sample_ = as_text(contents_->span().first(sample_.size()));
    } else {
        require(file_.read_at(0, std::as_writable_bytes(std::span(sample_))));
    }
}

Array<std::byte> FileSource::take() {
    if (contents_) {
        return *std::move(contents_);
    }
    Array<std::byte> bytes(memory());
    const bool maps = File::can_map && options_.map_file && size() > 0;
    if constexpr (File::can_map) {
        if (maps) {
            bytes = require(file_.map(size()));
        }
    }
    if (!maps) {
        bytes.resize_discarding(size());
        require(file_.read(bytes.span(), parallel_));
    }
    require(file_.unchanged());
    return bytes;
}

Array<std::byte> FileSource::read_beside(std::string_view name) const {
    const std::string plain = without_escapes(name);
    const std::optional<std::string> path = path_within(plain);
    if (!path || plain.starts_with('/') || plain.find('\0') != std::string::npos) {
        refuse(ErrorCode::malformed_mesh, "needs " + in_quotes(name) + ", which is no file beside it");
    }
    if (!options_.name.empty()) {
        refuse(ErrorCode::unreadable_file, "needs " + in_quotes(name) + ", a file beside it, and has no folder");
    }
    Array<std::byte> bytes(memory());
    const Result<InputFile> file = InputFile::open(file_.folder() / path_of(*path), *path);
    Status status = file ? Status() : Status(file.error());
    if (file) {
        bytes.resize_discarding(file->size());
        status = file->read(bytes.span(), parallel_);
        status = status ? file->unchanged() : status;
    }
    if (!status) {
        refuse(status.error().code, "needs " + status.error().message);
    }
    return bytes;
}

Error FileSource::error_in_text(std::string_view text, const TextError& error) const {
    const auto offset = static_cast<std::size_t>(error.at - text.data());
    const std::string line = error.has_lines ? "line " + std::to_string(line_of(text, offset)) + ", " : "";
    return this->error(ErrorCode::malformed_mesh, line + "byte " + std::to_string(offset) + ": " + error.what,
                       static_cast<std::int64_t>(offset));
}

Result<MeshFile> read_mesh(const std::filesystem::path& path, const ReadOptions& options, const Context& context) noexcept {
    return guarded(context, [&]() -> Result<MeshFile> { return read(path, options, context); });
}

}  // namespace lamella
