#include <algorithm>
#include <array>

#include <zlib.h>

#include "base/guard.hpp"
#include "medical/hdf5/archive_file.hpp"
#include "medical/hdf5/handles.hpp"

namespace lamella {

namespace {

constexpr std::size_t longest_text = 65536;

std::string place_of(const std::string& object, const std::string& name) {
    return (object == "/" ? "" : object) + "/" + name;
}

[[noreturn]] void refuse(const InputFile& file, const std::string& why) {
    throw Refused{file.error(ErrorCode::malformed_mesh, why)};
}

std::string text_at(const InputFile& file, std::uint64_t offset, std::size_t bytes) {
    std::string text(bytes, '\0');
    if (const Status read = file.read_at(offset, std::as_writable_bytes(std::span(text))); !read) {
        throw Refused{read.error()};
    }
    return text;
}

std::uint32_t checksum_of(const InputFile& file, std::uint64_t bytes, const Parallel& parallel) {
    constexpr std::uint64_t at_once = rows_at_once_bytes;
    std::vector<uLong> sums(static_cast<std::size_t>((bytes + at_once - 1) / at_once));
    const auto piece_bytes = [&](std::size_t i) { return std::min(at_once, bytes - i * at_once); };
    parallel.run(sums.size(), [&](std::size_t i, int) {
        const std::string piece = text_at(file, i * at_once, piece_bytes(i));
        sums[i] = ::crc32_z(0, reinterpret_cast<const unsigned char*>(piece.data()), piece.size());
    });
    uLong sum = 0;
    for (std::size_t i = 0; i < sums.size(); ++i) {
        sum = ::crc32_combine(sum, sums[i], static_cast<z_off_t>(piece_bytes(i)));
    }
    return static_cast<std::uint32_t>(sum);
}

void require_undamaged(const InputFile& file, const Parallel& parallel) {
    constexpr std::string_view signature = "\x89HDF\r\n\x1a\n";
    constexpr std::string_view first_version = "lamella archive 1\n";
    const std::size_t line_bytes = closing_line(0).size();
    const std::string begin = text_at(file, 0, std::min<std::uint64_t>(file.size(), first_version.size()));
    if (begin == first_version) {
        refuse(file, "written by an earlier version of lamella");
    }
    if (!begin.starts_with(signature)) {
        refuse(file, "no HDF5 file");
    }
    const std::string before_version = "\n" + std::string(archive_format) + " ";
    const std::uint64_t bytes = file.size() - std::min<std::uint64_t>(file.size(), line_bytes);
    const std::string line = text_at(file, bytes, std::min<std::uint64_t>(file.size(), line_bytes));
    if (!line.starts_with(before_version)) {
        refuse(file, "an HDF5 file, but no archive of lamella, or one that is cut off: its last line is not an archive's");
    }
    if (line != closing_line(checksum_of(file, bytes, parallel))) {
        refuse(file, "damaged, changed by another program, or of another version: it does not have its checksum");
    }
}

/// Soft links could run in a ring, and external ones lead elsewhere.
void require_hard_link(const InputFile& file, hid_t tree, const std::string& path) {
    H5L_info_t link{};
    if (!path.empty() && (H5Lget_info(tree, path.c_str(), &link, H5P_DEFAULT) < 0 || link.type != H5L_TYPE_HARD)) {
        refuse_place(file, path, "not a plain link");
    }
}

PlacedColumn open_column(const InputFile& file, hid_t tree, const Column& column) {
    const hid_t id = H5Dopen2(tree, column.path, H5P_DEFAULT);
    if (id < 0) {
        refuse_place(file, column.path, "cannot be opened");
    }
    const Handle dataset(id, H5Dclose);
    const Handle type(H5Dget_type(id), H5Tclose);
    const Handle space(H5Dget_space(id), H5Sclose);
    const Handle creation(H5Dget_create_plist(id), H5Pclose);
    std::array<hsize_t, 2> extents = {0, 1};
    const int dimensions = column.width == 1 ? 1 : 2;
    if (H5Tequal(type.id(), column.type()) <= 0 || H5Sget_simple_extent_ndims(space.id()) != dimensions ||
        H5Sget_simple_extent_dims(space.id(), extents.data(), nullptr) != dimensions || extents[1] != column.width) {
        refuse_place(file, column.path, "not of the type and shape that it should have");
    }
    if (H5Pget_layout(creation.id()) != H5D_CONTIGUOUS || H5Pget_external_count(creation.id()) != 0) {
        refuse_place(file, column.path, "not in one piece, as lamella writes it");
    }
    const PlacedColumn placed{&column, extents[0], extents[0] == 0 ? 0 : H5Dget_offset(id)};
    if (placed.rows > file.size() / column.row_bytes || placed.offset > file.size() - placed.bytes()) {
        refuse_place(file, column.path, "reaches beyond the end of the file");
    }
    return placed;
}

/// The rows of a column; none where it is left out.
std::uint64_t find_column(const InputFile& file, hid_t tree, const Column& column, std::vector<PlacedColumn>& found) {
    const std::string path = column.path;
    const std::string group = path.substr(0, path.rfind('/'));
    const auto exists = [&](const std::string& link) { return H5Lexists(tree, link.c_str(), H5P_DEFAULT) > 0; };
    if ((group.empty() || exists(group)) && exists(path)) {
        require_hard_link(file, tree, group);
        require_hard_link(file, tree, path);
        found.push_back(open_column(file, tree, column));
        return found.back().rows;
    }
    if (!column.optional) {
        refuse_place(file, path, "missing");
    }
    return 0;
}

void find_columns(const InputFile& file, hid_t tree, ReadTree& found) {
    std::uint64_t bytes = 0;
    const Column* before = nullptr;
    for (const Column& column : all_columns()) {
        const std::uint64_t rows = find_column(file, tree, column, found.columns);
        if (before != nullptr && before->kind == column.kind && found.rows[column.kind] != rows) {
            refuse_place(file, column.path, "missing, or not as long as the columns that belong to it");
        }
        found.rows[column.kind] = rows;
        bytes += rows * column.row_bytes;
        before = &column;
    }
    if (bytes > file.size()) {  // memory is taken for all of them
        refuse(file, "its columns lie over one another");
    }
}

Handle open_attribute(const InputFile& file, hid_t tree, const std::string& object, const std::string& name,
                      std::size_t count) {
    const hid_t id = H5Aopen_by_name(tree, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT);
    if (id < 0) {
        refuse_place(file, place_of(object, name), "missing");
    }
    Handle attribute(id, H5Aclose);
    const Handle space(H5Aget_space(id), H5Sclose);
    if (H5Sget_simple_extent_npoints(space.id()) != static_cast<hssize_t>(count)) {
        refuse_place(file, place_of(object, name), "not as many values as it should have");
    }
    return attribute;
}

}  // namespace

bool Attributes::has(const std::string& object, const std::string& name) const {
    return H5Aexists_by_name(tree_, object.c_str(), name.c_str(), H5P_DEFAULT) > 0;
}

void Attributes::refuse(const std::string& object, const std::string& name) const {
    refuse_place(file_, place_of(object, name), "out of its range");
}

std::string Attributes::text(const std::string& object, const std::string& name) const {
    const Handle attribute = open_attribute(file_, tree_, object, name, 1);
    const Handle type(H5Aget_type(attribute.id()), H5Tclose);
    const std::size_t size = H5Tget_size(type.id());
    if (H5Tget_class(type.id()) != H5T_STRING || H5Tis_variable_str(type.id()) != 0 || size == 0 || size > longest_text) {
        refuse_place(file_, place_of(object, name), "not a text of fixed length");
    }
    std::string text(size, '\0');
    if (H5Aread(attribute.id(), type.id(), text.data()) < 0) {
        refuse_place(file_, place_of(object, name), "cannot be read");
    }
    text.resize(std::min(text.find('\0'), text.size()));
    return text;
}

template <class Number>
std::vector<Number> Attributes::numbers(const std::string& object, const std::string& name, std::size_t count) const {
    const Handle attribute = open_attribute(file_, tree_, object, name, count);
    const Handle type(H5Aget_type(attribute.id()), H5Tclose);
    if (H5Tequal(type.id(), hdf5_type<Number>()) <= 0) {
        refuse_place(file_, place_of(object, name), "not of the type that it should have");
    }
    std::vector<Number> values(count);
    if (H5Aread(attribute.id(), type.id(), values.data()) < 0) {
        refuse_place(file_, place_of(object, name), "cannot be read");
    }
    return values;
}

std::vector<double> Attributes::doubles(const std::string& object, const std::string& name, std::size_t count) const {
    return numbers<double>(object, name, count);
}

std::uint64_t Attributes::whole(const std::string& object, const std::string& name) const {
    return numbers<std::uint64_t>(object, name, 1).front();
}

void refuse_place(const InputFile& file, const std::string& place, const std::string& why) {
    refuse(file, place + ": " + why);
}

ReadTree read_tree(const InputFile& file, const std::filesystem::path& path, const Parallel& parallel,
                   const Memory* memory) {
    require_undamaged(file, parallel);
    const QuietErrors quiet;
    const Handle access = plain_file_access();
    const hid_t id = H5Fopen(path.c_str(), H5F_ACC_RDONLY, access.id());
    if (id < 0) {
        refuse(file, "a damaged HDF5 file");
    }
    const Handle open(id, H5Fclose);
    const Attributes attributes(file, id);
    if (!attributes.has("/", "format") || attributes.text("/", "format") != archive_format) {
        refuse(file, "an HDF5 file, but no archive of lamella");
    }
    if (attributes.whole("/", "format_version") != archive_version) {
        refuse_place(file, "/format_version", "written by a later version of lamella");
    }
    ReadTree tree{.result = SliceResult(memory), .info = {}};
    read_facts(attributes, tree.result, tree.info);
    tree.hash = attributes.whole("/", "result_hash");
    tree.result.first_layer = attributes.whole("/", "first_layer");
    find_columns(file, id, tree);
    return tree;
}

}  // namespace lamella
