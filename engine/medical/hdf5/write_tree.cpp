#include <algorithm>
#include <array>
#include <cstdio>

#include "medical/hdf5/file_driver.hpp"
#include "medical/hdf5/handles.hpp"
#include "medical/hdf5/numbers.hpp"
#include "medical/hdf5/seal.hpp"
#include "medical/hdf5/tree.hpp"

namespace lamella {

namespace {

/// All attributes and links lie in an object's header, up to so many.
constexpr unsigned most_in_header = 64;

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
void put(hid_t object, const std::string& name, const std::vector<double>& numbers) {
    put_attribute(object, name, hdf5_type(NumberType::f64), numbers.size(), numbers.data());
}
void put(hid_t object, const std::string& name, const std::vector<std::uint64_t>& numbers) {
    put_attribute(object, name, hdf5_type(NumberType::u64), numbers.size(), numbers.data());
}

void keep_without_times(hid_t properties) {
    checked(H5Pset_obj_track_times(properties, false));
    checked(H5Pset_attr_phase_change(properties, most_in_header, 0));
}

Handle creation_of(hid_t what) {
    Handle properties(H5Pcreate(what), H5Pclose);
    keep_without_times(properties.id());
    if (H5Pisa_class(properties.id(), H5P_GROUP_CREATE) > 0) {
        checked(H5Pset_link_phase_change(properties.id(), most_in_header, 0));
    }
    return properties;
}

/// Groups come by the paths in them.
void make_group_of(hid_t file, const std::string& path, std::vector<std::string>& made) {
    const std::size_t end = path.rfind('/');
    const std::string group = path.substr(0, end);
    if (end == 0 || std::find(made.begin(), made.end(), group) != made.end()) {
        return;
    }
    const Handle properties = creation_of(H5P_GROUP_CREATE);
    const Handle handle(H5Gcreate2(file, group.c_str(), H5P_DEFAULT, properties.id(), H5P_DEFAULT), H5Gclose);
    made.push_back(group);
}

/// Its rows get a place, and are written later.
void make_column(hid_t file, PlacedColumn& placed) {
    const Column& column = column_of(placed.id);
    const std::array<hsize_t, 2> extents = {placed.rows, column.width};
    const Handle space(H5Screate_simple(column.width == 1 ? 1 : 2, extents.data(), nullptr), H5Sclose);
    const Handle properties = creation_of(H5P_DATASET_CREATE);
    checked(H5Pset_layout(properties.id(), H5D_CONTIGUOUS));
    checked(H5Pset_alloc_time(properties.id(), H5D_ALLOC_TIME_EARLY));
    checked(H5Pset_fill_time(properties.id(), H5D_FILL_TIME_NEVER));
    const Handle dataset(
        H5Dcreate2(file, column.path, hdf5_type(column.number), space.id(), H5P_DEFAULT, properties.id(), H5P_DEFAULT),
        H5Dclose);
    if (*column.unit != '\0') {
        put(dataset.id(), "unit", std::string(column.unit));
    }
    if (*column.meaning != '\0') {
        put(dataset.id(), "meaning", std::string(column.meaning));
    }
    put(dataset.id(), "crc32", std::vector<std::uint64_t>{placed.crc});
    if (placed.rows > 0) {
        placed.offset = H5Dget_offset(dataset.id());
        checked(placed.offset == HADDR_UNDEF ? -1 : 0);
    }
}

void put_facts(hid_t file, const ArchiveHead& head, std::vector<std::string>& groups) {
    for (const Fact& fact : head.facts) {
        if (fact.group != "/") {
            make_group_of(file, fact.group + "/", groups);
        }
        const Handle group(H5Gopen2(file, fact.group.c_str(), H5P_DEFAULT), H5Gclose);
        std::visit([&](const auto& value) { put(group.id(), fact.name, value); }, fact.value);
    }
    const Handle root(H5Gopen2(file, "/", H5P_DEFAULT), H5Gclose);
    put(root.id(), "format", std::string(archive_format));
    put(root.id(), "format_version", std::vector<std::uint64_t>{archive_version});
    put(root.id(), "result_hash", std::vector<std::uint64_t>{head.hash});
    put(root.id(), "first_layer", std::vector<std::uint64_t>{head.first_layer});
}

/// Throws where the tree reaches beyond `columns_begin`.
void write_tree(SparseFile& file, std::uint64_t columns_begin, const ArchiveHead& head, std::vector<PlacedColumn>& columns) {
    const BackedAccess access(file, columns_begin);
    // The oldest form that has no times of its own.
    checked(H5Pset_libver_bounds(access.properties(), H5F_LIBVER_V18, H5F_LIBVER_V18));
    const Handle creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
    keep_without_times(creation.id());
    checked(H5Pset_link_phase_change(creation.id(), most_in_header, 0));
    checked(H5Pset_userblock(creation.id(), seal_bytes));
    const Handle tree(H5Fcreate("archive", H5F_ACC_TRUNC, creation.id(), access.properties()), H5Fclose);
    std::vector<std::string> groups;
    put_facts(tree.id(), head, groups);
    for (PlacedColumn& column : columns) {
        make_group_of(tree.id(), column_of(column.id).path, groups);
        make_column(tree.id(), column);
    }
    checked(H5Fflush(tree.id(), H5F_SCOPE_GLOBAL));
}

/// Columns begin behind what is written; all that is known of its size before is a bound.
std::uint64_t bytes_of_tree(const ArchiveHead& head, std::vector<PlacedColumn> columns) {
    constexpr std::uint64_t bound = std::uint64_t{1} << 20;
    constexpr std::uint64_t alignment = 512;
    SparseFile file;
    write_tree(file, bound, head, columns);
    return (file.written_before(bound) + alignment - 1) / alignment * alignment;
}

}  // namespace

std::vector<std::byte> make_tree(const ArchiveHead& head, std::vector<PlacedColumn>& columns) {
    const QuietErrors quiet;
    std::vector<std::byte> tree(bytes_of_tree(head, columns));
    SparseFile file;
    write_tree(file, tree.size(), head, columns);
    if (file.failed()) {
        throw std::bad_alloc();
    }
    std::uint64_t next = tree.size();
    for (const PlacedColumn& column : columns) {
        checked(column.rows > 0 && column.offset != next ? -1 : 0);
        next += column.bytes();
    }
    (void)file.read(0, tree);
    seal(tree, file.size());
    return tree;
}

}  // namespace lamella
