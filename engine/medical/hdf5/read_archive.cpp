#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <zlib.h>

#include "base/guard.hpp"
#include "base/numbers.hpp"
#include "base/words.hpp"
#include "io/text/text.hpp"
#include "lamella/io/name_text.hpp"
#include "lamella/medical/archive.hpp"
#include "medical/geometry/common.hpp"
#include "medical/hdf5/archive_file.hpp"
#include "options/asked.hpp"
#include "options/option_words.hpp"
#include "slicing/nesting/order.hpp"
#include "slicing/result/band_output.hpp"

namespace lamella {

namespace {

[[noreturn]] void refuse(const InputFile& file, const std::string& why) {
    throw Refused{file.error(ErrorCode::malformed_mesh, why)};
}

/// Throws Refused unless it holds: the file is not what it should be at `place`, a path within it.
void require_place(const InputFile& file, bool holds, std::string_view place, std::string_view why) {
    if (!holds) {
        refuse(file, std::string(place) + ": " + std::string(why));
    }
}

// --- the attributes

constexpr std::array<std::string_view, 3> frames = {"", "LPS", "RAS"};
constexpr std::array<std::string_view, 1> formats = {archive_format};
constexpr std::uint64_t most = std::numeric_limits<std::uint64_t>::max();

/// Visits each attribute: lists its value, or sets it by that of an open archive and checks it.
class AttributeVisitor {
public:
    AttributeVisitor() = default;
    AttributeVisitor(const InputFile& file, hid_t root) : file_(&file), root_(root) {}

    std::vector<ArchiveAttribute> take() && { return std::move(attributes_); }

    void begin(const char* group) { group_ = group; }

    /// A text, or as many numbers as there are.
    template <class Values>
    void values(const char* name, Values& value) {
        using Value = typename Values::value_type;
        constexpr bool is_text = std::is_same_v<Value, char>;
        if (file_ == nullptr) {
            const NumberType type = is_text ? nullptr : &hdf5_type<Value>;
            const std::string_view bytes(reinterpret_cast<const char*>(value.data()), value.size() * sizeof(Value));
            attributes_.push_back({group_, name, type, std::string(bytes)});
            return;
        }
        const hid_t id = H5Aopen_by_name(root_, group_, name, H5P_DEFAULT, H5P_DEFAULT);
        require(id >= 0, name, "missing");
        const Handle open(id, H5Aclose);
        const Handle type(H5Aget_type(id), H5Tclose);
        const Handle space(H5Aget_space(id), H5Sclose);
        bool is_good = H5Sget_simple_extent_npoints(space.id()) == (is_text ? 1 : static_cast<hssize_t>(value.size()));
        if constexpr (is_text) {
            constexpr std::size_t longest_text = 65536;
            const std::size_t size = H5Tget_size(type.id());
            is_good = is_good && H5Tget_class(type.id()) == H5T_STRING && H5Tis_variable_str(type.id()) == 0 && size > 0 &&
                      size <= longest_text;
            value.resize(is_good ? size : 0);
        } else {
            is_good = is_good && H5Tequal(type.id(), hdf5_type<Value>()) > 0;
        }
        require(is_good && H5Aread(id, type.id(), value.data()) >= 0, name, "not of the type and size that it should have");
        if constexpr (is_text) {
            value.resize(std::min(value.find('\0'), value.size()));
        } else if constexpr (std::is_floating_point_v<Value>) {
            require(std::all_of(value.begin(), value.end(), [](double one) { return std::isfinite(one); }), name);
        }
    }
    void number(const char* name, double& value) {
        std::array<double, 1> one = {value};
        values(name, one);
        value = one[0];
    }

    template <class Whole>
    void whole(const char* name, Whole& value, std::uint64_t least, std::uint64_t largest) {
        std::array<std::uint64_t, 1> one = {static_cast<std::uint64_t>(value)};
        values(name, one);
        require(one[0] >= least && one[0] <= largest, name);
        value = static_cast<Whole>(one[0]);
    }

    template <class Enum>
    void choice(const char* name, Enum& value, std::span<const std::string_view> words) {
        std::string word(words[static_cast<std::size_t>(value)]);
        values(name, word);
        const auto place = std::find(words.begin(), words.end(), word);
        require(place != words.end(), name);
        value = static_cast<Enum>(place - words.begin());
    }

    /// Returns whether there is a value: in a file, by the name of one of its members.
    template <class Value>
    bool optional(const char* name, std::optional<Value>& value) {
        if (file_ != nullptr && H5Aexists_by_name(root_, group_, name, H5P_DEFAULT) > 0) {
            value.emplace();
        }
        return value.has_value();
    }

    /// By its type. Fill rules of ranges of layers are columns. Counts are the range of layers that was cut, in which the
    /// parts of a slicing differ: the root and the rows say it.
    template <class Option>
    void option(const char* name, Option& value) {
        if constexpr (std::is_same_v<Option, double>) {
            number(name, value);
        } else if constexpr (std::is_same_v<Option, bool>) {
            whole(name, value, 0, 1);
        } else if constexpr (std::is_enum_v<Option>) {
            choice(name, value, detail::words_of(value));
        } else if constexpr (std::is_same_v<Option, Transform>) {
            values(name, value.m);
        } else if constexpr (std::is_same_v<Option, std::optional<double>>) {
            if (optional(name, value)) {
                number(name, *value);
            }
        } else if constexpr (std::is_same_v<Option, std::optional<std::vector<double>>>) {
            bool given = value.has_value();  // the list is a column, and may have no rows
            whole("at_heights", given, 0, 1);
            if (given && !value) {
                value.emplace();
            }
        } else {
            static_assert(std::is_same_v<Option, std::uint64_t> || std::is_same_v<Option, std::vector<Slab>> ||
                          std::is_same_v<Option, std::vector<FillFrom>>);
        }
    }

    /// Throws Refused if a value that was read does not hold.
    void require(bool holds, const char* name, const char* why = "out of its range") const {
        if (file_ != nullptr) {
            require_place(*file_, holds, ArchiveAttribute{group_, name, {}, {}}.place(), why);
        }
    }

private:
    const InputFile* file_ = nullptr;  ///< to be read; none to list attributes
    hid_t root_ = -1;
    const char* group_ = "/";
    std::vector<ArchiveAttribute> attributes_;
};

void visit_mesh(AttributeVisitor& visitor, SliceInfo& slice, ArchiveInfo& info) {
    visitor.begin("/mesh");
    std::string name = text_of_name(info.name);  // since any bytes are a name
    visitor.values("name", name);
    info.name = name_of_text(name);
    visitor.values("sha256", info.mesh_sha256);
    visitor.choice("patient_frame", info.frame, frames);
    visitor.whole("triangles", slice.triangles, 0, most);
    visitor.whole("degenerate", slice.degenerate, 0, most);
    visitor.values("min_mm", slice.box.min_mm);
    visitor.values("max_mm", slice.box.max_mm);
    visitor.whole("meshes", slice.part_count, 1, several_parts - 1);
    if (visitor.optional("weld_tolerance_mm", info.weld)) {
        visitor.number("weld_tolerance_mm", info.weld->tolerance_mm);
        visitor.whole("weld_joined", info.weld->joined, 0, most);
    }
}

void visit_image(AttributeVisitor& visitor, ArchiveInfo& info) {
    visitor.begin("/image");
    if (!visitor.optional("origin_mm", info.geometry)) {
        return;
    }
    ImageGeometry& image = *info.geometry;
    static constexpr std::array<const char*, 3> size_names = {"size_i", "size_j", "size_k"};
    static constexpr std::array<const char*, 3> axis_names = {"axis_i", "axis_j", "axis_k"};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        visitor.whole(size_names[axis], image.size[axis], 1, largest_image_side);
        visitor.values(axis_names[axis], image.axes[axis]);
        visitor.require(std::abs(length(image.axes[axis]) - 1) < 1e-3, axis_names[axis]);
    }
    visitor.values("origin_mm", image.origin_mm);
    visitor.values("spacing_mm", image.spacing_mm);
    visitor.require(*std::min_element(image.spacing_mm.begin(), image.spacing_mm.end()) > 0, "spacing_mm");
    visitor.whole("subslices", info.subslices, 1, 1000);
    std::optional shear = image.is_sheared() ? std::optional(image.shear_mm) : std::nullopt;
    if (visitor.optional("shear_mm", shear)) {
        visitor.values("shear_mm", *shear);
        image.shear_mm = *shear;
    }
    std::uint64_t uneven = image.uneven_slices_mm.size();
    visitor.whole("uneven_slices", uneven, 0, most_uneven_slices);
    if (uneven > 0) {
        visitor.require(uneven == image.size[2], "uneven_slices");
        image.uneven_slices_mm.resize(uneven);
        visitor.values("uneven_slices_mm", image.uneven_slices_mm);
    }
}

void visit(AttributeVisitor& visitor, SliceInfo& slice, ArchiveInfo& info, std::uint64_t& hash) {
    visitor.begin("/");
    visitor.number("grid_mm", slice.grid_mm);
    visitor.require(slice.grid_mm > 0, "grid_mm");
    visitor.whole("grid_doublings", slice.grid_doublings, 0, 1000);
    visit_mesh(visitor, slice, info);
    visitor.begin("/options");
#define OPTION(kind, name, path, ...) visitor.option(#name, slice.options.path);
#include "options/options.inc"
    visit_image(visitor, info);
    visitor.begin("/");
    std::optional measures = info.measures ? std::optional<std::uint64_t>(1) : std::nullopt;
    info.measures = visitor.optional("measures", measures);
    if (info.measures) {
        visitor.whole("measures", *measures, 1, 1);
    }
    visitor.whole("planned_layers", slice.planned_layers, 0, most);  // last: where options differ, that is what is said
    std::size_t format = 0;
    std::uint64_t version = archive_version;
    visitor.choice("format", format, formats);
    visitor.whole("format_version", version, archive_version, archive_version);
    visitor.whole("result_hash", hash, 0, most);
    visitor.whole("first_layer", slice.first_layer, 0, most);
}

// --- the tree

std::string text_at(const InputFile& file, std::uint64_t offset, std::size_t bytes) {
    std::string text(bytes, '\0');
    require(file.read_at(offset, std::as_writable_bytes(std::span(text))));
    return text;
}

std::uint32_t checksum_of(const InputFile& file, std::uint64_t bytes, const Parallel& parallel) {
    constexpr std::uint64_t at_once = std::uint64_t{1} << 20;
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

/// The last line says of which version the file is.
void require_undamaged(const InputFile& file, const Parallel& parallel) {
    constexpr std::string_view signature = "\x89HDF\r\n\x1a\n";
    if (text_at(file, 0, std::min<std::uint64_t>(file.size(), signature.size())) != signature) {
        refuse(file, "no HDF5 file");
    }
    const std::string expected = closing_line(0);
    const std::uint64_t bytes = file.size() - std::min<std::uint64_t>(file.size(), expected.size());
    const std::string line = text_at(file, bytes, static_cast<std::size_t>(file.size() - bytes));
    const std::size_t version = expected.find(std::to_string(archive_version));
    if (!line.starts_with(std::string_view(expected).substr(0, version))) {
        refuse(file, "an HDF5 file, but no archive of lamella, or one that is cut off: its last line is not an archive's");
    }
    if (line[version] != expected[version]) {
        refuse(file, "written by another version of lamella: an archive of form " + line.substr(version, 1) + ", not " +
                         expected.substr(version, 1));
    }
    if (line != closing_line(checksum_of(file, bytes, parallel))) {
        refuse(file, "damaged, or changed by another program: it does not have its checksum");
    }
}

/// The places of columns. No dataset has no rows. Data that are not in one piece of this file have no offset.
void find_columns(const InputFile& file, hid_t root, ReadTree& tree) {
    std::uint64_t bytes = 0;
    std::optional<ColumnKind> before;
    for (const Column& column : columns::all) {
        PlacedColumn placed{&column};
        if (const hid_t id = H5Dopen2(root, column.path, H5P_DEFAULT); id >= 0) {
            const Handle dataset(id, H5Dclose);
            const Handle type(H5Dget_type(id), H5Tclose);
            const Handle space(H5Dget_space(id), H5Sclose);
            std::array<hsize_t, 2> extents = {0, 1};
            const int dimensions = column.width == 1 ? 1 : 2;
            require_place(file,
                          H5Tequal(type.id(), column.type()) > 0 && H5Sget_simple_extent_ndims(space.id()) == dimensions &&
                              H5Sget_simple_extent_dims(space.id(), extents.data(), nullptr) == dimensions &&
                              extents[1] == column.width,
                          column.path, "not of the type and shape that it should have");
            placed.rows = extents[0];
            placed.offset = placed.rows == 0 ? 0 : H5Dget_offset(id);
        }
        require_place(file, placed.rows <= file.size() / column.row_bytes && placed.offset <= file.size() - placed.bytes(),
                      column.path, "not in one piece within the file");
        const std::uint64_t ends = column.has_end ? 1 : 0;
        require_place(file, placed.rows >= ends && (before != column.kind || tree.rows[column.kind] == placed.rows - ends),
                      column.path, "missing, or not as long as the columns that belong to it");
        bytes += placed.bytes();
        tree.columns.push_back(placed);
        tree.rows[column.kind] = placed.rows - ends;
        before = column.kind;
    }
    require_place(file, tree.rows[measure_rows] == (tree.info.measures ? tree.rows[layer_rows] : 0), "/measures",
                  "not as many as there are layers");
    require_place(file, bytes <= file.size(), "/", "columns lie over one another");  // memory is taken for all of them
}

// --- the rows

void require_row(const InputFile& file, bool holds, const char* path, std::uint64_t row, const char* why) {
    if (!holds) {
        require_place(file, false, path, "row " + std::to_string(row) + " " + why);
    }
}

/// Arrays of the right sizes, their contents unspecified.
void make_room(const InputFile& file, ReadTree& tree) {
    require_place(file, tree.rows[origin_rows] == 0 || tree.rows[origin_rows] == tree.rows[point_rows], "/origins",
                  "not as many as there are points");
    const SliceInfo& info = tree.result.info;
    require_place(file,
                  info.first_layer <= info.planned_layers && tree.rows[layer_rows] <= info.planned_layers - info.first_layer,
                  "/planned_layers", "fewer layers than the file has");
    resize(tree.result, tree.rows);
    KindRows rows = rows_of(tree.result);
    rows[measure_rows] = tree.rows[measure_rows];
    require_place(file, rows == tree.rows, "/options", "has columns that its attributes do not ask for");
}

void load_rows(const InputFile& file, ReadTree& tree, const Parallel& parallel) {
    make_room(file, tree);
    std::vector<std::pair<const PlacedColumn*, RowRange>> pieces;  // of columns that do not follow from others
    for (const PlacedColumn& placed : tree.columns) {
        for (const RowRange& range : ranges_of(placed.column->set != nullptr ? placed.rows : 0, *placed.column)) {
            pieces.emplace_back(&placed, range);
        }
    }
    parse_pieces<Refused>(pieces.size(), parallel, [&](std::size_t i, int) {
        const auto& [placed, range] = pieces[i];
        const Column& column = *placed->column;
        std::vector<std::byte> rows(range.count * column.row_bytes);
        require(file.read_at(placed->offset + range.first * column.row_bytes, rows));
        const std::uint64_t good_rows = column.set(tree.result, range.first, rows);
        require_row(file, good_rows == range.count, column.path, range.first + good_rows, "is out of its range");
    });
    require(file.unchanged());
}

// --- what no single row shows

/// Sets how many of `end` follow from each row's first one to the next row's.
template <class T, class Count>
void set_row_counts(const InputFile& file, const char* path, Array<T>& rows, std::uint64_t end, std::uint64_t T::*first,
                    Count T::*count, std::uint64_t least) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const std::uint64_t begin = rows[i].*first;
        const std::uint64_t next = i + 1 < rows.size() ? rows[i + 1].*first : end;
        require_row(file,
                    (i > 0 || begin == 0) && next >= begin && next <= end && next - begin >= least &&
                        next - begin <= std::numeric_limits<Count>::max(),
                    path, i, "does not lead on to the next row");
        rows[i].*count = static_cast<Count>(next - begin);
    }
}

/// Parents start before their children, or there and are larger, so that no chain of parents runs in a ring.
bool is_parent(const SliceResult& result, const Layer& layer, const Contour& contour) {
    if (contour.parent < 0) {
        return contour.parent == -1;
    }
    const auto index = static_cast<std::uint64_t>(contour.parent);
    if (index < layer.first_contour || index >= layer.first_contour + layer.contour_count) {
        return false;
    }
    const Contour& parent = result.contours[index];
    const Point start = result.points[contour.first_point];
    const Point around = result.points[parent.first_point];
    const auto size = [](const Contour& of) {
        const Int128 area = to_int128(of.twice_area);
        return area < 0 ? -area : area;
    };
    return parent.role <= Role::hole && (around < start || (around == start && size(parent) > size(contour)));
}

/// Checks offsets, parents and the order of layers, and sets what follows from the columns.
void check_loaded(const InputFile& file, SliceResult& result, const Parallel& parallel) {
    constexpr std::size_t grain = 256;
    set_row_counts(file, "/layers/first_contour", result.layers, result.contours.size(), &Layer::first_contour,
                   &Layer::contour_count, 0);
    set_row_counts(file, "/contours/first_point", result.contours, result.points.size(), &Contour::first_point,
                   &Contour::point_count, 1);
    parallel.run_ranges(result.contours.size(), grain, [&](std::size_t begin, std::size_t end, int) {
        for (Contour& contour : result.contours.span().subspan(begin, end - begin)) {
            const std::span<const Point> points = result.points_of(contour);
            const bool has_area = contour.role == Role::outer || contour.role == Role::hole;
            contour.twice_area = to_integer128(has_area ? examine_ring(points.data(), points.size()).twice_area : 0);
        }
    });
    for (std::size_t i = 0; i < result.layers.size(); ++i) {
        parallel.stop_if_asked();
        const Layer& layer = result.layers[i];
        require_row(file, i == 0 || layer.plane > result.layers[i - 1].plane, "/layers/plane", i,
                    "not above the row before");
        require_row(file, layer.bottom_mm <= layer.plane_mm && layer.plane_mm <= layer.top_mm, "/layers/plane_mm", i,
                    "not between bottom and top");
        for (const Contour& contour : result.contours_of(layer)) {
            require_row(file, is_parent(result, layer, contour), "/contours/parent",
                        static_cast<std::uint64_t>(&contour - result.contours.data()), "cannot lie around the contour");
        }
    }
}

/// Counts, and the range of layers that was asked for.
void set_info(SliceResult& result) {
    SliceInfo& info = result.info;
    info.layers = result.layers.size();
    LayerTotals totals;
    totals.stitches = result.stitches.size();
    for (const Contour& contour : result.contours) {
        totals.add(contour);
    }
    for (const Layer& layer : result.layers) {
        totals.add(layer);
        info.segments += layer.segments;
    }
    totals.describe(info);
    const std::uint64_t end = info.first_layer + info.layers;
    set_layers(info.options, info.first_layer, end < info.planned_layers ? end : all_layers);
}

}  // namespace

std::string closing_line(std::uint32_t crc) {
    return "\n" + std::string(archive_format) + " " + std::to_string(archive_version) +
           ", CRC-32 of all before: " + hex_text(crc, 8) + "\n";
}

std::vector<ArchiveAttribute> attributes_of(SliceInfo slice, ArchiveInfo info, std::uint64_t hash) {
    AttributeVisitor lister;
    visit(lister, slice, info, hash);
    return std::move(lister).take();
}

ReadTree read_tree(const InputFile& file, const std::filesystem::path& path, const Parallel& parallel,
                   const Memory* memory) {
    require_undamaged(file, parallel);
    const QuietErrors quiet;
    const Handle access(plain_file_access(), H5Pclose);
    const hid_t id = H5Fopen(path.c_str(), H5F_ACC_RDONLY, access.id());
    if (id < 0) {
        refuse(file, "a damaged HDF5 file");
    }
    const Handle open(id, H5Fclose);
    ReadTree tree{.result = SliceResult(memory)};
    AttributeVisitor reader(file, id);
    visit(reader, tree.result.info, tree.info, tree.hash);
    find_columns(file, id, tree);
    return tree;
}

ReadTree load_archive(const std::filesystem::path& path, const Parallel& parallel, const Memory* memory) {
    const InputFile file = require(InputFile::open(path));
    ReadTree tree = read_tree(file, path, parallel, memory);
    load_rows(file, tree, parallel);
    check_loaded(file, tree.result, parallel);
    require_place(file, tree.result.hash() == tree.hash, "/result_hash", "not the hash of the layers");
    set_info(tree.result);
    return tree;
}

Result<Archive> read_archive(const std::filesystem::path& path, const Context& context) noexcept {
    return guarded(context, [&]() -> Result<Archive> {
        const Parallel parallel(context);
        parallel.begin_stage(0.9, 3);  // checksum, rows, areas
        ReadTree loaded = load_archive(path, parallel, context.memory);
        parallel.finish();
        return Archive{std::move(loaded.result), std::move(loaded.info)};
    });
}

}  // namespace lamella
