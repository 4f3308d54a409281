#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>

#include <unistd.h>

#include "io/write/output_file.hpp"
#include "medical/hdf5/archive_file.hpp"
#include "medical/hdf5/handles.hpp"

namespace lamella {

namespace {

/// All attributes and links lie in an object's header, up to so many.
constexpr unsigned most_in_header = 64;

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
        const std::vector<char> tree(std::size_t{1} << 16);
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

/// Of files, groups and datasets, so that equal contents are equal bytes: without times.
Handle creation_of(hid_t what) {
    Handle properties(H5Pcreate(what), H5Pclose);
    checked(H5Pset_obj_track_times(properties.id(), false));
    checked(H5Pset_attr_phase_change(properties.id(), most_in_header, 0));
    if (H5Pisa_class(properties.id(), H5P_GROUP_CREATE) > 0) {
        checked(H5Pset_link_phase_change(properties.id(), most_in_header, 0));
    }
    return properties;
}

/// The groups of a file, by their paths.
class Groups {
public:
    explicit Groups(hid_t file) : file_(file) {}

    Handle open(const std::string& path) {
        if (!path.empty() && path != "/" && std::find(made_.begin(), made_.end(), path) == made_.end()) {
            made_.push_back(path);
            const Handle properties = creation_of(H5P_GROUP_CREATE);
            return {H5Gcreate2(file_, path.c_str(), H5P_DEFAULT, properties.id(), H5P_DEFAULT), H5Gclose};
        }
        return {H5Gopen2(file_, path.empty() ? "/" : path.c_str(), H5P_DEFAULT), H5Gclose};
    }

private:
    hid_t file_;
    std::vector<std::string> made_;
};

/// Its rows get a place, and are written later.
void make_column(hid_t file, PlacedColumn& placed) {
    const Column& column = column_of(placed.id);
    const std::array<hsize_t, 2> extents = {placed.rows, column.width};
    const Handle space(H5Screate_simple(column.width == 1 ? 1 : 2, extents.data(), nullptr), H5Sclose);
    const Handle properties = creation_of(H5P_DATASET_CREATE);
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

void write_tree(const std::string& path, const ArchiveHead& head, std::vector<PlacedColumn>& columns) {
    const QuietErrors quiet;
    const Handle access = plain_file_access();
    // The oldest form that has no times of its own.
    checked(H5Pset_libver_bounds(access.id(), H5F_LIBVER_V18, H5F_LIBVER_V18));
    const Handle creation = creation_of(H5P_FILE_CREATE);
    const Handle file(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation.id(), access.id()), H5Fclose);
    Groups groups(file.id());
    for (const Fact& fact : head.facts) {
        const Handle group = groups.open(fact.group);
        std::visit([&](const auto& value) { put(group.id(), fact.name, value); }, fact.value);
    }
    const Handle root = groups.open("/");
    put(root.id(), "format", std::string(archive_format));
    put(root.id(), "format_version", std::vector<std::uint64_t>{archive_version});
    put(root.id(), "result_hash", std::vector<std::uint64_t>{head.hash});
    put(root.id(), "first_layer", std::vector<std::uint64_t>{head.first_layer});
    for (PlacedColumn& column : columns) {
        const std::string column_path = column_of(column.id).path;
        (void)groups.open(column_path.substr(0, column_path.rfind('/')));
        make_column(file.id(), column);
    }
    checked(H5Fflush(file.id(), H5F_SCOPE_GLOBAL));
}

}  // namespace

InputFile make_tree(const ArchiveHead& head, std::vector<PlacedColumn>& columns) {
    const TemporaryFile file;
    std::uint64_t bytes = 0;
    for (const PlacedColumn& column : columns) {
        bytes += column.bytes();
    }
    file.require_room(bytes);
    write_tree(file.path(), head, columns);
    Result<InputFile> made = InputFile::open(file.path());
    if (!made) {
        throw Refused{made.error()};
    }
    return std::move(made).value();
}

}  // namespace lamella
