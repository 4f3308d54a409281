// A 3MF model before anything is placed: objects, which are meshes or components, and the build.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "io/read/three_mf/chunk_list.hpp"
#include "io/read/three_mf/zip_archive.hpp"
#include "lamella/error.hpp"
#include "lamella/memory.hpp"
#include "lamella/mesh.hpp"

namespace lamella::three_mf {

/// Index of a model part; 0 is the root.
using Part = std::uint32_t;

struct Place {
    Part part = 0;
    std::uint64_t line = 0;
};

/// An object put somewhere, as a component of another or as an item of the build.
struct Reference {
    Part part = 0;  ///< that defines the object
    std::uint32_t id = 0;
    Transform transform;
    bool mirrors = false;  ///< the transform does, so that triangles face inwards
    Place place;           ///< of the reference itself, for messages
};

struct Vertex {
    double x, y, z;
};
using Triangle = std::array<std::uint32_t, 3>;

enum class ObjectType : std::uint8_t { model, solid_support, support, surface, other };

struct Object {
    std::uint32_t id = 0;
    ObjectType type = ObjectType::model;
    Place place;
    ChunkList<Vertex> vertices;
    ChunkList<Triangle> triangles;
    std::vector<Reference> components;
};

struct Model {
    std::vector<std::string> parts;                    ///< names; the root is the first
    std::unordered_map<std::string, Part> part_index;  ///< into `parts`
    double mm_per_unit = 1;
    std::vector<Object> objects;
    std::unordered_map<std::uint64_t, std::uint32_t> object_index;  ///< into `objects`, by key()
    std::vector<Reference> items;                                   ///< of the build
    std::size_t unprintable_items = 0;                              ///< that it has beside these
    std::vector<std::string> warnings;                              ///< without the file's name

    /// The number of the part of that name, which is added if it is new.
    Part part_of(const std::string& name);

    static std::uint64_t key(Part part, std::uint32_t id) noexcept { return std::uint64_t{part} << 32 | id; }
};

/// The model of a package: its root part, found by the package's relationships, and all parts that it refers to. What is
/// kept of them may take `limit_bytes`.
Result<Model> read_model(ZipArchive& package, std::uint64_t limit_bytes, const Memory* memory);

}  // namespace lamella::three_mf
