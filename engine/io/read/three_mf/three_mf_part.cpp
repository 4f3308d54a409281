#include "io/read/three_mf/three_mf_part.hpp"

#include <limits>

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

double determinant(const std::array<double, 12>& m) {
    return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) + m[2] * (m[4] * m[9] - m[5] * m[8]);
}

}  // namespace

std::optional<std::string> part_name(std::string_view path) {
    path.remove_prefix(path.starts_with('/') ? 1 : 0);
    for (std::size_t begin = 0; begin <= path.size();) {
        const std::size_t end = std::min(path.find('/', begin), path.size());
        const std::string_view segment = path.substr(begin, end - begin);
        if (segment.empty() || segment == "." || segment == ".." || segment.find_first_of("\\:") != std::string_view::npos) {
            return std::nullopt;
        }
        begin = end + 1;
    }
    return std::string(path);
}

/// Row i says what state i + 1 is: which element of the core namespace, in which other.
struct PartReader::Element {
    State parent;
    State state;
    std::string_view name;
    void (PartReader::*begin)(const XmlAttributes&);
};

const PartReader::Element PartReader::elements[] = {
    {State::document, State::model, "model", &PartReader::begin_model},
    {State::model, State::resources, "resources", &PartReader::begin_nothing},
    {State::resources, State::object, "object", &PartReader::begin_object},
    {State::object, State::mesh, "mesh", &PartReader::begin_mesh},
    {State::mesh, State::vertices, "vertices", &PartReader::begin_list},
    {State::vertices, State::vertex, "vertex", &PartReader::begin_vertex},
    {State::mesh, State::triangles, "triangles", &PartReader::begin_list},
    {State::triangles, State::triangle, "triangle", &PartReader::begin_triangle},
    {State::object, State::components, "components", &PartReader::begin_nothing},
    {State::components, State::component, "component", &PartReader::begin_component},
    {State::object, State::metadata_group, "metadatagroup", &PartReader::begin_nothing},
    {State::metadata_group, State::metadata, "metadata", &PartReader::begin_metadata},
    {State::model, State::build, "build", &PartReader::begin_nothing},
    {State::build, State::item, "item", &PartReader::begin_item},
};

PartReader::PartReader(Model& model, Part part, MemoryBudget& budget, const Memory* memory)
    : PackageReader(model, model.parts[part], budget, memory), part_(part) {}

void PartReader::begin_element(const XmlName& name, const XmlAttributes& attributes) {
    if (passed_over_ > 0) {
        ++passed_over_;
        return;
    }
    draft_ = draft_ || (state_ == State::document && name.space == draft_of_2013);
    const auto* const element = std::find_if(std::begin(elements), std::end(elements), [&](const Element& row) {
        return row.parent == state_ && row.name == name.local && name.space == (draft_ ? draft_of_2013 : core);
    });
    if (element == std::end(elements)) {
        pass_over(name);
        return;
    }
    state_ = element->state;
    (this->*element->begin)(attributes);
}

void PartReader::end_element(const XmlName&) {
    if (passed_over_ > 0) {
        --passed_over_;
        return;
    }
    if (state_ == State::metadata) {
        end_metadata();
    }
    state_ = elements[static_cast<std::size_t>(state_) - 1].parent;
    if (in_list()) {
        parsed_ = event_end();
    }
}

/// An element that is not read. Extensions put shapes of their own into objects, which is worth a warning.
void PartReader::pass_over(const XmlName& name) {
    if (state_ == State::document) {
        fail("expected a 'model' of the namespace " + std::string(core) + ", found " + in_quotes(name.local) +
             (name.space.empty() ? std::string(" of none") : " of " + in_quotes(name.space)));
    }
    passed_over_ = 1;
    constexpr std::size_t most_warnings = 8;
    const bool shapes = (state_ == State::object || state_ == State::mesh) && name.space != (draft_ ? draft_of_2013 : core);
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

void PartReader::begin_model(const XmlAttributes& attributes) {
    if (draft_) {
        warn("a model of the draft of 2013, read as 3MF");
    }
    check_required(attributes.find("requiredextensions").value_or(""));
    check_required(attributes.find(XmlName{compatibility, "MustUnderstand"}).value_or(""));
    set_unit(attributes.find("unit").value_or("millimeter"));
}

void PartReader::check_required(std::string_view prefixes) {
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

void PartReader::set_unit(std::string_view name) {
    const auto* const unit =
        std::find_if(units.begin(), units.end(), [name](const Unit& known) { return known.name == name; });
    if (unit == units.end()) {
        fail("unknown unit " + in_quotes(name));
    }
    mm_per_unit_ = unit->mm;
}

// --- Objects

void PartReader::begin_object(const XmlAttributes& attributes) {
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
                              .vertices = ChunkList<Vertex>(memory_),
                              .triangles = ChunkList<Triangle>(memory_)});
    if (type == "support") {
        model_.label_of(object()).role = PartRole::support;
    }
    const std::string_view name = attributes.find("name").value_or("");
    if (!name.empty()) {
        keep(2 * (sizeof(Label) + name.size()));
        model_.label_of(object()).name = printable(std::string(name));
    }
}

void PartReader::begin_metadata(const XmlAttributes& attributes) {
    const std::string_view name = attributes.find("name").value_or("");
    metadata_role_ = name.starts_with("cura:") ? role_of(name).value_or(PartRole::solid) : PartRole::solid;
    metadata_text_.clear();
}

void PartReader::end_metadata() {
    const std::string value = lower_case(metadata_text_);
    if (value == "true" || value == "1") {
        keep(2 * sizeof(Label));
        model_.label_of(object()).role = metadata_role_;
    }
    metadata_role_ = PartRole::solid;
}

void PartReader::begin_mesh(const XmlAttributes&) {
    if (object().vertices.size() > 0 || !object().components.empty()) {
        fail("a mesh in an object that has a mesh or components already");
    }
}

void PartReader::begin_vertex(const XmlAttributes& attributes) {
    const Vertex vertex{coordinate(attributes, "x"), coordinate(attributes, "y"), coordinate(attributes, "z")};
    keep(object().vertices.next_bytes());
    object().vertices.push_back(vertex);
}

void PartReader::begin_triangle(const XmlAttributes& attributes) {
    const Triangle triangle{vertex_index(attributes, "v1"), vertex_index(attributes, "v2"), vertex_index(attributes, "v3")};
    keep(object().triangles.next_bytes());
    object().triangles.push_back(triangle);
}

double PartReader::coordinate(const XmlAttributes& attributes, std::string_view name) {
    const std::optional<std::string_view> text = attributes.find(name);
    if (!text) {
        fail("a vertex without " + in_quotes(name));
    }
    double value = 0;
    if (const NumberText got = number_in(*text, value); got != NumberText::read) {
        fail(coordinate_problem(got, "number", in_quotes(*text)));
    }
    return value;
}

std::uint32_t PartReader::vertex_index(const XmlAttributes& attributes, std::string_view name) {
    const std::optional<std::string_view> text = attributes.find(name);
    std::uint32_t value = 0;
    if (!text) {
        fail("a triangle without " + in_quotes(name));
    } else if (!integer_in(*text, value)) {
        fail("malformed vertex index " + in_quotes(*text));
    } else if (value >= object().vertices.size()) {
        fail("vertex index " + std::to_string(value) + " of a mesh with " + std::to_string(object().vertices.size()) +
             " vertices");
    }
    return value;
}

std::uint32_t PartReader::resource_id(const XmlAttributes& attributes, std::string_view name) {
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

void PartReader::begin_component(const XmlAttributes& attributes) {
    if (object().vertices.size() > 0) {
        fail("components in an object that has a mesh already");
    }
    const Reference component = reference(attributes);
    object().components.push_back(component);
}

void PartReader::begin_item(const XmlAttributes& attributes) {
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

Reference PartReader::reference(const XmlAttributes& attributes) {
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

void PartReader::set_part(std::string_view path, Reference& reference) {
    const std::optional<std::string> name = part_name(path);
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
void PartReader::set_transform(std::string_view numbers, Reference& reference) {
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

}  // namespace lamella::three_mf
