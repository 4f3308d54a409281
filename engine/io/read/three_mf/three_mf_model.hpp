// A 3MF model before anything is placed: objects, which are meshes or components, and the build.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "io/read/chunk_list.hpp"
#include "io/read/three_mf/zip_archive.hpp"
#include "lamella/error.hpp"
#include "lamella/io/mesh_file.hpp"
#include "lamella/memory.hpp"
#include "lamella/mesh.hpp"

namespace lamella::three_mf {

/// Index of a model part; 0 is the root.
using Part = std::uint32_t;
/// Of objects that are volumes of others; they are in no part.
inline constexpr Part part_of_volumes = ~Part{0};

struct Place {
    Part part = 0;
    std::uint64_t line = 0;
};

/// What a file says of an object, or of one use of it.
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
    Transform transform;
    bool mirrors = false;  ///< the transform does, so that triangles face inwards
    Place place;           ///< of the reference itself, for messages
    std::uint32_t label = 0;
};

struct Vertex {
    double x, y, z;
};
using Triangle = std::array<std::uint32_t, 3>;

struct Object {
    std::uint32_t id = 0;
    bool is_other = false;  ///< of a type that is not to be built
    Place place{};
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
Result<Model> read_model(ZipArchive& package, const FileSource& file);

}  // namespace lamella::three_mf
