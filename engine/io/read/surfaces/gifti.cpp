// GIfTI surfaces: an XML document with an array of points and one of triangles. Arrays of numbers at points are
// skipped unless they are asked for.
#include <deque>
#include <limits>

#include "io/read/arrays/array_xml.hpp"
#include "io/read/inflater.hpp"
#include "io/text/base64.hpp"

namespace lamella {

namespace {

constexpr std::array<std::string_view, 3> gifti_encodings = {"ASCII", "Base64Binary", "GZipBase64Binary"};
constexpr std::array<std::string_view, 4> gifti_spaces = {"NIFTI_XFORM_SCANNER_ANAT", "NIFTI_XFORM_ALIGNED_ANAT",
                                                          "NIFTI_XFORM_TALAIRACH", "NIFTI_XFORM_MNI_152"};

struct GiftiArray {
    std::string_view name;          ///< for messages
    const char* element = nullptr;  ///< null: there is none
    NumberType type = NumberType::float32;
    std::uint64_t rows = 0;
    std::uint64_t columns = 3;
    bool by_columns = false;
    bool big_endian = false;
    std::string_view encoding{};
    std::string_view content{};
};

/// An array of numbers at points.
struct GiftiScalars {
    std::string name;
    GiftiArray array{.name = "values"};
};

class GiftiParser : public ArrayXml {
public:
    explicit GiftiParser(ArrayFile& file) : ArrayXml(file, "GIFTI", "<Data>", true) {}

    void read() { parse_document(); }

    GiftiArray points{.name = "points"};
    GiftiArray triangles{.name = "triangles"};
    std::deque<GiftiScalars> scalars{};
    bool in_known_space = false;  ///< the points are, all of which are RAS
    std::string moves{};          ///< what says that they belong elsewhere, or empty

private:
    void begin_path(const XmlAttributes& attributes) override {
        words_.clear();
        if (path() == "/GIFTI/DataArray") {
            const std::string_view intent = attributes.find("Intent").value_or("");
            array_ = intent == "NIFTI_INTENT_POINTSET" ? &points : intent == "NIFTI_INTENT_TRIANGLE" ? &triangles : nullptr;
            if (array_ != nullptr) {
                begin_array(attributes, *array_);
            } else if (file_.source.scalars() && type_of(attributes) != number_type_names.end()) {
                begin_scalars(attributes, intent);
            }
        } else if (path() == "/GIFTI/DataArray/Data" && array_ != nullptr) {
            begin_content(array_->content);
        }
    }

    /// Named by the file, or else by its intent: "shape".
    void begin_scalars(const XmlAttributes& attributes, std::string_view intent) {
        file_.budget.take(1, sizeof(GiftiScalars) + most_words);
        constexpr std::string_view prefix = "nifti_intent_";
        const std::string lower = lower_case(intent.substr(0, most_words));
        GiftiScalars& made = scalars.emplace_back(GiftiScalars{lower.substr(lower.starts_with(prefix) ? prefix.size() : 0)});
        array_ = &made.array;
        begin_array(attributes, made.array);
    }

    /// Among number_type_names; others, as colours, are none of numbers.
    static const std::string_view* type_of(const XmlAttributes& attributes) {
        const std::string type = lower_case(attributes.find("DataType").value_or("").substr(0, 32));
        return std::find_if(number_type_names.begin(), number_type_names.end(),
                            [&](auto name) { return type == "nifti_type_" + lower_case(name); });
    }

    void begin_array(const XmlAttributes& attributes, GiftiArray& array) {
        const auto expected = [&](const std::string& what, std::string_view name) {
            refuse("expected " + what + " of " + std::string(array.name) + ", found " +
                   in_quotes(attributes.find(name).value_or("")));
        };
        if (std::exchange(array.element, event()) != nullptr) {
            expected("one DataArray", "Intent");
        }
        const auto* const found = type_of(attributes);
        array.type = static_cast<NumberType>(found - number_type_names.begin());
        if (found == number_type_names.end() || (&array == &triangles && !is_integer(array.type))) {
            expected("another DataType", "DataType");
        }
        array.rows = count(attributes, "Dim0");
        const std::string_view dimensions = attributes.find("Dimensionality").value_or("");
        array.columns = dimensions == "1" ? 1 : dimensions == "2" ? count(attributes, "Dim1") : 0;
        const auto [least, most] =
            &array == &points || &array == &triangles ? std::pair(3U, 3U) : std::pair(1U, most_columns);
        if (array.columns < least || array.columns > most || array.rows > std::numeric_limits<std::uint32_t>::max()) {
            expected("fewer than 2^32 rows of Dim1 " + std::to_string(most), "Dim1");
        }
        array.encoding =
            *std::find(gifti_encodings.begin(), gifti_encodings.end() - 1, attributes.find("Encoding").value_or(""));
        if (attributes.find("Encoding") != array.encoding) {
            expected("the Encoding ASCII, Base64Binary or GZipBase64Binary", "Encoding");
        }
        for (const std::string_view name : {"ArrayIndexingOrder", "Endian"}) {
            if (!attributes.find(name)) {  // it would be guessed
                expected("the attribute " + std::string(name), name);
            }
        }
        array.by_columns =
            is_second(attributes, "ArrayIndexingOrder", "RowMajorOrder", "ColumnMajorOrder") && array.columns > 1;
        array.big_endian = is_second(attributes, "Endian", "LittleEndian", "BigEndian");
        if (array.by_columns && array.encoding == gifti_encodings[0]) {
            expected("no text in ColumnMajorOrder, which programs read in two ways,", "ArrayIndexingOrder");
        }
    }

    void text(std::string_view piece) override {
        words_ += piece.substr(0, most_words - std::min(most_words, words_.size()));
    }

    void end_path() override {
        const std::string_view words = trimmed(words_, " \t\r\n");
        if (path().ends_with("/MD/Name")) {
            name_ = words;
        } else if (path() == "/GIFTI/DataArray/MetaData/MD/Value" && name_ == "Name" && !scalars.empty() &&
                   array_ == &scalars.back().array && !words.empty()) {
            scalars.back().name = words;
        } else if (path().ends_with("/MD/Value") && name_.starts_with("VolGeomC_") && parse_number(words) != 0) {
            moves = "its volume is centred elsewhere";
        } else if (array_ == &points && path().ends_with("/DataSpace")) {
            const bool known = std::find(gifti_spaces.begin(), gifti_spaces.end(), words) != gifti_spaces.end();
            in_known_space = known && (in_known_space || !std::exchange(has_space_, true));
        } else if (array_ == &points && path().ends_with("/MatrixData") && !is_unit_matrix(words)) {
            moves = "a matrix leads to another one";
        }
        words_.clear();
    }

    static bool is_unit_matrix(std::string_view words) {
        const char* p = words.data();
        const char* const end = p + words.size();
        for (int i = 0; i < 16; ++i) {
            double value = 0;
            p = skip_space(p, end);
            if (p == end || read_number(p, end, value) != NumberText::read || value != (i % 5 == 0 ? 1 : 0)) {
                return false;
            }
        }
        return true;
    }

    static constexpr std::size_t most_words = 4096;  // of a matrix, or a name
    static constexpr unsigned most_columns = 1024;

    GiftiArray* array_ = nullptr;  ///< that began last; null: of no interest
    std::string words_;            ///< of the element at hand
    std::string name_;             ///< of the last datum
    bool has_space_ = false;
};

/// Expands all of `packed`, data of zlib, to all of `out`. False: they are no such data.
bool expand(std::span<const std::byte> packed, std::span<std::byte> out, const Parallel& parallel) {
    Inflater inflater(MAX_WBITS);
    int answer = Z_OK;
    while (answer == Z_OK) {
        parallel.stop_if_asked();
        answer = inflater.step(packed, out);
    }
    return answer == Z_STREAM_END && packed.empty() && out.empty();
}

/// The bytes of an array in base64, expanded where they are compressed.
Array<std::byte> unpack_gifti(ArrayFile& file, const GiftiArray& array) {
    const auto fail = [&](const std::string& what) {
        throw TextError{array.element, "the array of " + std::string(array.name) + " " + what};
    };
    const auto room = [&](std::uint64_t bytes) {
        file.budget.take(bytes, 1);
        Array<std::byte> made(file.source.memory());
        made.resize_discarding(bytes);
        return made;
    };
    const std::uint64_t total = array.columns * array.rows * size_of(array.type);
    const std::uint64_t held = base64_bytes(array.content, file.source.parallel());
    const bool packed = array.encoding == gifti_encodings[2];
    if (packed ? total / most_expansion > held : total != held) {
        fail("should have " + std::to_string(total) + " bytes, but has " + std::to_string(held) + " in base64");
    }
    Array<std::byte> bytes = room(held);
    if (!decode_base64(array.content, bytes.span(), file.source.parallel())) {
        fail("is malformed base64");
    }
    if (!packed) {
        return bytes;
    }
    Array<std::byte> expanded = room(total);
    if (!expand(bytes.span(), expanded.span(), file.source.parallel())) {
        fail("is damaged: it does not expand to " + std::to_string(total) + " bytes");
    }
    file.budget.give_back(held);
    return expanded;
}

/// Numbers that stand by columns, by rows.
Array<std::byte> by_rows(const NumberArray& numbers, std::size_t columns, const Parallel& parallel) {
    constexpr std::size_t grain = std::size_t{1} << 16;
    Array<std::byte> rows(parallel.memory());
    const std::size_t size = size_of(numbers.type);
    rows.resize_discarding(numbers.count * size);
    parallel.run_ranges(numbers.count, grain, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            const std::size_t from = i % columns * (numbers.count / columns) + i / columns;
            std::memcpy(rows.data() + i * size, numbers.data + from * size, size);
        }
    });
    return rows;
}

/// Decimals are read as `as`.
NumberArray load_gifti(ArrayFile& file, const GiftiArray& array, NumberType as) {
    const std::uint64_t count = array.columns * array.rows;
    NumberArray numbers{nullptr, count, array.type, array.big_endian, NumberArray::Form::encoded, array.element};
    if (array.encoding == gifti_encodings[0]) {
        numbers = read_all_words(file, array.content, count, as, array.name);
    } else {
        numbers.storage = unpack_gifti(file, array);
    }
    if (array.by_columns) {
        file.budget.take(count, size_of(numbers.type));
        numbers.data = numbers.storage.data();
        numbers.storage = by_rows(numbers, array.columns, file.source.parallel());
        file.budget.give_back(count * size_of(numbers.type));
    }
    numbers.data = numbers.storage.data();
    return numbers;
}

/// Of a row each point. Throws errors.
std::vector<NumberArray> load_scalars(ArrayFile& file, const GiftiScalars& scalars, std::uint64_t points) {
    if (scalars.array.rows != points) {
        throw TextError{scalars.array.element, "expected " + std::to_string(points) + " rows, one a point, found " +
                                                   std::to_string(scalars.array.rows)};
    }
    std::vector<NumberArray> loaded;
    loaded.push_back(load_gifti(file, scalars.array, NumberType::float64));
    return loaded;
}

}  // namespace

bool looks_like_gifti(const FileSource& source) {
    return begins_as_xml(source, "<GIFTI");
}

void parse_gifti(FileContents& contents, MeshFile& mesh) {
    ArrayFile file(contents);
    GiftiParser document(file);
    document.read();
    warn_unbound(file, document, mesh);
    if (document.triangles.element == nullptr) {
        file.source.refuse(ErrorCode::empty_mesh, "holds no triangles");
    }
    if (document.points.element == nullptr) {
        throw TextError{document.triangles.element, "the points of these triangles are in another file"};
    }
    const bool floats = document.points.type == NumberType::float32;
    NumberArray points = load_gifti(file, document.points, floats ? NumberType::float32 : NumberType::float64);
    CellArray triangles{.name = document.triangles.name,
                        .cells = document.triangles.rows,
                        .corners = load_gifti(file, document.triangles, NumberType::uint32),
                        .point_count = static_cast<std::uint32_t>(document.points.rows)};
    give_points(file, {&points, 1}, mesh);
    mesh.text = document.points.encoding == gifti_encodings[0];
    cut_cells(file, {&triangles, 1}, mesh);
    for (const GiftiScalars& scalars : document.scalars) {
        give_scalars(
            file, {scalars.name, static_cast<std::size_t>(scalars.array.columns), is_integer(scalars.array.type)},
            [&] { return load_scalars(file, scalars, mesh.vertex_count); }, mesh);
    }
    if (!document.moves.empty()) {
        mesh.warnings.push_back(file.source.name() + ": points are as stored, in a space of their own: " + document.moves);
    } else if (document.in_known_space) {
        mesh.patient_frame = PatientFrame::ras;
    }
}

}  // namespace lamella
