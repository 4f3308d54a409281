#include <algorithm>
#include <limits>
#include <utility>

#include <zlib.h>

#include "base/guard.hpp"
#include "base/numbers.hpp"
#include "io/text/text.hpp"
#include "lamella/medical/archive.hpp"
#include "medical/hdf5/archive_file.hpp"
#include "options/asked.hpp"
#include "slicing/nesting/order.hpp"
#include "slicing/result/band_output.hpp"

namespace lamella {

namespace {

[[noreturn]] void refuse(const InputFile& file, const std::string& why) {
    throw Refused{file.error(ErrorCode::malformed_mesh, why)};
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

/// A column's place. No dataset has no rows. Data that are not in one piece of this file have no offset.
PlacedColumn find_column(const InputFile& file, hid_t root, const Column& column) {
    const hid_t id = H5Dopen2(root, column.path, H5P_DEFAULT);
    if (id < 0) {
        return {&column, 0, 0};
    }
    const Handle dataset(id, H5Dclose);
    const Handle type(H5Dget_type(id), H5Tclose);
    const Handle space(H5Dget_space(id), H5Sclose);
    std::array<hsize_t, 2> extents = {0, 1};
    const int dimensions = column.width == 1 ? 1 : 2;
    if (H5Tequal(type.id(), column.type()) <= 0 || H5Sget_simple_extent_ndims(space.id()) != dimensions ||
        H5Sget_simple_extent_dims(space.id(), extents.data(), nullptr) != dimensions || extents[1] != column.width) {
        refuse_place(file, column.path, "not of the type and shape that it should have");
    }
    const PlacedColumn placed{&column, extents[0], extents[0] == 0 ? 0 : H5Dget_offset(id)};
    if (placed.rows > file.size() / column.row_bytes || placed.offset > file.size() - placed.bytes()) {
        refuse_place(file, column.path, "not in one piece within the file");
    }
    return placed;
}

void find_columns(const InputFile& file, hid_t root, ReadTree& tree) {
    std::uint64_t bytes = 0;
    std::optional<ColumnKind> before;
    for (const Column& column : all_columns()) {
        const PlacedColumn& placed = tree.columns.emplace_back(find_column(file, root, column));
        const std::uint64_t rows = placed.rows - (column.has_end ? 1 : 0);
        if (placed.rows < (column.has_end ? 1U : 0U) || (before == column.kind && tree.rows[column.kind] != rows)) {
            refuse_place(file, column.path, "missing, or not as long as the columns that belong to it");
        }
        bytes += placed.bytes();
        tree.rows[column.kind] = rows;
        before = column.kind;
    }
    if (bytes > file.size()) {  // memory is taken for all of them
        refuse(file, "its columns lie over one another");
    }
}

// --- the rows

void require_row(const InputFile& file, bool holds, const char* path, std::uint64_t row, const char* why) {
    if (!holds) {
        refuse_place(file, path, "row " + std::to_string(row) + " " + why);
    }
}

/// Arrays of the right sizes, their contents unspecified.
void make_room(const InputFile& file, ReadTree& tree) {
    const auto require = [&](bool holds, const char* place, const char* why) {
        if (!holds) {
            refuse_place(file, place, why);
        }
    };
    require(tree.rows[origin_rows] == 0 || tree.rows[origin_rows] == tree.rows[point_rows], "/origins",
            "not as many as there are points");
    const SliceInfo& info = tree.result.info;
    require(info.first_layer <= info.planned_layers && tree.rows[layer_rows] <= info.planned_layers - info.first_layer,
            "/planned_layers", "fewer layers than the file has");
    resize(tree.result, tree.rows);
    const KindRows made = rows_of(tree.result);
    for (const Column& column : all_columns()) {
        require(made[column.kind] == tree.rows[column.kind], column.path, "no heights are asked for");
    }
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
    read_attributes(file, id, tree);
    find_columns(file, id, tree);
    return tree;
}

ReadTree load_archive(const std::filesystem::path& path, const Parallel& parallel, const Memory* memory) {
    const InputFile file = require(InputFile::open(path));
    ReadTree tree = read_tree(file, path, parallel, memory);
    load_rows(file, tree, parallel);
    check_loaded(file, tree.result, parallel);
    if (tree.result.hash() != tree.hash) {
        refuse_place(file, "/result_hash", "not the hash of the layers");
    }
    set_info(tree.result);
    return tree;
}

Result<Archive> read_archive(const std::filesystem::path& path, const Context& context) noexcept {
    return guarded(context, [&]() -> Result<Archive> {
        const Parallel parallel(context);
        parallel.begin_stage(0.9, load_runs);
        ReadTree loaded = load_archive(path, parallel, context.memory);
        parallel.finish();
        return Archive{std::move(loaded.result), std::move(loaded.info)};
    });
}

}  // namespace lamella
