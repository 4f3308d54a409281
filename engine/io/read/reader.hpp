// The interface of a format's reader: the file that it gets, and the mesh that it provides. all_readers in mesh_file.cpp
// lists the readers.
#pragma once

#include <array>

#include "base/guard.hpp"
#include "io/read/input_file.hpp"
#include "io/text/text.hpp"
#include "lamella/io/mesh_file.hpp"

namespace lamella {

inline std::string_view as_text(std::span<const std::byte> bytes) noexcept {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// `text` without the UTF-8 byte-order mark that it may begin with.
inline std::string_view without_byte_order_mark(std::string_view text) noexcept {
    return text.substr(text.starts_with("\xEF\xBB\xBF") ? 3 : 0);
}

/// A file as a reader sees it: its name for messages, how it begins, and its bytes once they are asked for.
class FileSource {
public:
    /// The bytes come from `file`, or are `contents`, decompressed from it. Throws Refused, as take() does.
    FileSource(const InputFile& file, const ReadOptions& options, const Parallel& parallel,
               std::optional<Array<std::byte>> contents = std::nullopt);

    const std::string& name() const noexcept { return file_.name(); }
    std::uint64_t size() const noexcept { return size_; }
    const Parallel& parallel() const noexcept { return parallel_; }
    const Memory* memory() const noexcept { return parallel_.memory(); }
    std::uint64_t memory_limit() const noexcept { return memory_limit_; }
    bool all_roles() const noexcept { return options_.all_roles; }
    bool scalars() const noexcept { return options_.scalars; }
    /// The caller says what the unit is of a file that states none.
    bool unit_is_given() const noexcept { return options_.mm_per_unit != 0; }

    /// The first 64 KiB, or all.
    std::string_view sample() const noexcept { return sample_; }

    /// The bytes, checked not to have changed while they were read. May be called once.
    Array<std::byte> take();
    /// All of the file of that name in the same folder. The name comes from a file: it is a path, with percent escapes, that
    /// must not lead elsewhere. Throws Refused.
    Array<std::byte> read_beside(std::string_view name) const;
    [[noreturn]] void refuse(ErrorCode code, const std::string& what, std::int64_t byte_offset = -1) const {
        throw Refused{error(code, what, byte_offset)};
    }

    /// An error that names the file, and the byte where one is given.
    Error error(ErrorCode code, const std::string& what, std::int64_t byte_offset = -1) const {
        return file_.error(code, what, byte_offset);
    }

    /// The error in the whole contents `text`, byte-order mark included: names the byte, and the line where there are any.
    Error error_in_text(std::string_view text, const TextError& error) const;

private:
    const InputFile& file_;
    const ReadOptions& options_;
    const Parallel& parallel_;
    std::uint64_t size_;
    std::uint64_t memory_limit_;
    std::optional<Array<std::byte>> contents_;
    std::string sample_;
};

/// All of a file, for the readers that need it at once.
struct FileContents {
    FileSource& source;
    Array<std::byte> bytes;
    std::string_view whole = as_text(bytes.span());  ///< errors count lines and bytes from its begin
    std::string_view text = without_byte_order_mark(whole);
};

/// A format: how it is recognised and read.
struct Reader {
    MeshFormat format;
    std::string_view name;
    std::array<std::string_view, 2> extensions;    ///< ".abc"; the second may be empty, for none
    bool (*recognises)(const FileSource& source);  ///< by its size and how it begins
    /// Fills in bytes, indices, counts, stride, vertex_type, text, warnings and, where the file states them, the unit and
    /// the patient frame; read_mesh() does the rest. What can expand to more than the file is counted before it is
    /// allocated. Throws Refused, TextError, std::bad_alloc.
    void (*parse)(FileContents& file, MeshFile& mesh);
    bool only_text = false;  ///< binary files are refused
    /// Where no reader recognises the file and its name is one of this format. Null: never.
    bool (*recognises_by_name)(const FileSource& source) = nullptr;
    /// Refuses what can be told by the file's size and how it begins, before all of it is read. Null: nothing.
    void (*check)(const FileSource& source) = nullptr;
    double mm_per_unit = 1;  ///< by the format, of files that state none
};

// The readers, each in its file.
bool looks_like_stl(const FileSource& source);
void check_stl(const FileSource& source);
void parse_stl(FileContents& file, MeshFile& mesh);
void parse_ascii_stl(FileContents& file, MeshFile& mesh);
/// For open_mesh(): all that parse_stl() gives of a binary STL file but the bytes.
bool is_binary_stl(const FileSource& source);
MeshFile describe_binary_stl(const FileSource& source);
bool looks_like_obj(const FileSource& source);
bool may_be_obj(const FileSource& source);
void parse_obj(FileContents& file, MeshFile& mesh);
bool looks_like_off(const FileSource& source);
bool looks_like_headless_off(const FileSource& source);
void parse_off(FileContents& file, MeshFile& mesh);
bool looks_like_ply(const FileSource& source);
void parse_ply(FileContents& file, MeshFile& mesh);
bool looks_like_vtk(const FileSource& source);
void parse_vtk(FileContents& file, MeshFile& mesh);
bool looks_like_vtp(const FileSource& source);
void parse_vtp(FileContents& file, MeshFile& mesh);
bool looks_like_gifti(const FileSource& source);
void parse_gifti(FileContents& file, MeshFile& mesh);
bool looks_like_freesurfer(const FileSource& source);
void parse_freesurfer(FileContents& file, MeshFile& mesh);
bool looks_like_gltf(const FileSource& source);
void parse_gltf(FileContents& file, MeshFile& mesh);
bool looks_like_3mf(const FileSource& source);
void parse_3mf(FileContents& file, MeshFile& mesh);

/// The name of the format that the content has, or "".
std::string_view format_of(const FileSource& source);

/// No control characters but white space: every binary mesh has some in its first 64 KiB.
bool is_text(std::string_view sample) noexcept;

// --- What readers share

/// A step of a reader, which takes well below a microsecond, as StopPace counts it.
inline constexpr std::size_t step_work = 32;

inline StopPace pace_of(const Parallel& parallel) noexcept {
    StopPace pace;
    pace.follow(parallel.stop());
    return pace;
}

/// Bytes that a reader may still allocate. Counted before memory is taken, so that no count in a file can take more. From
/// any thread.
class MemoryBudget {
public:
    explicit MemoryBudget(const FileSource& source) : source_(source), left_(source.memory_limit()) {}

    /// Counts `count` elements of `element_bytes` each. False: they are too many. Precondition: element_bytes > 0.
    bool try_take(std::uint64_t count, std::uint64_t element_bytes) noexcept {
        std::uint64_t left = left_.load(std::memory_order_relaxed);
        do {
            if (count > left / element_bytes) {
                return false;
            }
        } while (!left_.compare_exchange_weak(left, left - count * element_bytes, std::memory_order_relaxed));
        return true;
    }

    /// The same, or throws Refused.
    void take(std::uint64_t count, std::uint64_t element_bytes) {
        if (!try_take(count, element_bytes)) {
            source_.refuse(ErrorCode::out_of_memory, "expands to more than the " + std::to_string(source_.memory_limit()) +
                                                         " bytes that reading it may take");
        }
    }

    /// Gives back bytes that were taken and are free again.
    void give_back(std::uint64_t bytes) noexcept { left_.fetch_add(bytes, std::memory_order_relaxed); }

private:
    const FileSource& source_;
    std::atomic<std::uint64_t> left_;
};

inline constexpr std::string_view gzip_magic = "\x1F\x8B";

}  // namespace lamella
