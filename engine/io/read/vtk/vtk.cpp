// Legacy VTK files (.vtk) of polygonal data, as text and binary, versions 1.0 to 5.x. Data at points and cells are
// skipped; reading ends where they begin, as they are last.

#include "io/read/stated.hpp"
#include "io/read/vtk/vtk_scanner.hpp"

namespace lamella {

namespace {

/// From this major version on, cells are offsets and connectivity; before, each cell's corners follow their number.
constexpr int offsets_version = 5;

/// The array from its second number on.
NumberArray without_first(const VtkFile& file, NumberArray numbers) {
    const std::size_t bytes = size_of(numbers.type);
    numbers.at = numbers.form == NumberArray::Form::text ? find_word(numbers.at, file.text.data() + file.text.size(), 1)
                                                         : numbers.at + bytes;
    numbers.data += bytes;
    --numbers.count;
    return numbers;
}

class LegacyVtk {
public:
    explicit LegacyVtk(VtkFile& file) : file_(file), scanner_(file) {}

    /// Reads all up to the attributes.
    void parse() {
        header();
        while (!scanner_.peek().empty() && !scanner_.accept("POINT_DATA") && !scanner_.accept("CELL_DATA")) {
            section();
        }
        if (!points_) {
            scanner_.expected("POINTS");
        }
        for (CellArray& array : cells_) {  // points may follow cells
            array.point_count = static_cast<std::uint32_t>(points_->count / 3);
        }
    }

    NumberArray& points() noexcept { return *points_; }
    const std::vector<CellArray>& cells() const noexcept { return cells_; }
    const StatedFrame& patient_frame() const noexcept { return patient_frame_; }

private:
    void header() {
        version();
        patient_frame_.read_header(scanner_.line());
        const bool binary = scanner_.accept("BINARY");
        if (!binary && !scanner_.accept("ASCII")) {
            scanner_.expected("'ASCII' or 'BINARY'");
        }
        if (!scanner_.accept("DATASET")) {
            scanner_.expected("'DATASET'");
        }
        if (!scanner_.accept("POLYDATA")) {
            scanner_.expected("'POLYDATA', the only kind of DATASET that is read");
        }
        scanner_.set_binary(binary);
    }

    void version() {
        for (const std::string_view word : {"#", "VTK", "DATAFILE", "VERSION"}) {
            if (!scanner_.accept(word)) {
                scanner_.expected("'" + std::string(word) + "'");
            }
        }
        const std::string_view number = scanner_.peek();
        const char* const end = number.data() + number.size();
        const auto [major_end, failure] = std::from_chars(number.data(), end, version_);
        if (failure != std::errc() || (major_end != end && *major_end != '.') || version_ < 1 ||
            version_ > offsets_version) {
            scanner_.expected("a version from 1.0 to 5.x");
        }
        scanner_.line();
    }

    /// Reads a keyword other than those that end the mesh, and its section.
    void section() {
        if (scanner_.accept("POINTS")) {
            return point_section();
        }
        if (scanner_.accept("POLYGONS")) {
            return cells("POLYGONS", CellKind::polygons);
        }
        if (scanner_.accept("TRIANGLE_STRIPS")) {
            return cells("TRIANGLE_STRIPS", CellKind::strips);
        }
        for (const char* name : {"VERTICES", "LINES"}) {
            if (scanner_.accept(name)) {
                return cells(name, std::nullopt);
            }
        }
        if (scanner_.accept("FIELD")) {
            return field();
        }
        if (scanner_.accept("METADATA")) {
            return metadata();
        }
        scanner_.expected("POINTS, POLYGONS, TRIANGLE_STRIPS or another section");
    }

    void point_section() {
        if (points_) {
            scanner_.fail("expected one section POINTS, found a second");
        }
        const std::uint64_t count = scanner_.count("POINTS");
        if (count > std::numeric_limits<std::uint32_t>::max()) {
            scanner_.fail("expected fewer than 2^32 POINTS, found " + std::to_string(count));
        }
        const NumberType type = scanner_.type();
        points_ = scanner_.numbers(3 * count, type, type == NumberType::float32 ? type : NumberType::float64, "POINTS");
    }

    /// Without a kind the cells are skipped.
    void cells(const std::string& name, std::optional<CellKind> kind) {
        CellArray* array = nullptr;
        if (kind) {
            if (std::any_of(cells_.begin(), cells_.end(), [&](const CellArray& other) { return other.kind == *kind; })) {
                scanner_.fail("expected one section " + name + ", found a second");
            }
            array = &cells_.emplace_back();
            array->name = *kind == CellKind::polygons ? "POLYGONS" : "TRIANGLE_STRIPS";
            array->kind = *kind;
        }
        const std::uint64_t cells = scanner_.count("cells of " + name);
        const std::uint64_t numbers = scanner_.count("numbers of " + name);
        if (version_ >= offsets_version) {
            return ended_cells(array, cells, numbers, name);
        }
        if (array == nullptr) {
            return scanner_.skip_numbers(numbers, NumberType::int32, name);
        }
        array->cells = cells;
        array->counted = true;
        array->corners = scanner_.numbers(numbers, NumberType::int32, NumberType::uint32, name);
    }

    void ended_cells(CellArray* array, std::uint64_t offsets, std::uint64_t corners, const std::string& name) {
        if (offsets == 0) {
            return;  // no cells, and neither of the arrays
        }
        NumberArray ends = integers("OFFSETS", offsets, NumberType::uint64, name, array == nullptr);
        NumberArray connectivity = integers("CONNECTIVITY", corners, NumberType::uint32, name, array == nullptr);
        if (array == nullptr) {
            return;
        }
        std::uint64_t first = 0;
        decode_integers(ends, 0, 1, &first);
        if (first != 0) {
            file_.fail_at(ends, 0, "the offsets of " + name + " do not begin with 0");
        }
        array->cells = offsets - 1;
        array->ends = without_first(file_, std::move(ends));
        array->corners = std::move(connectivity);
    }

    /// An array after its keyword and type, which may be skipped.
    NumberArray integers(std::string_view keyword, std::uint64_t count, NumberType as, const std::string& name, bool skip) {
        if (!scanner_.accept(keyword)) {
            scanner_.expected("'" + std::string(keyword) + "' of " + name);
        }
        const NumberType type = scanner_.type(true);
        if (skip) {
            scanner_.skip_numbers(count, type, name);
            return {};
        }
        return scanner_.numbers(count, type, as, name);
    }

    void field() {
        scanner_.word();  // its name
        for (std::uint64_t arrays = scanner_.count("arrays of FIELD"); arrays > 0; --arrays) {
            field_array();
        }
    }

    void field_array() {
        if (scanner_.accept("METADATA")) {  // of the array before
            metadata();
        }
        const std::string name = "FIELD " + printable(scanner_.word());
        const std::uint64_t components = scanner_.count("components of " + name);
        const std::uint64_t tuples = scanner_.count("tuples of " + name);
        if (components != 0 && tuples > std::numeric_limits<std::uint64_t>::max() / components) {
            scanner_.fail("expected a possible number of values of " + name);
        }
        const std::uint64_t values = components * tuples;
        if (scanner_.accept("BIT")) {
            return scanner_.skip_bits(values, name);
        }
        if (scanner_.accept("STRING") || scanner_.accept("UTF8_STRING")) {
            const std::string_view last = scanner_.strings(values, name);
            if (values == 1 && name == "FIELD SPACE") {
                patient_frame_.read_space(last);
            }
            return;
        }
        const NumberType type = scanner_.type();
        scanner_.skip_numbers(values, type, name);
    }

    /// Lines up to an empty one.
    void metadata() {
        scanner_.line();
        for (std::string_view line = scanner_.line(); skip_space(line.begin(), line.end()) != line.end();) {
            line = scanner_.line();
        }
    }

    VtkFile& file_;
    VtkScanner scanner_;
    int version_ = 0;
    StatedFrame patient_frame_;  ///< of the title and a FIELD
    std::optional<NumberArray> points_;
    std::vector<CellArray> cells_;
};

void parse_vtk(FileContents& contents, MeshFile& mesh) {
    VtkFile file(contents);
    LegacyVtk vtk(file);
    vtk.parse();
    vtk.patient_frame().give(file.source, mesh);
    give_points(file, {&vtk.points(), 1}, mesh);
    cut_cells(file, vtk.cells(), mesh);
}

}  // namespace

bool looks_like_vtk(const FileSource& source) {
    return begins_in_any_case(without_byte_order_mark(source.sample()), "# vtk datafile");
}

MeshFile read_vtk(FileSource& source) {
    return read_contents(source, parse_vtk);
}

}  // namespace lamella
