// A 3MF model before anything is placed: objects, which are meshes or components, and the build.
#pragma once

#include <array>
#include <tuple>
#include <unordered_map>

#include "io/read/chunk_list.hpp"
#include "io/read/three_mf/zip_archive.hpp"
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

/// The model of the package in `file`: its root part, found by the package's relationships, and all parts that it refers to.
/// Throws Refused.
Model read_model(ZipArchive& package, const FileSource& file);

// --- From the objects and the build to one mesh

/// A mesh object where the build wants it.
struct Instance {
    std::uint32_t object = 0;  ///< index
    Transform transform;
    bool mirrored = false;            ///< its triangles are reversed, so that they face outwards again
    std::uint32_t label = 0;          ///< the innermost that has a name
    PartRole role = PartRole::solid;  ///< of the outermost that is not solid

    auto key() const noexcept { return std::tuple(object, label, role); }
};

/// All solid instances of the build, by object, and `parts`: those of one object and name are one. Nested components can
/// make more instances than any machine can hold: they are refused where they and their mesh would take more than
/// the file's memory limit. Types and roles that are no part of the solid are left out, with a warning added to the model's.
/// Throws Refused.
void list_instances(Model& model, const FileSource& file, std::vector<Instance>& instances, std::vector<MeshPart>& parts);

/// The mesh of all instances. The model's meshes are released as they are copied.
void place(Model& model, const std::vector<Instance>& instances, const Memory* memory, const Parallel& parallel,
           MeshFile& mesh);

}  // namespace lamella::three_mf
