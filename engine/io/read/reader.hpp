// What the reader of one format gets, and what it provides. all_readers in mesh_file.cpp lists the readers.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "base/clock.hpp"
#include "base/parallel.hpp"
#include "io/read/input_file.hpp"
#include "lamella/io/mesh_file.hpp"
#include "lamella/memory.hpp"

namespace lamella {

struct TextFailure;

inline std::string_view as_text(std::span<const std::byte> bytes) noexcept {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// `text` without the UTF-8 byte-order mark that it may begin with.
inline std::string_view without_byte_order_mark(std::string_view text) noexcept {
    return text.substr(text.starts_with("\xEF\xBB\xBF") ? 3 : 0);
}

/// The contents of a file that is text.
struct FileText {
    Array<std::byte> bytes;
    std::string_view whole = as_text(bytes.span());  ///< offsets in messages count from its begin
    std::string_view text = without_byte_order_mark(whole);
    Clock::time_point taken = Clock::now();  ///< where parsing begins
};

/// A file as a reader sees it: its name for messages, how it begins, and its bytes once they are asked for.
class FileSource {
public:
    /// The bytes come from `file`.
    FileSource(const InputFile& file, const ReadOptions& options, const Parallel& parallel);
    /// The bytes are `contents`, decompressed from `file`.
    FileSource(const InputFile& file, Array<std::byte> contents, const ReadOptions& options, const Parallel& parallel);

    const std::string& name() const noexcept { return file_.name(); }
    std::uint64_t size() const noexcept { return compressed_ ? contents_.size() : file_.size(); }
    bool compressed() const noexcept { return compressed_; }
    const Parallel& parallel() const noexcept { return parallel_; }
    const Memory* memory() const noexcept { return options_.control.memory; }
    std::uint64_t memory_limit() const noexcept { return memory_limit_; }

    /// Reads how the file begins; the rest of this class needs it.
    Status read_sample();
    /// The first 64 KiB, or all.
    std::string_view sample() const noexcept { return sample_; }

    /// The first `count` bytes, checked not to have changed while they were read. May be called once. Precondition: count <=
    /// size().
    Result<Array<std::byte>> take(std::size_t count);
    /// The same for all bytes.
    Result<FileText> take_text();

    /// An error that names the file, and the byte where one is given.
    Error error(ErrorCode code, const std::string& what, std::int64_t byte_offset = -1) const {
        return file_.error(code, what, byte_offset);
    }

    /// An error at byte `offset` of the whole contents `text`, byte-order mark included, that names the line too.
    Error error_in_text(std::string_view text, std::size_t offset, const std::string& what) const;
    Error error_in_text(std::string_view text, const TextFailure& failure) const;

private:
    const InputFile& file_;
    const ReadOptions& options_;
    const Parallel& parallel_;
    std::uint64_t memory_limit_;
    bool compressed_ = false;
    Array<std::byte> contents_;
    std::string sample_;
};

/// A format: how it is recognised and read.
struct Reader {
    MeshFormat format;
    std::string_view name;
    std::string_view extension;                    ///< ".abc"
    bool (*recognises)(const FileSource& source);  ///< by its size and how it begins
    /// Fills in bytes, indices, counts, stride, coordinate_type, text, parse_ms, warnings and, where the file states them,
    /// the unit and the patient frame; read_mesh() does the rest. What can expand to more than the file is counted in a
    /// MemoryBudget before it is allocated. May throw std::bad_alloc.
    Result<MeshFile> (*read)(FileSource& source);
    /// Where no reader recognises the file and its name is one of this format. Null: never.
    bool (*recognises_by_name)(const FileSource& source) = nullptr;
};

// The readers, each in its file.
bool looks_like_stl(const FileSource& source);
Result<MeshFile> read_stl(FileSource& source);
/// What slice_file() needs of a binary STL file: all that read_stl() gives but the bytes.
bool is_binary_stl(const FileSource& source);
Result<MeshFile> describe_binary_stl(const FileSource& source);
bool looks_like_obj(const FileSource& source);
bool may_be_obj(const FileSource& source);
Result<MeshFile> read_obj(FileSource& source);
bool looks_like_off(const FileSource& source);
bool looks_like_headless_off(const FileSource& source);
Result<MeshFile> read_off(FileSource& source);
bool looks_like_ply(const FileSource& source);
Result<MeshFile> read_ply(FileSource& source);
bool looks_like_vtk(const FileSource& source);
Result<MeshFile> read_vtk(FileSource& source);
bool looks_like_vtp(const FileSource& source);
Result<MeshFile> read_vtp(FileSource& source);
bool looks_like_3mf(const FileSource& source);
Result<MeshFile> read_3mf(FileSource& source);

/// The name of the format that the content has, or "".
std::string_view format_of(const FileSource& source);

/// No control characters but white space: every binary mesh has some in its first 64 KiB.
bool is_text(std::string_view sample) noexcept;

}  // namespace lamella
