#include <algorithm>
#include <array>

#include "base/guard.hpp"
#include "medical/hdf5/file_driver.hpp"
#include "medical/hdf5/handles.hpp"
#include "medical/hdf5/numbers.hpp"
#include "medical/hdf5/seal.hpp"
#include "medical/hdf5/tree.hpp"

namespace lamella {

namespace {

constexpr std::size_t longest_text = 65536;

/// The tree of an open file. Only objects of plain numbers and texts are looked at, so that nothing in a foreign file leads
/// HDF5 to other files or to filters.
class TreeReader final : public FactReader {
public:
    TreeReader(const InputFile& file, hid_t tree) : file_(file), tree_(tree) {}

    bool has(const std::string& group, const std::string& name) override {
        return H5Aexists_by_name(tree_, group.c_str(), name.c_str(), H5P_DEFAULT) > 0;
    }

    void read(const std::string& group, const std::string& name, std::size_t count, FactValue& value) override {
        if (auto* const text = std::get_if<std::string>(&value)) {
            *text = read_text(group, name);
        } else if (auto* const doubles = std::get_if<std::vector<double>>(&value)) {
            *doubles = read_numbers<double>(group, name, NumberType::f64, count);
        } else {
            value = read_numbers<std::uint64_t>(group, name, NumberType::u64, count);
        }
    }

    [[noreturn]] void refuse(const std::string& group, const std::string& name) override {
        refuse_place(file_, place(group, name), "out of its range");
    }

    std::uint64_t whole(const std::string& object, const std::string& name) {
        return read_numbers<std::uint64_t>(object, name, NumberType::u64, 1).front();
    }

    std::string read_text(const std::string& object, const std::string& name) {
        const Handle attribute = open_attribute(object, name, 1);
        const Handle type(H5Aget_type(attribute.id()), H5Tclose);
        const std::size_t size = H5Tget_size(type.id());
        if (H5Tget_class(type.id()) != H5T_STRING || H5Tis_variable_str(type.id()) != 0 || size == 0 ||
            size > longest_text) {
            refuse_place(file_, place(object, name), "not a text of fixed length");
        }
        std::string text(size, '\0');
        if (H5Aread(attribute.id(), type.id(), text.data()) < 0) {
            refuse_place(file_, place(object, name), "cannot be read: " + hdf5_words());
        }
        text.resize(std::min(text.find('\0'), text.size()));
        return text;
    }

    /// Whether it is there.
    bool find_column(ColumnId id, PlacedColumn& placed) {
        const Column& column = column_of(id);
        const std::string path = column.path;
        const std::string group = path.substr(0, path.rfind('/'));
        const auto exists = [this](const std::string& link) { return H5Lexists(tree_, link.c_str(), H5P_DEFAULT) > 0; };
        if ((!group.empty() && !exists(group)) || !exists(path)) {
            if (!column.optional) {
                refuse_place(file_, path, "missing");
            }
            return false;
        }
        require_hard_link(group);
        require_hard_link(path);
        placed.id = id;
        open_column(column, placed);
        const std::uint64_t crc = whole(path, "crc32");
        placed.crc = static_cast<std::uint32_t>(crc);
        if (placed.crc != crc) {
            refuse(path, "crc32");
        }
        return true;
    }

private:
    static std::string place(const std::string& object, const std::string& name) {
        return (object == "/" ? "" : object) + "/" + name;
    }

    Handle open_attribute(const std::string& object, const std::string& name, std::size_t count) {
        const hid_t id = H5Aopen_by_name(tree_, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT);
        if (id < 0) {
            refuse_place(file_, place(object, name), "missing");
        }
        Handle attribute(id, H5Aclose);
        const Handle space(H5Aget_space(id), H5Sclose);
        if (H5Sget_simple_extent_npoints(space.id()) != static_cast<hssize_t>(count)) {
            refuse_place(file_, place(object, name), "not as many values as it should have");
        }
        return attribute;
    }

    template <class T>
    std::vector<T> read_numbers(const std::string& object, const std::string& name, NumberType number, std::size_t count) {
        const Handle attribute = open_attribute(object, name, count);
        const Handle type(H5Aget_type(attribute.id()), H5Tclose);
        if (H5Tequal(type.id(), hdf5_type(number)) <= 0) {
            refuse_place(file_, place(object, name), "not of the type that it should have");
        }
        std::vector<T> values(count);
        if (H5Aread(attribute.id(), type.id(), values.data()) < 0) {
            refuse_place(file_, place(object, name), "cannot be read: " + hdf5_words());
        }
        return values;
    }

    /// Soft links could run in a ring, and external ones lead elsewhere.
    void require_hard_link(const std::string& path) {
        H5L_info_t link{};
        if (!path.empty() && (H5Lget_info(tree_, path.c_str(), &link, H5P_DEFAULT) < 0 || link.type != H5L_TYPE_HARD)) {
            refuse_place(file_, path, "not a plain link");
        }
    }

    void open_column(const Column& column, PlacedColumn& placed) {
        const hid_t id = H5Dopen2(tree_, column.path, H5P_DEFAULT);
        if (id < 0) {
            refuse_place(file_, column.path, "cannot be opened: " + hdf5_words());
        }
        const Handle dataset(id, H5Dclose);
        const Handle type(H5Dget_type(id), H5Tclose);
        const Handle space(H5Dget_space(id), H5Sclose);
        const Handle creation(H5Dget_create_plist(id), H5Pclose);
        std::array<hsize_t, 2> extents = {0, 1};
        const int dimensions = column.width == 1 ? 1 : 2;
        if (H5Tequal(type.id(), hdf5_type(column.number)) <= 0 || H5Sget_simple_extent_ndims(space.id()) != dimensions ||
            H5Sget_simple_extent_dims(space.id(), extents.data(), nullptr) != dimensions || extents[1] != column.width) {
            refuse_place(file_, column.path, "not of the type and shape that it should have");
        }
        if (H5Pget_layout(creation.id()) != H5D_CONTIGUOUS || H5Pget_external_count(creation.id()) != 0) {
            refuse_place(file_, column.path, "not in one piece, as lamella writes it");
        }
        placed.rows = extents[0];
        placed.offset = placed.rows == 0 ? 0 : H5Dget_offset(id);
        if (placed.rows > file_.size() / column.row_bytes() || placed.offset > file_.size() - placed.bytes()) {
            refuse_place(file_, column.path, "reaches beyond the end of the file");
        }
    }

    const InputFile& file_;
    hid_t tree_;
};

void find_columns(TreeReader& reader, const InputFile& file, std::uint64_t tree_bytes, ReadTree& tree) {
    std::uint64_t bytes = 0;
    for_each_column([&](ColumnId id) {
        PlacedColumn column;
        if (reader.find_column(id, column)) {
            bytes += column.bytes();
            tree.columns.push_back(column);
        }
    });
    if (tree_bytes + bytes != file.size()) {
        throw Refused{
            file.error(ErrorCode::malformed_mesh, "its columns lie over one another, or something lies between them")};
    }
}

}  // namespace

void refuse_place(const InputFile& file, const std::string& place, const std::string& why) {
    throw Refused{file.error(ErrorCode::malformed_mesh, place + ": " + why)};
}

ReadTree read_tree(const InputFile& file, const Memory* memory) {
    const std::vector<std::byte> sealed = read_sealed(file);
    const QuietErrors quiet;
    ReadOnlyFile backing(sealed, file.size());
    const BackedAccess access(backing);
    const hid_t id = H5Fopen("archive", H5F_ACC_RDONLY, access.properties());
    if (id < 0) {
        throw Refused{file.error(ErrorCode::malformed_mesh, "a damaged HDF5 file: " + hdf5_words())};
    }
    const Handle open(id, H5Fclose);
    TreeReader reader(file, id);
    if (!reader.has("/", "format") || reader.read_text("/", "format") != archive_format) {
        throw Refused{file.error(ErrorCode::malformed_mesh, "an HDF5 file, but no archive of lamella")};
    }
    if (reader.whole("/", "format_version") != archive_version) {
        refuse_place(file, "/format_version", "written by a later version of lamella");
    }
    ReadTree tree{.result = SliceResult(memory), .info = {}, .columns = {}};
    read_facts(reader, tree.result, tree.info);
    tree.hash = reader.whole("/", "result_hash");
    tree.result.first_layer = reader.whole("/", "first_layer");
    find_columns(reader, file, sealed.size(), tree);
    return tree;
}

}  // namespace lamella
