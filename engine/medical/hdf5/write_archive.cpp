#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <memory>
#include <utility>

#include <zlib.h>

#include "base/function_ref.hpp"
#include "base/guard.hpp"
#include "base/system/file.hpp"
#include "base/words.hpp"
#include "io/write/output_file.hpp"
#include "lamella/medical/archive.hpp"
#include "medical/geometry/common.hpp"
#include "medical/hdf5/archive_file.hpp"

namespace lamella {

namespace {

constexpr std::size_t longest_name = 4096;

void require_possible(const SliceResult& result, const ArchiveInfo& info, const std::filesystem::path& path) {
    const SliceInfo& slice = result.info;
    const std::uint64_t layers = result.layers.size();
    if (slice.first_layer > slice.planned_layers || layers > slice.planned_layers - slice.first_layer) {
        refuse_output(path, "a result of " + counted(layers, "layer") + " from layer " + std::to_string(slice.first_layer) +
                                " on, of " + std::to_string(slice.planned_layers) + " in all");
    }
    if (info.name.size() > longest_name || info.mesh_sha256.size() > longest_name) {
        refuse_output(path, "an archive's name of the mesh has at most " + std::to_string(longest_name) + " bytes");
    }
    if (slice.layer_of.size() != rows_of(result)[height_rows]) {
        refuse_output(path, "the result does not tell the layers of its planes");
    }
    if (info.geometry && info.geometry->uneven_slices_mm.size() > most_uneven_slices) {
        refuse_output(path, "an image of more than " + std::to_string(most_uneven_slices) + " uneven slices");
    }
}

/// A text where there is no `type`, else numbers.
void put(hid_t object, const std::string& name, NumberType type, const std::string& bytes) {
    const Handle text(H5Tcopy(H5T_C_S1), H5Tclose);
    checked(H5Tset_size(text.id(), std::max<std::size_t>(bytes.size(), 1)));
    checked(H5Tset_strpad(text.id(), H5T_STR_NULLPAD));
    checked(H5Tset_cset(text.id(), H5T_CSET_UTF8));
    const hid_t own_type = type != nullptr ? type() : text.id();
    const hsize_t count = bytes.size() / sizeof(double);
    const bool is_one = type == nullptr || count == 1;
    const Handle space(is_one ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &count, nullptr), H5Sclose);
    const Handle attribute(H5Acreate2(object, name.c_str(), own_type, space.id(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    checked(H5Awrite(attribute.id(), own_type, bytes.data()));
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
    for (const auto& [name, text] : {std::pair{"unit", column.unit}, {"meaning", column.meaning}}) {
        if (*text != '\0') {
            put(dataset.id(), name, nullptr, text);
        }
    }
    if (placed.rows > 0) {
        placed.offset = H5Dget_offset(dataset.id());
        checked(placed.offset == HADDR_UNDEF ? -1 : 0);
    }
}

/// Makes all of the archive but the rows, and the last line, and sets the places of columns.
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
        put(group.id(), attribute.name, attribute.type, attribute.bytes);
    }
    for (PlacedColumn& column : columns) {
        const std::string column_path = column.column->path;
        (void)group_at(file.id(), column_path.substr(0, std::max<std::size_t>(1, column_path.rfind('/'))));
        make_column(file.id(), column);
    }
    checked(H5Fflush(file.id(), H5F_SCOPE_GLOBAL));
}

/// The tree in a temporary file, which has no name any more.
InputFile make_tree(const std::vector<ArchiveAttribute>& attributes, std::vector<PlacedColumn>& columns) {
    std::error_code unknown;
    const std::filesystem::path folder = std::filesystem::temp_directory_path(unknown);
    std::filesystem::path path;
    File file;
    const auto require_done = [&](int failure) {
        if (failure != 0) {
            throw Refused{unwritable(path, failure)};
        }
    };
    require_done(file.create_unique((unknown ? "/tmp" : folder) / "lamella-", {}, 0600, path));
    const auto remove = [](const std::filesystem::path* made) {
        std::error_code left_behind;
        std::filesystem::remove(*made, left_behind);
    };
    const std::unique_ptr<const std::filesystem::path, decltype(remove)> removed(&path, remove);
    // HDF5 cannot close a file that a disk had no room for, and prints so when the program ends. So it is tried before.
    const std::string room(std::size_t{1} << 18, '\0');
    std::uint64_t bytes = 0;
    for (const PlacedColumn& column : columns) {
        bytes += column.bytes();
    }
    require_done(file.write(room));
    require_done(file.write_at(std::as_bytes(std::span("")), room.size() + bytes));
    require_done(file.close());
    write_tree(path_text(path), attributes, columns);
    return require(InputFile::open(path));
}

/// Takes rows of a column, one piece after the other.
using RowSink = FunctionRef<void(std::span<const std::byte>)>;

/// `give_rows` puts all rows of a column into the sink. Throws Refused, Stopped, std::bad_alloc.
void write_columns(const KindRows& rows, FunctionRef<void(const Column&, RowSink)> give_rows,
                   const std::vector<ArchiveAttribute>& attributes, const std::filesystem::path& path,
                   const Parallel& parallel) {
    OutputFile file = require(OutputFile::create(path));  // first: what cannot be written is refused at once
    std::vector<PlacedColumn> columns;
    for (const Column& column : columns::all) {
        if (rows[column.kind] > 0 || !column.is_optional()) {
            columns.push_back({&column, column.rows_among(rows), 0});
        }
    }
    const InputFile tree = make_tree(attributes, columns);
    std::erase_if(columns, [](const PlacedColumn& column) { return column.rows == 0; });
    std::sort(columns.begin(), columns.end(),
              [](const PlacedColumn& a, const PlacedColumn& b) { return a.offset < b.offset; });
    parallel.begin_stage(1);
    std::uint64_t at = 0;
    uLong crc = 0;
    const auto append = [&](std::span<const std::byte> bytes) {
        parallel.stop_if_asked();
        file.append({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
        if (file.failed()) {
            require(file.commit());
        }
        crc = ::crc32_z(crc, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
        at += bytes.size();
        parallel.reach(static_cast<double>(at) / static_cast<double>(tree.size()));
    };
    std::vector<std::byte> piece;
    const auto append_tree = [&](std::uint64_t end) {  // from where the file ends so far
        while (at < end) {
            piece.resize(static_cast<std::size_t>(std::min(std::uint64_t{OutputFile::buffer_bytes}, end - at)));
            require(tree.read_at(at, piece));
            append(piece);
        }
    };
    for (const PlacedColumn& column : columns) {
        append_tree(column.offset);
        give_rows(*column.column, append);
    }
    append_tree(tree.size());
    file.append(closing_line(static_cast<std::uint32_t>(crc)));
    require(file.commit());
    parallel.finish();
}

// --- parts that are joined

[[noreturn]] void refuse_merge(const std::string& what) {
    throw Refused{{ErrorCode::invalid_argument, what}};
}

/// "layer 7" or "layers 7 to 9".
std::string layers_between(std::uint64_t first, std::uint64_t end) {
    return end - first == 1 ? "layer " + std::to_string(first)
                            : "layers " + std::to_string(first) + " to " + std::to_string(end - 1);
}

/// An archive of some layers of a plan. Its file is opened for each piece of rows: a thousand parts may be more than a
/// process may have open.
struct ArchivePart {
    std::filesystem::path path;
    ReadTree tree;
    std::vector<ArchiveAttribute> attributes;

    std::uint64_t first_layer() const noexcept { return tree.result.info.first_layer; }
    std::uint64_t end() const noexcept { return first_layer() + tree.rows[layer_rows]; }
    std::string name() const { return "'" + printable(path_text(path)) + "'"; }
};

[[noreturn]] void refuse_other(const ArchivePart& part, const ArchivePart& first, const std::string& place) {
    refuse_merge(part.name() + " and " + first.name() + " are not of one slicing: they differ in " + place);
}

/// Ranges of layers, sorted by their begins, follow one another from the first planned layer to the last.
void require_whole(const std::vector<ArchivePart>& parts) {
    const std::uint64_t planned = parts.front().tree.result.info.planned_layers;
    for (std::size_t i = 0; i <= parts.size(); ++i) {
        const bool is_begin = i == 0;
        const bool is_end = i == parts.size();
        const std::uint64_t end = is_begin ? 0 : parts[i - 1].end();
        const std::uint64_t begin = is_end ? planned : parts[i].first_layer();
        if (begin > end) {
            const std::string missing = layers_between(end, begin);
            refuse_merge(is_begin ? missing + " are missing before " + parts[i].name()
                         : is_end ? missing + " are missing after " + parts[i - 1].name()
                                  : missing + " lie in neither " + parts[i - 1].name() + " nor " + parts[i].name());
        }
        if (begin < end && !is_end) {
            refuse_merge(parts[i - 1].name() + " and " + parts[i].name() + " both hold " +
                         layers_between(begin, std::min(parts[i].end(), end)));
        }
    }
}

/// All of one slicing, by their layers.
std::vector<ArchivePart> open_parts(std::span<const std::filesystem::path> paths, const Parallel& parallel) {
    if (paths.empty()) {
        refuse_merge("no archives to join");
    }
    std::vector<ArchivePart> parts;
    parts.reserve(paths.size());
    for (const std::filesystem::path& path : paths) {
        ReadTree tree = read_tree(require(InputFile::open(path)), path, parallel);
        std::vector<ArchiveAttribute> attributes = attributes_of(tree.result.info, tree.info, tree.hash);
        parts.push_back({path, std::move(tree), std::move(attributes)});
        const ArchivePart& part = parts.back();
        const ArchivePart& first = parts.front();
        const auto own_end = part.attributes.end() - attributes_of_part;
        const auto first_end = first.attributes.end() - attributes_of_part;
        const auto [own, other] = std::mismatch(part.attributes.begin(), own_end, first.attributes.begin(), first_end);
        if (own != own_end || other != first_end) {
            refuse_other(part, first, (own != own_end ? *own : *other).place());
        }
    }
    std::stable_sort(parts.begin(), parts.end(), [](const ArchivePart& a, const ArchivePart& b) {
        return std::pair(a.first_layer(), a.end()) < std::pair(b.first_layer(), b.end());
    });
    require_whole(parts);
    for (ArchivePart& part : std::span(parts).subspan(1)) {  // whose options are those of the first
        part.tree.rows[height_rows] = part.tree.rows[slab_rows] = part.tree.rows[fill_change_rows] = 0;
    }
    return parts;
}

/// The attributes and hash of the whole: reads and checks all rows of all parts.
ReadTree read_parts(const std::vector<ArchivePart>& parts, const Parallel& parallel, const Memory* memory) {
    LayerHash hash(parts.front().tree.result.info.planned_layers);
    ReadTree whole;
    for (const ArchivePart& part : parts) {
        ReadTree loaded = load_archive(part.path, parallel, memory);
        for (const LayerView layer : loaded.result) {
            hash.add(layer);
        }
        if (&part == &parts.front()) {
            whole.result.info = std::move(loaded.result.info);
            whole.info = std::move(loaded.info);
        } else if (option_columns(loaded.result.info) != option_columns(whole.result.info)) {
            refuse_other(part, parts.front(), "the columns of /options");
        }
    }
    whole.hash = hash.value();
    return whole;
}

/// Indices count from the first part on; -1 names none.
void shift(std::span<std::byte> rows, std::uint64_t by) {
    for (std::size_t at = 0; by != 0 && at < rows.size(); at += sizeof by) {
        std::uint64_t index = 0;
        std::memcpy(&index, rows.data() + at, sizeof index);
        index += index == ~std::uint64_t{0} ? 0 : by;
        std::memcpy(rows.data() + at, &index, sizeof index);
    }
}

void give_rows(const std::vector<ArchivePart>& parts, const Column& column, const RowSink& take) {
    std::uint64_t rows_before = 0;  // that its indices count
    std::vector<std::byte> rows;
    for (const ArchivePart& part : parts) {
        const PlacedColumn& placed = part.tree.columns[static_cast<std::size_t>(&column - columns::all.data())];
        const std::uint64_t end_rows = column.has_end && &part == &parts.back() ? 1 : 0;
        for (const RowRange& range : ranges_of(part.tree.rows[column.kind] + end_rows, column)) {
            const InputFile file = require(InputFile::open(part.path));
            rows.resize(range.count * column.row_bytes);
            require(file.read_at(placed.offset + range.first * column.row_bytes, rows));
            shift(rows, rows_before);
            take(rows);
        }
        rows_before += column.names ? part.tree.rows[*column.names] : 0;
    }
}

}  // namespace

bool has_archives() noexcept {
    return true;
}

Status write_archive(const SliceResult& result, const ArchiveInfo& info, const std::filesystem::path& path,
                     const Context& context) noexcept {
    return guarded(context, [&]() -> Status {
        const Parallel parallel(context);
        require_possible(result, info, path);
        KindRows rows = rows_of(result);
        Measures measures(context.memory);
        if (info.measures) {
            measures = require(measure(result, {.feret = true}, parallel.within(context)));
            rows[measure_rows] = measures.layers.size();
        }
        const auto give_rows = [&](const Column& column, const RowSink& take) {
            std::vector<std::byte> piece;
            for (const RowRange& range : ranges_of(column.rows_among(rows), column)) {
                piece.resize(range.count * column.row_bytes);
                if (column.measured != nullptr) {
                    for (std::size_t i = 0; i < range.count; ++i) {
                        double value = column.measured(measures.layers[range.first + i]);
                        value = std::isnan(value) ? SectionMeasures::unknown : value;  // of one form on all processors
                        std::memcpy(piece.data() + i * sizeof value, &value, sizeof value);
                    }
                } else {
                    column.get(result, range.first, piece);
                }
                take(piece);
            }
        };
        write_columns(rows, give_rows, attributes_of(result.info, info, result.hash()), path, parallel);
        return {};
    });
}

Result<MergedArchive> merge_archives(std::span<const std::filesystem::path> parts, const std::filesystem::path& path,
                                     const Context& context) noexcept {
    return guarded(context, [&]() -> Result<MergedArchive> {
        const Parallel parallel(context);
        parallel.begin_stage(0.5, 4 * parts.size());  // each is read once as a tree, and once whole
        const std::vector<ArchivePart> all = open_parts(parts, parallel);
        ReadTree whole = read_parts(all, parallel, context.memory);
        const SliceInfo& slice = whole.result.info;
        KindRows rows{};
        for (const ArchivePart& part : all) {
            std::transform(rows.begin(), rows.end(), part.tree.rows.begin(), rows.begin(), std::plus());
        }
        const auto give = [&](const Column& column, const RowSink& take) { give_rows(all, column, take); };
        write_columns(rows, give, attributes_of(slice, whole.info, whole.hash), path, parallel);
        return MergedArchive{slice.planned_layers, whole.hash, slice.grid_mm, slice.options.region.fill_rule,
                             std::move(whole.info)};
    });
}

}  // namespace lamella
