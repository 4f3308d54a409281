#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <utility>

#include <unistd.h>
#include <zlib.h>

#include "base/guard.hpp"
#include "base/words.hpp"
#include "io/write/output_file.hpp"
#include "lamella/medical/archive.hpp"
#include "medical/geometry/headers.hpp"
#include "medical/hdf5/archive_file.hpp"

namespace lamella {

namespace {

constexpr std::size_t longest_name = 4096;

void require_possible(const SliceResult& result, const ArchiveInfo& info, const std::filesystem::path& path) {
    const auto require = [&](bool holds, const std::string& why) {
        if (!holds) {
            refuse_output(path, why);
        }
    };
    const SliceInfo& slice = result.info;
    require(slice.first_layer <= slice.planned_layers && result.layers.size() <= slice.planned_layers - slice.first_layer,
            "a result of " + counted(result.layers.size(), "layer") + " from layer " + std::to_string(slice.first_layer) +
                " on, of " + std::to_string(slice.planned_layers) + " in all");
    require(info.name.size() <= longest_name && info.mesh_sha256.size() <= longest_name,
            "an archive's name of the mesh has at most " + std::to_string(longest_name) + " bytes");
    require(slice.layer_of.size() == rows_of(result)[height_rows], "the result does not tell the layers of its planes");
    require(!info.geometry || info.geometry->uneven_slices_mm.size() <= most_uneven_slices,
            "an image of more than " + std::to_string(most_uneven_slices) + " uneven slices");
}

/// A new file of a name of its own, removed in the end.
class TemporaryFile {
public:
    TemporaryFile() {
        std::error_code unknown;
        const std::filesystem::path folder = std::filesystem::temp_directory_path(unknown);
        path_ = ((unknown ? "/tmp" : folder) / "lamella-XXXXXX").string();
        descriptor_ = ::mkstemp(path_.data());
        if (descriptor_ < 0) {
            throw Refused{unwritable(path_, errno)};
        }
    }
    ~TemporaryFile() {
        ::close(descriptor_);
        ::unlink(path_.c_str());
    }
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;

    /// HDF5 cannot close a file that a disk had no room for, and prints so when the program ends. So it is tried before.
    void require_room(std::uint64_t bytes_of_columns) const {
        const std::vector<char> tree(std::size_t{1} << 18);
        if (::write(descriptor_, tree.data(), tree.size()) != static_cast<ssize_t>(tree.size()) ||
            ::ftruncate(descriptor_, static_cast<off_t>(bytes_of_columns + tree.size())) != 0) {
            throw Refused{unwritable(path_, errno == 0 ? ENOSPC : errno)};
        }
    }
    const std::string& path() const noexcept { return path_; }

private:
    std::string path_;
    int descriptor_ = -1;
};

void put_attribute(hid_t object, const std::string& name, hid_t type, std::size_t count, const void* values) {
    const hsize_t extent = count;
    const Handle space(count == 1 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &extent, nullptr), H5Sclose);
    const Handle attribute(H5Acreate2(object, name.c_str(), type, space.id(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    checked(H5Awrite(attribute.id(), type, values));
}

void put(hid_t object, const std::string& name, const std::string& text) {
    const Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
    checked(H5Tset_size(type.id(), std::max<std::size_t>(text.size(), 1)));
    checked(H5Tset_strpad(type.id(), H5T_STR_NULLPAD));
    checked(H5Tset_cset(type.id(), H5T_CSET_UTF8));
    put_attribute(object, name, type.id(), 1, text.data());
}
template <class Number>
void put(hid_t object, const std::string& name, const std::vector<Number>& numbers) {
    put_attribute(object, name, hdf5_type<Number>(), numbers.size(), numbers.data());
}

/// Properties of files, groups and datasets without times, so that equal contents are equal bytes.
class Creation : public Handle {
public:
    explicit Creation(hid_t what) : Handle(H5Pcreate(what), H5Pclose) {
        constexpr unsigned most_in_header = 64;  // all attributes and links lie in an object's header, up to so many
        checked(H5Pset_obj_track_times(id(), false));
        checked(H5Pset_attr_phase_change(id(), most_in_header, 0));
        if (H5Pisa_class(id(), H5P_GROUP_CREATE) > 0) {
            checked(H5Pset_link_phase_change(id(), most_in_header, 0));
        }
    }
};

/// The group at a path, which is made where it is missing.
Handle group_at(hid_t file, const std::string& path) {
    if (path == "/" || H5Lexists(file, path.c_str(), H5P_DEFAULT) > 0) {
        return {H5Gopen2(file, path.c_str(), H5P_DEFAULT), H5Gclose};
    }
    return {H5Gcreate2(file, path.c_str(), H5P_DEFAULT, Creation(H5P_GROUP_CREATE).id(), H5P_DEFAULT), H5Gclose};
}

/// Its rows get a place, and are written later.
void make_column(hid_t file, PlacedColumn& placed) {
    const Column& column = *placed.column;
    const std::array<hsize_t, 2> extents = {placed.rows, column.width};
    const Handle space(H5Screate_simple(column.width == 1 ? 1 : 2, extents.data(), nullptr), H5Sclose);
    const Creation properties(H5P_DATASET_CREATE);
    checked(H5Pset_layout(properties.id(), H5D_CONTIGUOUS));
    checked(H5Pset_alloc_time(properties.id(), H5D_ALLOC_TIME_EARLY));
    checked(H5Pset_fill_time(properties.id(), H5D_FILL_TIME_NEVER));
    const Handle dataset(H5Dcreate2(file, column.path, column.type(), space.id(), H5P_DEFAULT, properties.id(), H5P_DEFAULT),
                         H5Dclose);
    if (*column.unit != '\0') {
        put(dataset.id(), "unit", std::string(column.unit));
    }
    if (*column.meaning != '\0') {
        put(dataset.id(), "meaning", std::string(column.meaning));
    }
    if (placed.rows > 0) {
        placed.offset = H5Dget_offset(dataset.id());
        checked(placed.offset == HADDR_UNDEF ? -1 : 0);
    }
}

void write_tree(const std::string& path, const std::vector<ArchiveAttribute>& attributes,
                std::vector<PlacedColumn>& columns) {
    const QuietErrors quiet;
    const Handle access(plain_file_access(), H5Pclose);
    // The oldest form that has no times of its own.
    checked(H5Pset_libver_bounds(access.id(), H5F_LIBVER_V18, H5F_LIBVER_V18));
    const Creation creation(H5P_FILE_CREATE);
    const Handle file(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation.id(), access.id()), H5Fclose);
    for (const ArchiveAttribute& attribute : attributes) {
        const Handle group = group_at(file.id(), attribute.group);
        std::visit([&](const auto& value) { put(group.id(), attribute.name, value); }, attribute.value);
    }
    for (PlacedColumn& column : columns) {
        const std::string column_path = column.column->path;
        (void)group_at(file.id(), column_path.substr(0, std::max<std::size_t>(1, column_path.rfind('/'))));
        make_column(file.id(), column);
    }
    checked(H5Fflush(file.id(), H5F_SCOPE_GLOBAL));
}

/// Appends pieces of the tree and rows of columns in the order of the file, and sums them up.
struct ArchiveWriter {
    OutputFile& file;
    const InputFile& tree;
    const Parallel& parallel;
    double begun;  ///< the progress
    std::uint64_t at = 0;
    uLong crc = 0;

    /// From where the file ends so far to `end`.
    void append_tree(std::uint64_t end) {
        std::vector<std::byte> piece;
        while (at < end) {
            piece.resize(static_cast<std::size_t>(std::min(std::uint64_t{OutputFile::buffer_bytes}, end - at)));
            require(tree.read_at(at, piece));
            append(piece);
        }
    }

    void append(std::span<const std::byte> bytes) {
        parallel.stop_if_asked();
        file.append({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
        if (file.failed()) {
            require(file.commit());
        }
        crc = ::crc32_z(crc, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
        at += bytes.size();
        parallel.reach(begun + (1 - begun) * static_cast<double>(at) / static_cast<double>(tree.size()));
    }
};

}  // namespace

std::string closing_line(std::uint32_t crc) {
    std::array<char, 9> digits{};
    (void)std::snprintf(digits.data(), digits.size(), "%08x", crc);
    return "\n" + std::string(archive_format) + " " + std::to_string(archive_version) +
           ", CRC-32 of all before: " + digits.data() + "\n";
}

void write_columns(const KindRows& rows, FunctionRef<void(const Column&, RowSink)> give_rows,
                   const std::vector<ArchiveAttribute>& attributes, const std::filesystem::path& path,
                   const Parallel& parallel, double begun) {
    OutputFile file = require(OutputFile::create(path));  // first: what cannot be written is refused at once
    std::vector<PlacedColumn> columns;
    for (const Column& column : all_columns()) {
        if (rows[column.kind] > 0 || !column.is_optional()) {
            columns.push_back({&column, column.rows_among(rows), 0});
        }
    }
    // HDF5 makes all of the archive but the rows, and the last line, and sets the places of columns.
    const InputFile tree = [&] {
        const TemporaryFile made;  // gone as soon as it is open
        made.require_room(
            std::accumulate(columns.begin(), columns.end(), std::uint64_t{0},
                            [](std::uint64_t sum, const PlacedColumn& column) { return sum + column.bytes(); }));
        write_tree(made.path(), attributes, columns);
        return require(InputFile::open(made.path()));
    }();
    std::erase_if(columns, [](const PlacedColumn& column) { return column.rows == 0; });
    std::sort(columns.begin(), columns.end(),
              [](const PlacedColumn& a, const PlacedColumn& b) { return a.offset < b.offset; });
    parallel.begin_stage(1);
    ArchiveWriter writer{file, tree, parallel, begun};
    for (const PlacedColumn& column : columns) {
        writer.append_tree(column.offset);
        give_rows(*column.column, [&](std::span<const std::byte> piece) { writer.append(piece); });
    }
    writer.append_tree(tree.size());
    file.append(closing_line(static_cast<std::uint32_t>(writer.crc)));
    require(file.commit());
    parallel.finish();
}

bool has_archives() noexcept {
    return true;
}

Status write_archive(const SliceResult& result, const ArchiveInfo& info, const std::filesystem::path& path,
                     const Context& context) noexcept {
    return guarded(context, [&]() -> Status {
        const Parallel parallel(context);
        require_possible(result, info, path);
        const KindRows rows = rows_of(result);
        const auto give_rows = [&](const Column& column, const RowSink& take) {
            std::vector<std::byte> piece;
            for (const RowRange& range : ranges_of(column.rows_among(rows), column)) {
                piece.resize(range.count * column.row_bytes);
                column.get(result, range.first, piece);
                take(piece);
            }
        };
        write_columns(rows, give_rows, attributes_of(result.info, info, result.hash()), path, parallel);
        return {};
    });
}

}  // namespace lamella
