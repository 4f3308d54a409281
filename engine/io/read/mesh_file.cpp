// read_mesh(): finds the reader for a file, decompresses it where needed, and completes what the reader returns.
#include "lamella/io/mesh_file.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <new>
#include <optional>
#include <stdexcept>

#include "base/clock.hpp"
#include "base/guard.hpp"
#include "base/words.hpp"
#include "io/read/gzip.hpp"
#include "io/read/reader.hpp"
#include "io/text/pieces.hpp"
#include "io/text/text.hpp"

namespace lamella {

namespace {

/// The reader of the file's own name is asked first, then all in this order. OBJ takes any text that begins with one of its
/// statements, so that a format which might too stands before it.
constexpr std::array all_readers = {
    Reader{MeshFormat::stl, "STL", ".stl", looks_like_stl, read_stl},
    Reader{MeshFormat::obj, "OBJ", ".obj", looks_like_obj, read_obj, may_be_obj},
    Reader{MeshFormat::off, "OFF", ".off", looks_like_off, read_off, looks_like_headless_off},
    Reader{MeshFormat::ply, "PLY", ".ply", looks_like_ply, read_ply},
    Reader{MeshFormat::vtk, "VTK", ".vtk", looks_like_vtk, read_vtk},
    Reader{MeshFormat::vtp, "VTP", ".vtp", looks_like_vtp, read_vtp},
    Reader{MeshFormat::three_mf, "3MF", ".3mf", looks_like_3mf, read_3mf},
};

/// How much of the file its format is recognised by.
constexpr std::size_t sample_bytes = std::size_t{64} << 10;

std::uint64_t memory_limit(const ReadOptions& options, std::uint64_t file_bytes) {
    constexpr std::uint64_t allowance = std::uint64_t{256} << 20;
    return options.memory_limit_bytes != 0 ? options.memory_limit_bytes : 3 * file_bytes + allowance;
}

constexpr std::string_view gz = ".gz";

/// By the name, ".gz" left out.
const Reader* reader_for_name(std::string_view path) noexcept {
    path.remove_suffix(has_extension(path, gz) ? gz.size() : 0);
    const auto* const found = std::find_if(all_readers.begin(), all_readers.end(),
                                           [path](const Reader& reader) { return has_extension(path, reader.extension); });
    return found == all_readers.end() ? nullptr : &*found;
}

std::string known_formats() {
    std::string names;
    for (const Reader& reader : all_readers) {
        names += (names.empty() ? "" : (&reader == &all_readers.back() ? " or " : ", ")) + std::string(reader.name);
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

Error unrecognised(const FileSource& source) {
    const std::string_view sample = without_byte_order_mark(source.sample());
    constexpr std::size_t quoted = 32;
    const std::string_view line = sample.substr(0, std::min(sample.find_first_of("\r\n"), quoted));
    return source.error(
        ErrorCode::malformed_mesh,
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
    const auto* const found = std::find_if(all_readers.begin(), all_readers.end(),
                                           [&](const Reader& reader) { return reader.recognises(source); });
    if (found == all_readers.end()) {
        if (by_name != nullptr && by_name->recognises_by_name != nullptr && by_name->recognises_by_name(source)) {
            return by_name;
        }
        // What is not text may be a damaged file of the format in its name, whose reader will say what is wrong.
        return is_text(source.sample()) ? nullptr : by_name;
    }
    if (by_name != nullptr) {
        warnings.push_back(source.name() + ": is a file of format " + std::string(found->name) + ", not " +
                           std::string(by_name->name) + " as its name says");
    }
    return &*found;
}

/// `path` is the one whose name speaks of the content, or empty.
Result<MeshFile> read_source(FileSource& source, const std::filesystem::path& path, const ReadOptions& options) {
    if (source.size() == 0) {
        return source.error(ErrorCode::empty_mesh, "is empty");
    }
    if (Status got = source.read_sample(); !got) {
        return got.error();
    }
    std::vector<std::string> warnings;
    const Reader* const reader = choose_reader(source, path, warnings);
    if (reader == nullptr || !reader->recognises(source)) {
        if (const std::string foreign = foreign_content(source.sample()); !foreign.empty()) {
            return source.error(ErrorCode::malformed_mesh, foreign, 0);
        }
    }
    if (reader == nullptr) {
        return unrecognised(source);
    }
    Result<MeshFile> mesh = reader->read(source);
    if (mesh) {
        mesh->format = reader->format;
        mesh->mm_per_unit = mesh->states_unit ? mesh->mm_per_unit : options.mm_per_unit;
        mesh->warnings.insert(mesh->warnings.begin(), warnings.begin(), warnings.end());
    }
    return mesh;
}

Result<MeshFile> read_compressed(FileSource& packed, const InputFile& file, const std::filesystem::path& path,
                                 const ReadOptions& options, const Parallel& parallel) {
    const Result<Array<std::byte>> bytes = packed.take(file.size());
    if (!bytes) {
        return bytes.error();
    }
    const Clock::time_point start = Clock::now();
    Unzipped unzipped = unzip(bytes.value().span(), packed.memory_limit(), options.control.memory, parallel);
    if (!unzipped.problem.empty()) {
        return file.error(unzipped.code, unzipped.problem);
    }
    if (as_text(unzipped.contents.span()).starts_with(gzip_magic)) {
        return file.error(ErrorCode::malformed_mesh, "is compressed twice: its gzip data are gzip data again");
    }
    const double unzip_ms = milliseconds_since(start);
    FileSource source(file, std::move(unzipped.contents), options, parallel);
    Result<MeshFile> mesh = read_source(source, path, options);
    if (mesh) {
        mesh->compressed = true;
        mesh->parse_ms += unzip_ms;
        if (unzipped.ignored_bytes > 0) {
            mesh->warnings.push_back(file.name() + ": ignored " + counted(unzipped.ignored_bytes, "byte") +
                                     " after the gzip data");
        }
    }
    return mesh;
}

Result<MeshFile> read(const std::filesystem::path& path, const ReadOptions& options) {
    const Clock::time_point start = Clock::now();
    const Result<InputFile> opened = InputFile::open(path, options.name);
    if (!opened) {
        return opened.error();
    }
    const InputFile& file = opened.value();
    const Parallel parallel(options.control);
    parallel.begin_stage(0.99, 3);  // formats differ in their runs: some more or fewer do no harm
    FileSource source(file, options, parallel);
    if (Status got = source.read_sample(); !got) {
        return got.error();
    }
    const std::filesystem::path named = options.name.empty() ? path : std::filesystem::path();
    Result<MeshFile> mesh = source.sample().starts_with(gzip_magic) ? read_compressed(source, file, named, options, parallel)
                                                                    : read_source(source, named, options);
    if (mesh) {
        if (options.name.empty() && mesh->compressed != has_extension(path.native(), gz)) {
            mesh->warnings.insert(mesh->warnings.begin(),
                                  file.name() + (mesh->compressed ? ": is compressed by gzip, which its name does not say"
                                                                  : ": is not compressed by gzip, as its name says"));
        }
        mesh->file_bytes = file.size();
        mesh->read_ms = milliseconds_since(start) - mesh->parse_ms;
        parallel.finish();
    }
    return mesh;
}

}  // namespace

std::string_view format_of(const FileSource& source) {
    const auto* const found = std::find_if(all_readers.begin(), all_readers.end(),
                                           [&](const Reader& reader) { return reader.recognises(source); });
    return found == all_readers.end() ? std::string_view() : found->name;
}

std::string_view name_of(MeshFormat format) noexcept {
    const auto found =
        std::find_if(all_readers.begin(), all_readers.end(), [=](const Reader& r) { return r.format == format; });
    assert(found != all_readers.end() && "each format has a row in all_readers");
    return found->name;
}

std::span<const std::string_view> format_names() noexcept {
    static constexpr auto names = [] {
        std::array<std::string_view, all_readers.size()> each{};
        std::transform(all_readers.begin(), all_readers.end(), each.begin(), [](const Reader& r) { return r.name; });
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
    return std::none_of(sample.begin(), sample.end(), [](char c) { return c >= 0 && c < ' ' && !(c >= '\t' && c <= '\r'); });
}

// --- FileSource

FileSource::FileSource(const InputFile& file, const ReadOptions& options, const Parallel& parallel)
    : file_(file),
      options_(options),
      parallel_(parallel),
      memory_limit_(lamella::memory_limit(options, file.size())),
      contents_(options.control.memory) {}

FileSource::FileSource(const InputFile& file, Array<std::byte> contents, const ReadOptions& options,
                       const Parallel& parallel)
    : file_(file),
      options_(options),
      parallel_(parallel),
      memory_limit_(lamella::memory_limit(options, contents.size())),
      compressed_(true),
      contents_(std::move(contents)) {}

Status FileSource::read_sample() {
    const std::size_t count = std::min<std::uint64_t>(size(), sample_bytes);
    if (compressed_) {
        sample_ = as_text(contents_.span().first(count));
        return {};
    }
    sample_.resize(count);
    return file_.read(std::as_writable_bytes(std::span(sample_)), parallel_);
}

Result<Array<std::byte>> FileSource::take(std::size_t count) {
    if (compressed_) {
        contents_.set_size(count);
        return std::move(contents_);
    }
    if (options_.map_file && count > 0) {
        Result<Array<std::byte>> mapped = file_.map(count);
        if (!mapped) {
            return mapped;
        }
        if (Status same = file_.unchanged(); !same) {
            return same.error();
        }
        return mapped;
    }
    Array<std::byte> bytes(options_.control.memory);
    bytes.resize_discarding(count);
    if (Status got = file_.read(bytes.span(), parallel_); !got) {
        return got.error();
    }
    if (Status same = file_.unchanged(); !same) {
        return same.error();
    }
    return bytes;
}

Result<FileText> FileSource::take_text() {
    Result<Array<std::byte>> bytes = take(size());
    if (!bytes) {
        return bytes.error();
    }
    return FileText{std::move(bytes).value()};
}

Error FileSource::error_in_text(std::string_view text, std::size_t offset, const std::string& what) const {
    return error(ErrorCode::malformed_mesh,
                 "line " + std::to_string(line_of(text, offset)) + ", byte " + std::to_string(offset) + ": " + what,
                 static_cast<std::int64_t>(offset));
}

Error FileSource::error_in_text(std::string_view text, const TextFailure& failure) const {
    return error_in_text(text, static_cast<std::size_t>(failure.at - text.data()), failure.what);
}

// ---

Result<MeshFile> read_mesh(const std::filesystem::path& path, const ReadOptions& options) noexcept {
    return guarded(options.control, [&] { return read(path, options); });
}

// --- The calls on a mesh, for a mesh that was read: its unit is applied first

namespace {

template <class Options>
Options in_mm(const MeshFile& file, Options options) {
    options.transform = options.transform * file.to_mm();
    return options;
}

}  // namespace

Result<SliceResult> slice(const MeshFile& file, const SliceOptions& options) noexcept {
    return guarded([&] { return slice(file.view(), in_mm(file, options)); });
}

Status slice(const MeshFile& file, const SliceOptions& options, Workspace& workspace, SliceResult& result) noexcept {
    return guarded([&] { return slice(file.view(), in_mm(file, options), workspace, result); });
}

Result<MeshInfo> inspect(const MeshFile& file, const InspectOptions& options) noexcept {
    return inspect(file.view(), in_mm(file, options));
}

Result<MeshCheck> check(const MeshFile& file, const CheckOptions& options) noexcept {
    return check(file.view(), in_mm(file, options));
}

Result<WeldedMesh> weld(const MeshFile& file, const WeldOptions& options) noexcept {
    WeldOptions in_unit = options;
    in_unit.mm_per_unit = file.mm_per_unit;
    return weld(file.view(), in_unit);
}

}  // namespace lamella
