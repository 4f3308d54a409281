// A model part of a 3MF package as it streams by. Vertices and triangles as nearly every program writes them are read
// without the XML parser, which takes several times as long.

#include <limits>

#include "io/read/three_mf/three_mf_model.hpp"

namespace lamella::three_mf {

namespace {

constexpr std::string_view core = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02";
constexpr std::string_view draft_of_2013 = "http://schemas.microsoft.com/3dmanufacturing/2013/01";
constexpr std::string_view production = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06";
constexpr std::string_view compatibility = "http://schemas.openxmlformats.org/markup-compatibility/2006";

/// Extensions that a file may require: those read here, and those without geometry.
constexpr std::array supported_extensions = {
    core,
    production,
    std::string_view("http://schemas.microsoft.com/3dmanufacturing/material/2015/02"),
    std::string_view("http://schemas.microsoft.com/3dmanufacturing/trianglesets/2021/07"),
};

struct Unit {
    std::string_view name;
    double mm;
};
constexpr std::array units = {Unit{"micron", 0.001}, Unit{"millimeter", 1}, Unit{"centimeter", 10},
                              Unit{"inch", 25.4},    Unit{"foot", 304.8},   Unit{"meter", 1000}};

constexpr std::array<std::string_view, 5> type_names = {"model", "solidsupport", "support", "surface", "other"};

// --- Lists in their usual form

/// An element without content whose three attributes come in this order: what stands before each of their values.
using PlainForm = std::array<std::string_view, 3>;
constexpr PlainForm plain_vertex = {"<vertex x=\"", "\" y=\"", "\" z=\""};
constexpr PlainForm plain_triangle = {"<triangle v1=\"", "\" v2=\"", "\" v3=\""};

/// Skips white space and counts its line ends. Stops at a CR without LF, which is a line end too.
const char* skip_lines(const char* p, const char* end, std::uint64_t& lines) {
    while (p != end && (*p == ' ' || *p == '\n' || *p == '\t' || (*p == '\r' && p + 1 != end && p[1] == '\n'))) {
        lines += static_cast<std::uint64_t>(*p++ == '\n');
    }
    return p;
}

/// Reads the values of the element at `p` and returns where it ends; null if it has another form or is cut off. It holds no
/// line end: between values the form has none, and a value with one, or with markup, is no number.
const char* read_element(const char* p, const char* end, const PlainForm& form, std::array<std::string_view, 3>& values) {
    const auto left = [&p, end] { return std::string_view(p, static_cast<std::size_t>(end - p)); };
    for (std::size_t i = 0; i < form.size(); ++i) {
        if (!left().starts_with(form[i])) {
            return nullptr;
        }
        p += form[i].size();
        std::string_view& value = values[i];
        value = left().substr(0, left().find('"'));
        if (value.empty() || is_space(value.front()) || is_space(value.back())) {
            return nullptr;
        }
        p += value.size();
    }
    for (const std::string_view last : {"\"/>", "\" />"}) {
        if (left().starts_with(last)) {
            return p + last.size();
        }
    }
    return nullptr;
}

class PartReader : public PackageReader {
public:
    PartReader(Model& model, Part part) : PackageReader(model, model.parts[part]), part_(part) {}

    double mm_per_unit() const noexcept { return mm_per_unit_; }

private:
    /// Elements of the core namespace that are read, all else is passed over.
    struct Element {
        std::string_view path;
        void (PartReader::*begin)(const XmlAttributes&);
    };

    static const std::array<Element, 14> elements;
    static constexpr std::string_view object_path = "/model/resources/object";
    static constexpr std::string_view mesh_path = "/model/resources/object/mesh";
    static constexpr std::string_view vertices_path = "/model/resources/object/mesh/vertices";
    static constexpr std::string_view triangles_path = "/model/resources/object/mesh/triangles";
    static constexpr std::string_view metadata_path = "/model/resources/object/metadatagroup/metadata";

    void begin_element(const XmlName& name, const XmlAttributes& attributes) override {
        if (passed_over_ > 0) {
            ++passed_over_;
            return;
        }
        draft_ = draft_ || (path_.empty() && name.space == draft_of_2013);
        const std::size_t length = path_.size();
        path_.append(1, '/').append(name.local);
        const auto* const element =
            std::find_if(elements.begin(), elements.end(), [&](const Element& row) { return row.path == path_; });
        if (element == elements.end() || name.space != (draft_ ? draft_of_2013 : core)) {
            path_.resize(length);
            pass_over(name);
            return;
        }
        (this->*element->begin)(attributes);
    }

    void end_element(const XmlName&) override {
        if (passed_over_ > 0) {
            --passed_over_;
            return;
        }
        if (path_ == metadata_path) {
            end_metadata();
        }
        path_.resize(path_.rfind('/'));
        plain_list_ = plain_list_ && in_list();
        parsed_ = in_list() ? event_end() : parsed_;
    }

    /// An element that is not read. Extensions put shapes of their own into objects, which is worth a warning.
    void pass_over(const XmlName& name) {
        if (path_.empty()) {
            fail("expected a 'model' of the namespace " + std::string(core) + ", found " + in_quotes(name.local) +
                 (name.space.empty() ? std::string(" of none") : " of " + in_quotes(name.space)));
        }
        passed_over_ = 1;
        constexpr std::size_t most_warnings = 8;
        const bool shapes = (path_ == object_path || path_ == mesh_path) && name.space != (draft_ ? draft_of_2013 : core);
        if (shapes && object().foreign.empty()) {
            object().foreign = in_quotes(name.local) + " of the extension " + in_quotes(name.space);
            keep(2 * object().foreign.size());
        }
        if (shapes && warned_of_.size() < most_warnings &&
            std::find(warned_of_.begin(), warned_of_.end(), name.space) == warned_of_.end()) {
            warned_of_.emplace_back(name.space);
            warn("ignored " + in_quotes(name.local) + " in an object, of the extension " + in_quotes(name.space));
        }
    }

    // --- The model element

    void begin_model(const XmlAttributes& attributes) {
        if (draft_) {
            warn("a model of the draft of 2013, read as 3MF");
        }
        check_required(attributes.find("requiredextensions").value_or(""));
        check_required(attributes.find(XmlName{compatibility, "MustUnderstand"}).value_or(""));
        const std::string_view name = attributes.find("unit").value_or("millimeter");
        const auto* const unit =
            std::find_if(units.begin(), units.end(), [name](const Unit& known) { return known.name == name; });
        if (unit == units.end()) {
            fail("unknown unit " + in_quotes(name));
        }
        mm_per_unit_ = unit->mm;
    }

    void check_required(std::string_view prefixes) {
        const char* const end = prefixes.data() + prefixes.size();
        for (const char* p = skip_space(prefixes.data(), end); p != end; p = skip_space(p, end)) {
            const char* const word_end = skip_word(p, end);
            const std::string_view prefix(p, static_cast<std::size_t>(word_end - p));
            p = word_end;
            const std::optional<std::string_view> space = namespace_of(prefix);
            if (!space) {
                fail("requires the extension " + in_quotes(prefix) + ", a prefix that it does not declare");
            }
            if (std::find(supported_extensions.begin(), supported_extensions.end(), *space) == supported_extensions.end()) {
                fail("requires the extension " + in_quotes(prefix) + ", " + in_quotes(*space) + ", which is not supported");
            }
        }
    }

    // --- Objects

    void begin_object(const XmlAttributes& attributes) {
        const std::uint32_t id = resource_id(attributes, "id");
        const std::string_view type = attributes.find("type").value_or("model");
        if (std::find(type_names.begin(), type_names.end(), type) == type_names.end()) {
            fail("unknown object type " + in_quotes(type));
        }
        constexpr std::uint64_t index_entry_bytes = 64;
        keep(2 * sizeof(Object) + index_entry_bytes);
        if (!model_.object_index.emplace(Model::key(part_, id), static_cast<std::uint32_t>(model_.objects.size())).second) {
            fail("a second object with id " + std::to_string(id));
        }
        model_.objects.push_back({.id = id,
                                  .is_other = type == "other",
                                  .vertices = ChunkList<Vertex>(model_.memory),
                                  .triangles = ChunkList<Triangle>(model_.memory)});
        if (type == "support") {
            model_.label_of(object()).role = PartRole::support;
        }
        const std::string_view name = attributes.find("name").value_or("");
        if (!name.empty()) {
            keep(2 * (sizeof(Label) + name.size()));
            model_.label_of(object()).name = printable(std::string(name));
        }
    }

    void begin_metadata(const XmlAttributes& attributes) {
        const std::string_view name = attributes.find("name").value_or("");
        metadata_role_ = name.starts_with("cura:") ? role_of(name).value_or(PartRole::solid) : PartRole::solid;
        metadata_text_.clear();
    }

    void end_metadata() {
        const std::string value = lower_case(metadata_text_);
        if (value == "true" || value == "1") {
            keep(2 * sizeof(Label));
            model_.label_of(object()).role = metadata_role_;
        }
        metadata_role_ = PartRole::solid;
    }

    void begin_mesh(const XmlAttributes&) {
        if (object().vertices.size() > 0 || !object().components.empty()) {
            fail("a mesh in an object that has a mesh or components already");
        }
    }

    /// A vertex or a triangle.
    void begin_listed(const XmlAttributes& attributes) {
        using Names = std::array<std::string_view, 3>;
        const bool is_vertex = path_.starts_with(vertices_path);
        Names values = is_vertex ? Names{"x", "y", "z"} : Names{"v1", "v2", "v3"};
        for (std::string_view& name : values) {
            const std::optional<std::string_view> value = attributes.find(name);
            if (!value) {
                fail((is_vertex ? "a vertex without " : "a triangle without ") + in_quotes(name));
            }
            name = *value;
        }
        if (is_vertex ? add_vertex(values) : add_triangle(values)) {
            return;
        }
        for (const std::string_view value : values) {
            is_vertex ? check_coordinate(value) : check_index(value);
        }
        keep(is_vertex ? object().vertices.next_bytes() : object().triangles.next_bytes());
    }

    void check_coordinate(std::string_view value) {
        double number = 0;
        if (const NumberText got = number_in(value, number); got != NumberText::read) {
            fail(coordinate_problem(got, "number", in_quotes(value)));
        }
    }

    void check_index(std::string_view value) {
        std::uint32_t index = 0;
        if (!integer_in(value, index)) {
            fail("malformed vertex index " + in_quotes(value));
        } else if (index >= object().vertices.size()) {
            fail("vertex index " + std::to_string(index) + " of a mesh with " + std::to_string(object().vertices.size()) +
                 " vertices");
        }
    }

    /// False: they are no coordinates, or memory does not suffice.
    bool add_vertex(const std::array<std::string_view, 3>& values) {
        Vertex vertex{};
        ChunkList<Vertex>& vertices = object().vertices;
        const bool good = number_in(values[0], vertex.x) == NumberText::read &&
                          number_in(values[1], vertex.y) == NumberText::read &&
                          number_in(values[2], vertex.z) == NumberText::read && may_keep(vertices.next_bytes());
        if (good) {
            vertices.push_back(vertex);
        }
        return good;
    }

    /// False: one of them is no vertex, or memory does not suffice.
    bool add_triangle(const std::array<std::string_view, 3>& values) {
        Triangle triangle{};
        ChunkList<Triangle>& triangles = object().triangles;
        bool good = true;
        for (std::size_t corner = 0; corner < 3; ++corner) {
            good = good && integer_in(values[corner], triangle[corner]) && triangle[corner] < object().vertices.size();
        }
        good = good && may_keep(triangles.next_bytes());
        if (good) {
            triangles.push_back(triangle);
        }
        return good;
    }

    std::uint32_t resource_id(const XmlAttributes& attributes, std::string_view name) {
        constexpr std::uint32_t largest = std::numeric_limits<std::int32_t>::max();
        const std::optional<std::string_view> text = attributes.find(name);
        std::uint32_t id = 0;
        if (!text) {
            fail("expected an " + in_quotes(name));
        }
        if (!integer_in(*text, id) || (id == 0 && !draft_) || id > largest) {  // the draft's ids begin at 0
            fail("malformed " + std::string(name) + " " + in_quotes(*text));
        }
        return id;
    }

    // --- Components and items

    void begin_component(const XmlAttributes& attributes) {
        if (object().vertices.size() > 0) {
            fail("components in an object that has a mesh already");
        }
        const Reference component = reference(attributes);
        object().components.push_back(component);
    }

    void begin_item(const XmlAttributes& attributes) {
        if (part_ != 0) {
            return;  // only the root part's build counts
        }
        const Reference item = reference(attributes);
        // Not in the standard; a slicer writes it for items beside the build plate.
        if (attributes.find("printable") == "0") {
            warn("ignored an item of the build that is marked as not printable");
            ++model_.unprintable_items;
            return;
        }
        model_.items.push_back(item);
    }

    Reference reference(const XmlAttributes& attributes) {
        Reference reference{.part = part_, .id = resource_id(attributes, "objectid"), .place = {part_, event_line()}};
        keep(2 * sizeof(Reference));
        if (const std::string_view unbound = attributes.unbound("path"); !unbound.empty()) {
            fail("refers to a part by " + in_quotes(unbound) + ", whose prefix is not declared");
        }
        if (const std::optional<std::string_view> path = attributes.find(XmlName{production, "path"})) {
            set_part(*path, reference);
        }
        if (const std::optional<std::string_view> numbers = attributes.find("transform")) {
            set_transform(*numbers, reference);
        }
        return reference;
    }

    void set_part(std::string_view path, Reference& reference) {
        const std::optional<std::string> name = path_within(path);
        if (part_ != 0) {
            fail("refers to another part, which only the root part may");
        } else if (!name) {
            fail("refers to a part outside the package: " + in_quotes(path));
        }
        constexpr std::uint64_t index_entry_bytes = 128;
        keep(index_entry_bytes + 2 * name->size());
        reference.part = model_.part_of(*name);
    }

    /// 3MF multiplies row vectors from the left, and lists the matrix by rows: "m00 m01 m02 m10 ... m32", m30 and so on the
    /// translation.
    void set_transform(std::string_view numbers, Reference& reference) {
        const char* const end = numbers.data() + numbers.size();
        const char* p = skip_space(numbers.data(), end);
        std::array<double, 12>& m = reference.transform.m;
        for (std::size_t row = 0; row < 4; ++row) {
            for (std::size_t column = 0; column < 3; ++column) {
                if (p == end || read_number(p, end, m[4 * column + row]) != NumberText::read) {
                    fail("a transform that is not twelve finite numbers: " + in_quotes(numbers));
                }
                p = skip_space(p, end);
            }
        }
        const double scale = determinant(m);
        if (p != end || !std::isfinite(scale) || scale == 0) {
            fail(p != end ? "a transform of more than twelve numbers: " + in_quotes(numbers)
                          : "a transform that flattens what it places: " + in_quotes(numbers));
        }
        reference.mirrors = scale < 0;
    }

    void text(std::string_view piece) override {
        metadata_text_ += metadata_role_ != PartRole::solid && metadata_text_.size() < 16 ? piece.substr(0, 16) : "";
    }

    /// Names of elements without a prefix are read without the XML parser.
    void begin_list(const XmlAttributes&) {
        parsed_ = event_end();
        plain_list_ = namespace_of("") == (draft_ ? draft_of_2013 : core);
    }
    void begin_nothing(const XmlAttributes&) {}

    bool in_list() const noexcept { return passed_over_ == 0 && (path_ == vertices_path || path_ == triangles_path); }

    // --- Lists

    bool feed_part(std::string_view piece) override {
        while (!piece.empty()) {
            if (plain_list_ && parsed_ == fed_) {
                std::uint64_t lines = 0;
                const std::size_t plain = read_plain_elements(piece, lines);
                skip(piece.substr(0, plain), lines);
                parsed_ = fed_ += plain;
                piece.remove_prefix(plain);
                plain_list_ = piece.empty();  // else what follows is not of that form
            }
            const std::string_view head = piece.substr(0, feed_length(piece));
            if (!feed(head)) {
                return false;
            }
            fed_ += head.size();
            piece.remove_prefix(head.size());
        }
        return true;
    }

    /// How much the parser is given at once: up to where an element of a list may begin.
    static std::size_t feed_length(std::string_view piece) noexcept {
        for (std::size_t at = piece.find('<'); at != std::string_view::npos; at = piece.find('<', at + 1)) {
            if (piece.substr(at).starts_with("<vertices") || piece.substr(at).starts_with("<triangles")) {
                return std::min(piece.size(), piece.find('>', at)) + 1;
            }
        }
        return piece.size();
    }

    /// Returns the bytes of the elements that were read, and adds their lines. Anything unusual is left to the XML parser,
    /// which reports errors.
    std::size_t read_plain_elements(std::string_view piece, std::uint64_t& lines) {
        const char* const end = piece.data() + piece.size();
        const char* done = piece.data();
        const bool vertices = path_ == vertices_path;
        std::array<std::string_view, 3> values;
        for (;;) {
            std::uint64_t line_ends = 0;
            const char* const p =
                read_element(skip_lines(done, end, line_ends), end, vertices ? plain_vertex : plain_triangle, values);
            if (p == nullptr || !(vertices ? add_vertex(values) : add_triangle(values))) {
                return static_cast<std::size_t>(done - piece.data());
            }
            lines += line_ends;
            done = p;
        }
    }

    Object& object() { return model_.objects.back(); }

    Part part_;
    std::string path_;          // of the open element
    bool draft_ = false;        // its elements are of the draft of 2013
    PartRole metadata_role_{};  // what the metadata make of the object where their text is true
    std::string metadata_text_;
    std::uint64_t passed_over_ = 0;  // depth within an element that is
    bool plain_list_ = false;        // in a list whose elements so far were of the usual form
    std::uint64_t fed_ = 0;          // bytes, those skipped included
    std::uint64_t parsed_ = 0;       // where the last tag ended after which an element of a list may come
    double mm_per_unit_ = 1;
    std::vector<std::string> warned_of_;  // namespaces whose geometry is passed over
};

const std::array<PartReader::Element, 14> PartReader::elements = {{
    {"/model", &PartReader::begin_model},
    {"/model/resources", &PartReader::begin_nothing},
    {object_path, &PartReader::begin_object},
    {"/model/resources/object/metadatagroup", &PartReader::begin_nothing},
    {metadata_path, &PartReader::begin_metadata},
    {mesh_path, &PartReader::begin_mesh},
    {vertices_path, &PartReader::begin_list},
    {"/model/resources/object/mesh/vertices/vertex", &PartReader::begin_listed},
    {triangles_path, &PartReader::begin_list},
    {"/model/resources/object/mesh/triangles/triangle", &PartReader::begin_listed},
    {"/model/resources/object/components", &PartReader::begin_nothing},
    {"/model/resources/object/components/component", &PartReader::begin_component},
    {"/model/build", &PartReader::begin_nothing},
    {"/model/build/item", &PartReader::begin_item},
}};

}  // namespace

void read_part(ZipArchive& package, Model& model, Part part) {
    PartReader reader(model, part);
    reader.read(package);
    if (part == 0) {
        model.mm_per_unit = reader.mm_per_unit();
    } else if (reader.mm_per_unit() != model.mm_per_unit) {
        package.refuse(model.parts[part], "has another unit than the root part");
    }
}

}  // namespace lamella::three_mf
