// A 3MF model before anything is placed: objects, which are meshes or components, and the build; and how XML parts of a
// package become one.
#pragma once

#include <array>
#include <tuple>
#include <unordered_map>

#include "io/read/chunk_list.hpp"
#include "io/read/three_mf/zip_archive.hpp"
#include "io/read/transforms.hpp"
#include "io/xml/xml.hpp"
#include "lamella/mesh.hpp"

namespace lamella::three_mf {

/// Index of a model part; 0 is the root.
using Part = std::uint32_t;
/// The part of objects that are volumes of others, which are in none.
inline constexpr Part part_of_volumes = ~Part{0};

struct Place {
    Part part = 0;
    std::uint64_t line = 0;
};

/// Name and role of an object, or of one use of it, by the file.
struct Label {
    std::string name;
    PartRole role = PartRole::solid;
};

/// The role that a slicer's word stands for, as "NegativeVolume", "negative_part" or "cura:infill_mesh".
std::optional<PartRole> role_of(std::string_view word) noexcept;

/// An object put somewhere, as a component of another or as an item of the build.
struct Reference {
    Part part = 0;  ///< that defines the object
    std::uint32_t id = 0;
    Transform transform{};
    bool mirrors = false;  ///< the transform does, so that triangles face inwards
    Place place{};         ///< of the reference itself, for messages
    std::uint32_t label = 0;
};

struct Vertex {
    double x, y, z;
};
using Triangle = std::array<std::uint32_t, 3>;

struct Object {
    std::uint32_t id = 0;
    bool is_other = false;  ///< of a type that is not to be built
    ChunkList<Vertex> vertices;
    ChunkList<Triangle> triangles;
    std::vector<Reference> components{};
    std::uint32_t label = 0;  ///< into Model::labels
    std::string foreign{};    ///< the first shape in it that is not read: "'a' of the extension 'b'"
};

struct Model {
    explicit Model(const FileSource& file) : budget(file), memory(file.memory()) {}

    MemoryBudget budget;  ///< of what is kept
    const Memory* memory;
    std::vector<std::string> parts;                    ///< names; the root is the first
    std::unordered_map<std::string, Part> part_index;  ///< into `parts`
    double mm_per_unit = 1;
    std::vector<Object> objects;
    std::unordered_map<std::uint64_t, std::uint32_t> object_index;  ///< into `objects`, by key()
    std::vector<Reference> items;                                   ///< of the build
    std::size_t unprintable_items = 0;                              ///< that it has beside these
    std::vector<Label> labels{1};                                   ///< the first says nothing
    std::vector<std::string> warnings;                              ///< without the file's name

    /// The number of the part of that name, which is added if it is new.
    Part part_of(const std::string& name);

    std::uint32_t add_label(Label label) {
        labels.push_back(std::move(label));
        return static_cast<std::uint32_t>(labels.size() - 1);
    }
    void warn(const std::string& part, std::uint64_t line, const std::string& what) {
        warnings.push_back("part '" + part + "', line " + std::to_string(line) + ": " + what);
    }
    Label& label_of(Object& object) {
        object.label = object.label == 0 ? add_label({}) : object.label;
        return labels[object.label];
    }

    static std::uint64_t key(Part part, std::uint32_t id) noexcept { return std::uint64_t{part} << 32 | id; }
};

// --- Reading it

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

/// Labels objects and components by what PrusaSlicer (Metadata/Slic3r_PE_model.config: ranges of an object's triangles, each
/// of which becomes an object) or BambuStudio and OrcaSlicer (Metadata/model_settings.config: components) keep beside the
/// model. An unknown type is solid, as it is for them, with a warning. Throws Refused: malformed XML, ranges that are not an
/// object's triangles.
void apply_settings(ZipArchive& package, Model& model);

/// Reads a part of a package into a model.
class PackageReader : public XmlReader {
public:
    PackageReader(Model& model, std::string part) : model_(model), name_(std::move(part)) {}

    /// Throws Refused: what the archive refuses, and what is wrong in the part.
    void read(ZipArchive& package);

protected:
    virtual bool feed_part(std::string_view piece) { return feed(piece); }

    /// Counts what is kept of the part. Throws Refused.
    void keep(std::uint64_t bytes) { model_.budget.take(bytes, 1); }
    bool may_keep(std::uint64_t bytes) noexcept { return bytes == 0 || model_.budget.try_take(bytes, 1); }
    void warn(const std::string& what) { model_.warn(printable(name_), event_line(), what); }

    Model& model_;

private:
    std::string name_;
};

/// Adds the part `part` of `model` to it, and to its list of parts those that the root refers to. Throws Refused.
void read_part(ZipArchive& package, Model& model, Part part);

// --- From the objects and the build to one mesh

/// A mesh object where the build wants it.
struct Instance {
    std::uint32_t object = 0;  ///< index
    Transform transform{};
    bool mirrored = false;            ///< its triangles are reversed, so that they face outwards again
    std::uint32_t label = 0;          ///< the innermost that has a name
    PartRole role = PartRole::solid;  ///< of the outermost that is not solid
    std::uint32_t item = 0;           ///< index of the outermost object, where roles count
    bool is_beside = false;           ///< its triangles come after those of the mesh

    auto key() const noexcept { return std::tuple(is_beside, item, object, label, role); }
    /// Its triangles are part of the solid, or `all_roles` says that they are kept beside it.
    bool is_kept(bool all_roles) const noexcept {
        return role == PartRole::solid || (all_roles && role <= PartRole::modifier);
    }
};

/// All instances of the build whose triangles are kept, the solid ones first, and `parts`: those of one object and name are
/// one. Nested components can make more instances than any machine can hold: they are refused where they and their mesh
/// would take more than the file's memory limit. Types and roles that are not kept are left out, with a warning added to the
/// model's. Throws Refused.
void list_instances(Model& model, const FileSource& file, std::vector<Instance>& instances, std::vector<MeshPart>& parts);

/// The mesh of all instances. The model's meshes are released as they are copied.
void place(Model& model, const std::vector<Instance>& instances, const FileSource& file, MeshFile& mesh);

}  // namespace lamella::three_mf
