// Legacy VTK files (.vtk) of polygonal data, as text and binary, versions 1.0 to 5.x. Data at points and cells are
// skipped; reading ends where they begin, as they are last.

#include "io/read/arrays/array_file.hpp"
#include "io/read/stated.hpp"

namespace lamella {

namespace {

/// Words and lines, and arrays that are text or binary. Throws TextErrors. Messages of a text file name the line; in a
/// binary one there are none to count.
class VtkScanner {
public:
    explicit VtkScanner(ArrayFile& file)
        : file_(file), p_(without_byte_order_mark(file.text).data()), end_(file.text.data() + file.text.size()) {}

    /// From here on all is binary, or else text.
    void set_binary(bool binary) noexcept { binary_ = binary; }

    /// The rest of the line; moves to the next line.
    std::string_view line() {
        const char* const begin = p_;
        p_ = skip_line(p_, end_);
        const std::string_view line(begin, static_cast<std::size_t>(p_ - begin));
        const std::string_view rest(p_, static_cast<std::size_t>(end_ - p_));
        p_ += rest.starts_with("\r\n") ? 2 : (rest.empty() ? 0 : 1);
        return line;
    }

    /// The next word, which stays the next; empty at the end.
    std::string_view peek() {
        p_ = skip_space(p_, end_);
        return {p_, static_cast<std::size_t>(skip_word(p_, end_) - p_)};
    }

    std::string_view word() {
        const std::string_view word = peek();
        p_ += word.size();
        return word;
    }

    /// Skips the next word if it is `keyword`, in any case.
    bool accept(std::string_view keyword) {
        const std::string_view word = peek();
        if (!is_keyword(word, keyword)) {
            return false;
        }
        p_ += word.size();
        return true;
    }

    /// Skips the next word, which must be `keyword`.
    void require(std::string_view keyword, const std::string& what) {
        if (!accept(keyword)) {
            expected(what);
        }
    }

    /// An integer that is not negative; `what` names it in messages.
    std::uint64_t count(const std::string& what) {
        const std::string_view digits = peek();
        std::uint64_t value = 0;
        if (!read_integer(digits, value)) {
            expected("the number of " + what);
        }
        p_ += digits.size();
        return value;
    }

    /// The name of a type, or of a type of integers.
    NumberType type(bool of_integers = false) {
        const std::string_view name = peek();
        const std::optional<NumberType> found = type_named(name);
        if (!found || (of_integers && !is_integer(*found))) {
            expected(of_integers ? "a type of integers" : "a type of numbers");
        }
        p_ += name.size();
        return *found;
    }

    /// The `count` numbers that follow. As text they are read as `as`: see read_words().
    NumberArray numbers(std::uint64_t count, NumberType type, NumberType as, std::string_view name) {
        return binary_ ? bytes(count, type, name) : read_words(file_, p_, end_, count, as, name);
    }
    void skip_numbers(std::uint64_t count, NumberType type, std::string_view name) {
        if (binary_) {
            bytes(count, type, name);
        } else {
            skip_words(file_, p_, end_, count, name);
        }
    }

    /// Eight to a byte, or as words.
    void skip_bits(std::uint64_t count, std::string_view name) {
        skip_numbers(binary_ ? count / 8 + (count % 8 != 0 ? 1 : 0) : count, NumberType::uint8, name);
    }

    /// Skips strings, as text each on a line of its own, as bytes each after its length. Returns the last of them.
    std::string_view strings(std::uint64_t count, std::string_view name) {
        std::string_view last;
        line();
        StopPace pace = pace_of(file_.source.parallel());
        for (; count > 0; --count) {
            pace.spend(step_work);
            need(1, name);
            last = binary_ ? binary_string(name) : line();
        }
        return last;
    }

    /// Throws an error at the next word.
    [[noreturn]] void fail(const std::string& what) {
        peek();
        fail_here(what);
    }

    [[noreturn]] void expected(const std::string& what) {
        peek();
        fail_here("expected " + what + ", found " + word_at(p_, end_));
    }

private:
    /// Sizes are those of 64-bit Unix where they depend on the machine; a vtkIdType has 32 bits in these files, whatever it
    /// had in memory.
    static std::optional<NumberType> type_named(std::string_view name) {
        constexpr std::array<std::array<std::string_view, 3>, 10> names = {{{"vtktypeint8", "char", "signed_char"},
                                                                            {"vtktypeuint8", "unsigned_char"},
                                                                            {"vtktypeint16", "short"},
                                                                            {"vtktypeuint16", "unsigned_short"},
                                                                            {"vtktypeint32", "int", "vtkidtype"},
                                                                            {"vtktypeuint32", "unsigned_int"},
                                                                            {"vtktypeint64", "long"},
                                                                            {"vtktypeuint64", "unsigned_long"},
                                                                            {"vtktypefloat32", "float"},
                                                                            {"vtktypefloat64", "double"}}};
        const std::string lower = lower_case(name.substr(0, 32));
        const auto* const found = std::find_if(names.begin(), names.end(), [&](const auto& each) {
            return !lower.empty() && std::find(each.begin(), each.end(), lower) != each.end();
        });
        return found == names.end() ? std::nullopt : std::optional(static_cast<NumberType>(found - names.begin()));
    }

    /// True if `word` is `keyword`, in any case.
    static bool is_keyword(std::string_view word, std::string_view keyword) {
        return std::equal(word.begin(), word.end(), keyword.begin(), keyword.end(),
                          [](char a, char b) { return lower_case(a) == lower_case(b); });
    }

    [[noreturn]] void fail_here(const std::string& what) const { throw TextError{p_, what, !binary_}; }
    /// Those that follow the end of the line.
    NumberArray bytes(std::uint64_t count, NumberType type, std::string_view name) {
        while (p_ != end_ && *p_ != '\n' && is_space(*p_)) {
            ++p_;
        }
        if (p_ == end_ || *p_ != '\n') {
            expected("the end of the line before the bytes of " + std::string(name));
        }
        ++p_;
        const auto left = static_cast<std::uint64_t>(end_ - p_);
        if (count > left / size_of(type)) {
            fail_here("is truncated: expected " + std::to_string(count) + " numbers of " + std::string(name) + " at " +
                      std::to_string(size_of(type)) + " bytes, found " + std::to_string(left) + " bytes");
        }
        const char* const first = p_;
        p_ += count * size_of(type);
        return {reinterpret_cast<const std::byte*>(first), count, type, true, NumberArray::Form::bytes, first};
    }

    /// The first two bits tell how many bytes the length has, of which they are part: 8, 4, 2 or 1.
    std::string_view binary_string(std::string_view name) {
        const std::uint64_t length_bytes = std::uint64_t{8} >> (static_cast<unsigned char>(*p_) >> 6);
        need(length_bytes, name);
        std::uint64_t length = static_cast<unsigned char>(*p_++) & 0x3F;
        for (std::uint64_t i = 1; i < length_bytes; ++i) {
            length = length << 8 | static_cast<unsigned char>(*p_++);
        }
        need(length, name);
        const std::string_view string(p_, length);
        p_ += length;
        return string;
    }

    /// So many bytes of strings must be left.
    void need(std::uint64_t bytes, std::string_view name) const {
        if (static_cast<std::uint64_t>(end_ - p_) < bytes) {
            fail_here("is truncated within the strings of " + std::string(name));
        }
    }

    ArrayFile& file_;
    const char* p_;
    const char* end_;
    bool binary_ = false;
};

/// From this major version on, cells are offsets and connectivity; before, each cell's corners follow their number.
constexpr int offsets_version = 5;

constexpr std::string_view polygons = "POLYGONS";
constexpr std::string_view strips = "TRIANGLE_STRIPS";

/// The array from its second number on.
NumberArray without_first(const ArrayFile& file, NumberArray numbers) {
    const std::size_t bytes = size_of(numbers.type);
    numbers.at = numbers.form == NumberArray::Form::text ? find_word(numbers.at, file.text.data() + file.text.size(), 1)
                                                         : numbers.at + bytes;
    numbers.data += bytes;
    --numbers.count;
    return numbers;
}

class LegacyVtk {
public:
    explicit LegacyVtk(ArrayFile& file) : file_(file), scanner_(file) {}

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
        if (!binary) {
            scanner_.require("ASCII", "'ASCII' or 'BINARY'");
        }
        scanner_.require("DATASET", "'DATASET'");
        scanner_.require("POLYDATA", "'POLYDATA', the only kind of DATASET that is read");
        scanner_.set_binary(binary);
    }

    void version() {
        for (const std::string_view word : {"#", "VTK", "DATAFILE", "VERSION"}) {
            scanner_.require(word, "'" + std::string(word) + "'");
        }
        const std::string_view number = scanner_.peek();
        version_ = number.empty() ? 0 : number[0] - '0';
        if (version_ < 1 || version_ > offsets_version || (number.size() > 1 && number[1] != '.')) {
            scanner_.expected("a version from 1.0 to 5.x");
        }
        scanner_.line();
    }

    /// Reads a keyword other than those that end the mesh, and its section.
    void section() {
        if (scanner_.accept("POINTS")) {
            return point_section();
        }
        for (const std::string_view name : {polygons, strips, std::string_view("VERTICES"), std::string_view("LINES")}) {
            if (scanner_.accept(name)) {
                return cells(name, name == polygons || name == strips);
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

    /// They are skipped unless they are wanted.
    void cells(std::string_view section, bool wanted) {
        const std::string name(section);
        CellArray array{.name = section,
                        .kind = section == strips ? CellKind::strips : CellKind::polygons,
                        .counted = version_ < offsets_version};
        if (std::any_of(cells_.begin(), cells_.end(), [&](const CellArray& other) { return other.name == section; })) {
            scanner_.fail("expected one section " + name + ", found a second");
        }
        array.cells = scanner_.count("cells of " + name);
        const std::uint64_t corners = scanner_.count("numbers of " + name);
        if (array.counted) {
            array.corners = numbers(corners, NumberType::int32, NumberType::uint32, name, wanted);
        } else if (array.cells > 0) {  // else there are neither cells nor any of the arrays
            array.ends = integers("OFFSETS", array.cells, NumberType::uint64, name, wanted);
            if (wanted && integer_at(array.ends, 0) != 0) {
                throw file_.error_at(array.ends, 0, "the offsets of " + name + " do not begin with 0");
            }
            array.ends = wanted ? without_first(file_, std::move(array.ends)) : NumberArray();
            --array.cells;  // of which each but the first offset ends one
            array.corners = integers("CONNECTIVITY", corners, NumberType::uint32, name, wanted);
        }
        if (wanted) {
            cells_.push_back(std::move(array));
        }
    }

    /// An array after its keyword and type.
    NumberArray integers(std::string_view keyword, std::uint64_t count, NumberType as, const std::string& name,
                         bool wanted) {
        scanner_.require(keyword, "'" + std::string(keyword) + "' of " + name);
        const NumberType type = scanner_.type(true);
        return numbers(count, type, as, name, wanted);
    }

    NumberArray numbers(std::uint64_t count, NumberType type, NumberType as, const std::string& name, bool wanted) {
        if (wanted) {
            return scanner_.numbers(count, type, as, name);
        }
        scanner_.skip_numbers(count, type, name);
        return {};
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

    ArrayFile& file_;
    VtkScanner scanner_;
    int version_ = 0;
    StatedFrame patient_frame_;  ///< of the title and a FIELD
    std::optional<NumberArray> points_;
    std::vector<CellArray> cells_;
};

}  // namespace

void parse_vtk(FileContents& contents, MeshFile& mesh) {
    ArrayFile file(contents);
    LegacyVtk vtk(file);
    vtk.parse();
    vtk.patient_frame().give(file.source, mesh);
    give_points(file, {&vtk.points(), 1}, mesh);
    cut_cells(file, vtk.cells(), mesh);
}

bool looks_like_vtk(const FileSource& source) {
    return begins_in_any_case(without_byte_order_mark(source.sample()), "# vtk datafile");
}

}  // namespace lamella
