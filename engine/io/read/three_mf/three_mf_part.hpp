// XML parts of a 3MF package as they stream by.
#pragma once

#include "io/read/three_mf/three_mf_model.hpp"
#include "io/xml/xml.hpp"

namespace lamella::three_mf {

/// The number that `text` is, with white space around it or none.
inline NumberText number_in(std::string_view text, double& value) {
    const char* const end = text.data() + text.size();
    const char* p = skip_space(text.data(), end);
    if (p == end) {
        return NumberText::malformed;
    }
    const NumberText answer = read_number(p, end, value);
    return answer != NumberText::read || skip_space(p, end) == end ? answer : NumberText::malformed;
}

inline bool integer_in(std::string_view text, std::uint32_t& value) {
    const char* const end = text.data() + text.size();
    const std::from_chars_result got = std::from_chars(skip_space(text.data(), end), end, value);
    return got.ec == std::errc() && skip_space(got.ptr, end) == end;
}

/// The name of a part by how another part refers to it, without the leading slash; nothing if it leaves the package.
std::optional<std::string> part_name(std::string_view path);

/// Labels objects and components by what PrusaSlicer (Metadata/Slic3r_PE_model.config: ranges of an object's triangles, each
/// of which becomes an object) or BambuStudio and OrcaSlicer (Metadata/model_settings.config: components) keep beside the
/// model. An unknown type is solid, as it is for them, with a warning. Throws Refused: malformed XML, ranges that are not an
/// object's triangles.
void apply_settings(ZipArchive& package, Model& model, MemoryBudget& budget, const Memory* memory);

/// Reads a part of a package into a model.
class PackageReader : public XmlReader {
public:
    PackageReader(Model& model, std::string part, MemoryBudget& budget, const Memory* memory)
        : model_(model), budget_(budget), memory_(memory), name_(std::move(part)) {}

    /// Throws Refused: what the archive refuses, and what is wrong in the part.
    void read(ZipArchive& package);

protected:
    virtual bool feed_part(std::string_view piece) { return feed(piece); }

    /// Counts what is kept of the part, or fails.
    void keep(std::uint64_t bytes);
    void warn(const std::string& what) { model_.warn(printable(name_), event_line(), what); }

    Model& model_;
    MemoryBudget& budget_;
    const Memory* memory_;

private:
    std::string name_;
    ErrorCode code_ = ErrorCode::malformed_mesh;  // of the failure
};

/// Adds the part `part` of `model` to it, and to its list of parts those that the root refers to.
class PartReader : public PackageReader {
public:
    PartReader(Model& model, Part part, MemoryBudget& budget, const Memory* memory);

    double mm_per_unit() const noexcept { return mm_per_unit_; }

    /// Where in the document: only what a state below lists as its child is read, all else is passed over.
    enum class State : std::uint8_t {
        document,
        model,
        resources,
        object,
        mesh,
        vertices,
        vertex,
        triangles,
        triangle,
        components,
        component,
        metadata_group,
        metadata,
        build,
        item,
    };

private:
    struct Element;
    static const Element elements[];

    void begin_element(const XmlName& name, const XmlAttributes& attributes) override;
    void end_element(const XmlName& name) override;
    void text(std::string_view piece) override {
        metadata_text_ += metadata_role_ != PartRole::solid && metadata_text_.size() < 16 ? piece.substr(0, 16) : "";
    }

    void begin_model(const XmlAttributes& attributes);
    void begin_object(const XmlAttributes& attributes);
    void begin_mesh(const XmlAttributes& attributes);
    void begin_vertex(const XmlAttributes& attributes);
    void begin_triangle(const XmlAttributes& attributes);
    void begin_component(const XmlAttributes& attributes);
    void begin_item(const XmlAttributes& attributes);
    void begin_metadata(const XmlAttributes& attributes);
    void end_metadata();
    void begin_list(const XmlAttributes&) { parsed_ = event_end(); }
    void begin_nothing(const XmlAttributes&) {}

    bool in_list() const noexcept { return passed_over_ == 0 && (state_ == State::vertices || state_ == State::triangles); }
    /// Reads vertices and triangles of the usual form without the XML parser.
    bool feed_part(std::string_view piece) override;
    std::size_t feed_length(std::string_view piece) const noexcept;
    std::size_t read_plain_elements(std::string_view piece, std::uint64_t& lines);
    bool add_plain_vertex(const std::array<std::string_view, 3>& values);
    bool add_plain_triangle(const std::array<std::string_view, 3>& values);

    void check_required(std::string_view prefixes);
    void set_unit(std::string_view unit);
    void pass_over(const XmlName& name);
    Reference reference(const XmlAttributes& attributes);
    void set_part(std::string_view path, Reference& reference);
    void set_transform(std::string_view numbers, Reference& reference);
    double coordinate(const XmlAttributes& attributes, std::string_view name);
    std::uint32_t vertex_index(const XmlAttributes& attributes, std::string_view name);
    std::uint32_t resource_id(const XmlAttributes& attributes, std::string_view name);
    Object& object() { return model_.objects.back(); }

    Part part_;
    State state_ = State::document;
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

}  // namespace lamella::three_mf
