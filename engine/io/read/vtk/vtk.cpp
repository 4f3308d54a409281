// Legacy VTK files (.vtk) of polygonal data, as text and binary, versions 1.0 to 5.x. Data at points and cells are
// skipped; reading ends where they begin, as they are last.
#include <algorithm>
#include <charconv>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "io/read/reader.hpp"
#include "io/read/stated_frame.hpp"
#include "io/read/vtk/number_words.hpp"
#include "io/read/vtk/vtk_cells.hpp"
#include "io/read/vtk/vtk_file.hpp"
#include "io/read/vtk/vtk_scanner.hpp"
#include "io/text/text.hpp"

namespace lamella {

namespace {

/// From this major version on, cells are offsets and connectivity; before, each cell's corners follow their number.
constexpr int offsets_version = 5;

/// The array from its second number on.
NumberArray without_first(const VtkFile& file, NumberArray numbers) {
    const std::size_t bytes = bytes_of(numbers.type);
    if (numbers.place.form == NumberPlace::Form::text) {
        const char* const text = file.text.data();
        numbers.place.offset = file.offset_of(find_word(text + numbers.place.offset, text + file.text.size(), 1));
    } else {
        numbers.place.offset += bytes;
    }
    numbers.data += bytes;
    --numbers.count;
    return numbers;
}

class LegacyVtk {
public:
    explicit LegacyVtk(VtkFile& file) : file_(file), scanner_(file) {}

    /// Reads all up to the attributes.
    Status parse();

    /// Gives `mesh` the points. Where they can stay in `bytes`, the file's own, it takes these.
    Status give_points(Array<std::byte>& bytes, MeshFile& mesh);

    const std::vector<CellArray>& cells() const noexcept { return cells_; }
    bool binary() const noexcept { return scanner_.binary(); }
    const StatedFrame& patient_frame() const noexcept { return patient_frame_; }

private:
    Status header();
    Status version();
    /// What follows a keyword other than those that end the mesh.
    Status section();
    Status points();
    Status cells(std::string_view name, std::optional<CellKind> kind);
    Status counted_cells(CellArray* array, std::uint64_t numbers, std::string_view name);
    Status ended_cells(CellArray* array, std::uint64_t offsets, std::uint64_t corners, std::string_view name);
    template <class Value>
    Status integers(NumberArray* array, std::string_view keyword, std::uint64_t count, std::string_view name);
    Status field();
    Status field_array();
    void metadata();

    VtkFile& file_;
    VtkScanner scanner_;
    int version_ = 0;
    StatedFrame patient_frame_;  ///< of the title and a FIELD
    std::optional<NumberArray> points_;
    Array<std::byte> point_storage_;  ///< of points that were text
    std::vector<CellArray> cells_;
};

Status LegacyVtk::parse() {
    if (Status read = header(); !read) {
        return read;
    }
    while (!scanner_.peek().empty() && !scanner_.accept("POINT_DATA") && !scanner_.accept("CELL_DATA")) {
        if (Status read = section(); !read) {
            return read;
        }
    }
    if (!points_) {
        return scanner_.expected("POINTS");
    }
    for (CellArray& array : cells_) {  // points may follow cells
        array.point_count = static_cast<std::uint32_t>(points_->count / 3);
    }
    return {};
}

Status LegacyVtk::header() {
    if (Status read = version(); !read) {
        return read;
    }
    patient_frame_.read_header(scanner_.line());
    const bool binary = scanner_.accept("BINARY");
    if (!binary && !scanner_.accept("ASCII")) {
        return scanner_.expected("'ASCII' or 'BINARY'");
    }
    if (!scanner_.accept("DATASET")) {
        return scanner_.expected("'DATASET'");
    }
    if (!scanner_.accept("POLYDATA")) {
        return scanner_.expected("'POLYDATA', the only kind of DATASET that is read");
    }
    scanner_.set_binary(binary);
    return {};
}

Status LegacyVtk::version() {
    for (const std::string_view word : {"#", "VTK", "DATAFILE", "VERSION"}) {
        if (!scanner_.accept(word)) {
            return scanner_.expected("'" + std::string(word) + "'");
        }
    }
    const std::string_view number = scanner_.peek();
    const char* const end = number.data() + number.size();
    const auto [major_end, failure] = std::from_chars(number.data(), end, version_);
    if (failure != std::errc() || (major_end != end && *major_end != '.') || version_ < 1 || version_ > offsets_version) {
        return scanner_.expected("a version from 1.0 to 5.x");
    }
    scanner_.line();
    return {};
}

Status LegacyVtk::section() {
    if (scanner_.accept("POINTS")) {
        return points();
    }
    if (scanner_.accept("POLYGONS")) {
        return cells("POLYGONS", CellKind::polygons);
    }
    if (scanner_.accept("TRIANGLE_STRIPS")) {
        return cells("TRIANGLE_STRIPS", CellKind::strips);
    }
    for (const std::string_view name : {"VERTICES", "LINES"}) {
        if (scanner_.accept(name)) {
            return cells(name, std::nullopt);
        }
    }
    if (scanner_.accept("FIELD")) {
        return field();
    }
    if (scanner_.accept("METADATA")) {
        metadata();
        return {};
    }
    return scanner_.expected("POINTS, POLYGONS, TRIANGLE_STRIPS or another section");
}

Status LegacyVtk::points() {
    std::uint64_t count = 0;
    NumberType type{};
    if (points_) {
        return scanner_.error("expected one section POINTS, found a second");
    }
    if (Status read = scanner_.count("POINTS", count); !read) {
        return read;
    }
    if (count > std::numeric_limits<std::uint32_t>::max()) {
        return scanner_.error("expected fewer than 2^32 POINTS, found " + std::to_string(count));
    }
    if (Status read = scanner_.type(type); !read) {
        return read;
    }
    const Result<NumberArray> numbers = type == NumberType::float32 ? scanner_.numbers<float>(3 * count, type, "POINTS")
                                                                    : scanner_.numbers<double>(3 * count, type, "POINTS");
    if (!numbers) {
        return numbers.error();
    }
    points_ = numbers.value();
    if (!scanner_.binary()) {
        point_storage_ = std::move(scanner_.last_storage());
    }
    return {};
}

/// Without a kind the cells are skipped.
Status LegacyVtk::cells(std::string_view name, std::optional<CellKind> kind) {
    CellArray* array = nullptr;
    if (kind) {
        if (std::any_of(cells_.begin(), cells_.end(), [&](const CellArray& other) { return other.kind == *kind; })) {
            return scanner_.error("expected one section " + std::string(name) + ", found a second");
        }
        array = &cells_.emplace_back();
        array->name = name;
        array->kind = *kind;
    }
    std::uint64_t cells = 0;
    std::uint64_t numbers = 0;
    if (Status read = scanner_.count("cells of " + std::string(name), cells); !read) {
        return read;
    }
    if (Status read = scanner_.count("numbers of " + std::string(name), numbers); !read) {
        return read;
    }
    if (version_ >= offsets_version) {
        return ended_cells(array, cells, numbers, name);
    }
    if (array != nullptr) {
        array->cells = cells;
    }
    return counted_cells(array, numbers, name);
}

Status LegacyVtk::counted_cells(CellArray* array, std::uint64_t numbers, std::string_view name) {
    if (array == nullptr) {
        return scanner_.skip_numbers(numbers, NumberType::int32, name);
    }
    const Result<NumberArray> read = scanner_.numbers<std::uint32_t>(numbers, NumberType::int32, name);
    if (!read) {
        return read.error();
    }
    array->counted = true;
    array->corners = read.value();
    return {};
}

Status LegacyVtk::ended_cells(CellArray* array, std::uint64_t offsets, std::uint64_t corners, std::string_view name) {
    if (offsets == 0) {
        return {};  // no cells, and neither of the arrays
    }
    NumberArray* const ends = array != nullptr ? &array->ends : nullptr;
    if (Status read = integers<std::uint64_t>(ends, "OFFSETS", offsets, name); !read) {
        return read;
    }
    if (Status read = integers<std::uint32_t>(array != nullptr ? &array->corners : nullptr, "CONNECTIVITY", corners, name);
        !read) {
        return read;
    }
    if (array == nullptr) {
        return {};
    }
    std::uint64_t first = 0;
    decode_integers(array->ends, 0, 1, &first);
    if (first != 0) {
        return file_.error_at(array->ends, 0, "the offsets of " + std::string(name) + " do not begin with 0");
    }
    array->cells = offsets - 1;
    array->ends = without_first(file_, array->ends);
    return {};
}

/// An array whose keyword and type have been read; skipped if `array` is null.
template <class Value>
Status LegacyVtk::integers(NumberArray* array, std::string_view keyword, std::uint64_t count, std::string_view name) {
    if (!scanner_.accept(keyword)) {
        return scanner_.expected("'" + std::string(keyword) + "' of " + std::string(name));
    }
    NumberType type{};
    if (Status read = scanner_.type(type, true); !read) {
        return read;
    }
    if (array == nullptr) {
        return scanner_.skip_numbers(count, type, name);
    }
    const Result<NumberArray> read = scanner_.numbers<Value>(count, type, name);
    if (!read) {
        return read.error();
    }
    *array = read.value();
    return {};
}

// --- what is skipped

Status LegacyVtk::field() {
    scanner_.word();  // its name
    std::uint64_t arrays = 0;
    if (Status read = scanner_.count("arrays of FIELD", arrays); !read) {
        return read;
    }
    for (; arrays > 0; --arrays) {
        if (Status read = field_array(); !read) {
            return read;
        }
    }
    return {};
}

Status LegacyVtk::field_array() {
    if (scanner_.accept("METADATA")) {  // of the array before
        metadata();
    }
    const std::string name = "FIELD " + printable(scanner_.word());
    std::uint64_t components = 0;
    std::uint64_t tuples = 0;
    if (Status read = scanner_.count("components of " + name, components); !read) {
        return read;
    }
    if (Status read = scanner_.count("tuples of " + name, tuples); !read) {
        return read;
    }
    if (components != 0 && tuples > std::numeric_limits<std::uint64_t>::max() / components) {
        return scanner_.error("expected a possible number of values of " + name);
    }
    const std::uint64_t values = components * tuples;
    if (scanner_.accept("BIT")) {
        return scanner_.skip_bits(values, name);
    }
    if (scanner_.accept("STRING") || scanner_.accept("UTF8_STRING")) {
        std::string_view last;
        Status read = scanner_.strings(values, name, last);
        if (read && values == 1 && name == "FIELD SPACE") {
            patient_frame_.read_space(last);
        }
        return read;
    }
    NumberType type{};
    if (Status read = scanner_.type(type); !read) {
        return read;
    }
    return scanner_.skip_numbers(values, type, name);
}

/// Lines up to an empty one.
void LegacyVtk::metadata() {
    scanner_.line();
    for (std::string_view line = scanner_.line(); skip_space(line.begin(), line.end()) != line.end();) {
        line = scanner_.line();
    }
}

// --- what it makes

Status LegacyVtk::give_points(Array<std::byte>& bytes, MeshFile& mesh) {
    const NumberArray& points = *points_;
    mesh.coordinate_type = coordinates_of(points.type);
    mesh.stride = 3 * bytes_of(mesh.coordinate_type);
    mesh.vertex_count = points.count / 3;
    if (!scanner_.binary()) {
        mesh.bytes = std::move(point_storage_);
        return {};
    }
    if (is_integer(points.type)) {
        if (Status room = file_.budget.take(points.count, bytes_of(mesh.coordinate_type)); !room) {
            return room;
        }
        mesh.bytes = Array<std::byte>(file_.source.memory());
        mesh.bytes.resize_discarding(points.count * bytes_of(mesh.coordinate_type));
    } else {
        mesh.bytes = std::move(bytes);
        mesh.first_offset = points.place.offset;
    }
    convert_coordinates(points, mesh.coordinate_type, mesh.bytes.data() + mesh.first_offset, file_.source.parallel());
    return {};
}

}  // namespace

bool looks_like_vtk(const FileSource& source) {
    return begins_in_any_case(without_byte_order_mark(source.sample()), "# vtk datafile");
}

Result<MeshFile> read_vtk(FileSource& source) {
    Result<Array<std::byte>> bytes = source.take(source.size());
    if (!bytes) {
        return bytes.error();
    }
    const Clock::time_point start = Clock::now();
    VtkFile file{source, as_text(bytes.value().span()), MemoryBudget(source)};
    LegacyVtk vtk(file);
    if (Status parsed = vtk.parse(); !parsed) {
        return parsed.error();
    }
    MeshFile mesh;
    mesh.text = !vtk.binary();
    vtk.patient_frame().give(source, mesh);
    if (Status given = vtk.give_points(bytes.value(), mesh); !given) {
        return given.error();
    }
    if (Status cut = cut_cells(file, vtk.cells(), mesh); !cut) {
        return cut.error();
    }
    mesh.parse_ms = milliseconds_since(start);
    return mesh;
}

}  // namespace lamella
