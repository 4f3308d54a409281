#include "io/read/three_mf/three_mf_model.hpp"

#include "base/words.hpp"
#include "io/read/faces.hpp"

namespace lamella::three_mf {

namespace {

/// Lists instances by going through the components of every item, on a stack of its own: a file may nest a million deep.
/// Forty objects, each of which holds the one before twice, make 2^40 instances. So what they take, and the steps, are
/// counted, and objects that come to no triangles are gone through once.
class Lister {
public:
    Lister(const Model& model, const FileSource& file, std::vector<Instance>& instances)
        : model_(model), file_(file), instances_(instances) {}

    void run() {
        for (const Reference& item : model_.items) {
            meet(item, Instance{.item = of_item});
            while (!open_.empty()) {
                step();
            }
        }
    }

private:
    enum class State : std::uint8_t { closed, open, empty };
    static constexpr std::uint32_t of_item = ~std::uint32_t{0};
    struct Open {
        Instance at;
        std::size_t next_component;
        std::size_t instances_before;
    };

    void step() {
        Open& last = open_.back();
        const std::vector<Reference>& components = model_.objects[last.at.object].components;
        if (last.next_component < components.size()) {
            meet(components[last.next_component++], last.at);
        } else {
            states_[last.at.object] = instances_.size() > last.instances_before ? State::closed : State::empty;
            open_.pop_back();
        }
    }

    /// `outer` is a copy, as the stack may move.
    void meet(const Reference& reference, Instance outer) {
        pace_.spend(step_work);
        const auto found = model_.object_index.find(Model::key(reference.part, reference.id));
        if (found == model_.object_index.end()) {
            refuse(reference, "there is no object " + std::to_string(reference.id) +
                                  (reference.part == reference.place.part ? "" : " in the part that it names"));
        }
        const std::uint32_t index = found->second;
        const Object& object = model_.objects[index];
        const std::string name = "object " + std::to_string(object.id);
        if (object.is_other) {
            refuse(reference, "the build comes to " + name + " of type 'other', which is not to be built");
        } else if (object.triangles.size() == 0 && object.components.empty() && !object.foreign.empty()) {
            refuse(reference, name + " is made of " + object.foreign + ", which is not supported");
        } else if (states_[index] == State::open) {
            refuse(reference, name + " is a component of itself");
        }
        if (states_[index] == State::empty) {
            return;
        }
        must_fit(object);
        const Instance instance = placed(reference, index, outer);
        if (object.triangles.size() > 0) {
            instances_.push_back(instance);
        } else {
            states_[index] = State::open;
            open_.push_back({instance, 0, instances_.size()});
        }
    }

    /// Counts one more instance of the object.
    void must_fit(const Object& object) {
        budget_.take(
            1, sizeof(Instance) + object.vertices.size() * sizeof(Vertex) + object.triangles.size() * sizeof(Triangle));
        vertices_ += object.vertices.size();
        if (vertices_ > std::numeric_limits<std::uint32_t>::max()) {
            file_.refuse(ErrorCode::out_of_memory, "builds more vertices than 32-bit indices can tell apart");
        }
    }

    Instance placed(const Reference& reference, std::uint32_t index, const Instance& outer) const {
        Instance instance{
            index,      outer.transform * reference.transform,     outer.mirrored != reference.mirrors, outer.label,
            outer.role, outer.item == of_item ? index : outer.item};
        for (const std::uint32_t label : {model_.objects[index].label, reference.label}) {
            instance.label = model_.labels[label].name.empty() ? instance.label : label;
        }
        for (const std::uint32_t label : {reference.label, model_.objects[index].label}) {
            instance.role = instance.role == PartRole::solid ? model_.labels[label].role : instance.role;
        }
        return instance;
    }

    [[noreturn]] void refuse(const Reference& reference, const std::string& what) const {
        const Place& place = reference.place;
        refuse_part(file_, ErrorCode::malformed_mesh, model_.parts[place.part], place.line, what);
    }

    const Model& model_;
    const FileSource& file_;
    StopPace pace_ = pace_of(file_.parallel());
    std::vector<State> states_ = std::vector<State>(model_.objects.size());
    std::vector<Instance>& instances_;
    std::vector<Open> open_;
    MemoryBudget budget_{file_};  // of all instances, as if they were placed
    std::uint64_t vertices_ = 0;
};

/// "left out 2 modifiers: 'a', 'b'"
void warn_of_left_out(const std::vector<MeshPart>& parts, PartRole role, Model& model) {
    constexpr std::uint64_t most_named = 8;
    std::uint64_t count = 0;
    std::string names;
    for (const MeshPart& part : parts) {
        if (part.role == role && ++count <= most_named) {
            names += (count > 1 ? ", '" : "'") + part.name.substr(0, 64) + "'";
        }
    }
    if (count > 0) {
        model.warnings.push_back("left out " + counted(count, name_of(role)) + ": " + names +
                                 (count > most_named ? ", ..." : "") +
                                 (role == PartRole::negative ? "; what they take away stays solid" : ""));
    }
}

void list_parts(const Model& model, const FileSource& file, const std::vector<Instance>& instances,
                std::vector<MeshPart>& parts) {
    std::uint64_t next = 0;
    MemoryBudget budget(file);
    for (std::size_t i = 0; i < instances.size(); ++i) {
        const Object& object = model.objects[instances[i].object];
        if (i == 0 || instances[i].key() != instances[i - 1].key()) {
            const std::string& name = model.labels[instances[i].label].name;
            budget.take(1, sizeof(MeshPart) + name.size());
            parts.push_back({name.empty() ? "object " + std::to_string(object.id) : name, instances[i].role,
                             instances[i].is_kept(file.all_roles()) ? next : 0, 0, instances[i].item});
        }
        parts.back().triangle_count += object.triangles.size();
        next += instances[i].is_kept(file.all_roles()) ? object.triangles.size() : 0;
    }
}

void put_vertices(std::span<const Vertex> vertices, const Transform& transform, std::byte* to) {
    if (transform.is_identity()) {
        std::memcpy(to, vertices.data(), vertices.size_bytes());
        return;
    }
    for (const Vertex& v : vertices) {
        const std::array<double, 3> placed = moved(transform, {v.x, v.y, v.z});
        std::memcpy(to, &placed, sizeof placed);
        to += sizeof placed;
    }
}

void put_triangles(std::span<const Triangle> triangles, std::uint32_t first_vertex, bool mirrored, std::uint32_t* to) {
    for (const Triangle& triangle : triangles) {
        *to++ = first_vertex + triangle[0];
        *to++ = first_vertex + triangle[mirrored ? 2 : 1];
        *to++ = first_vertex + triangle[mirrored ? 1 : 2];
    }
}

/// Calls put(chunk, instance, items of the list before) for each chunk and instance, and releases the chunks, so that memory
/// never holds the whole mesh twice.
template <class T, class Put>
void place_chunks(ChunkList<T>& list, std::size_t instances, const Parallel& parallel, Put put) {
    StopPace pace = pace_of(parallel);
    std::uint64_t done = 0;
    for (std::size_t c = 0; c < list.chunk_count(); ++c) {
        const std::span<const T> chunk = list.chunk(c);
        for (std::size_t i = 0; i < instances; ++i) {
            pace.spend(step_work * chunk.size());
            put(chunk, i, done);
        }
        done += chunk.size();
        list.release(c);
    }
}

/// An instance, and where it goes.
struct PlacedInstance {
    const Instance* of;
    std::uint64_t first_vertex;
    std::uint64_t first_triangle;
};

/// Writes the instances of one mesh to `mesh`.
void place_object(Object& object, std::span<const PlacedInstance> instances, const Parallel& parallel, MeshFile& mesh) {
    place_chunks(object.vertices, instances.size(), parallel,
                 [&](std::span<const Vertex> chunk, std::size_t i, std::uint64_t before) {
                     put_vertices(chunk, instances[i].of->transform,
                                  mesh.bytes.data() + (instances[i].first_vertex + before) * sizeof(Vertex));
                 });
    place_chunks(object.triangles, instances.size(), parallel,
                 [&](std::span<const Triangle> chunk, std::size_t i, std::uint64_t before) {
                     put_triangles(chunk, static_cast<std::uint32_t>(instances[i].first_vertex), instances[i].of->mirrored,
                                   mesh.indices.data() + 3 * (instances[i].first_triangle + before));
                 });
}

}  // namespace

void list_instances(Model& model, const FileSource& file, std::vector<Instance>& instances, std::vector<MeshPart>& parts) {
    Lister(model, file, instances).run();
    const bool have_roles = std::any_of(instances.begin(), instances.end(), [](const Instance& instance) {
        return instance.role != PartRole::solid && instance.is_kept(true);
    });
    for (Instance& instance : instances) {
        instance.item = file.all_roles() && have_roles ? instance.item : 0;
        instance.is_beside = file.all_roles() && instance.role != PartRole::solid;
    }
    std::stable_sort(instances.begin(), instances.end(),
                     [](const Instance& a, const Instance& b) { return a.key() < b.key(); });
    list_parts(model, file, instances, parts);
    for (int role = 1; role <= static_cast<int>(PartRole::support); ++role) {
        if (!Instance{.role = static_cast<PartRole>(role)}.is_kept(file.all_roles())) {
            warn_of_left_out(parts, static_cast<PartRole>(role), model);
        }
    }
    std::erase_if(instances, [&file](const Instance& instance) { return !instance.is_kept(file.all_roles()); });
}

void place(Model& model, const std::vector<Instance>& instances, const FileSource& file, MeshFile& mesh) {
    std::vector<PlacedInstance> placed;
    placed.reserve(instances.size());
    std::uint64_t vertices = 0;
    std::uint64_t triangles = 0;
    mesh.triangle_count = 0;
    for (const Instance& instance : instances) {
        placed.push_back({&instance, vertices, triangles});
        vertices += model.objects[instance.object].vertices.size();
        triangles += model.objects[instance.object].triangles.size();
        mesh.triangle_count = instance.role == PartRole::solid ? triangles : mesh.triangle_count;
    }
    MemoryBudget budget(file);  // list_instances() has refused what it does not hold
    allocate_vertices(vertices, Number::f64, budget, file.memory(), mesh);
    mesh.indices = Array<std::uint32_t>(file.memory());
    mesh.indices.resize_discarding(3 * triangles);
    std::stable_sort(placed.begin(), placed.end(), [](const PlacedInstance& a, const PlacedInstance& b) {
        return a.of->object < b.of->object;  // whose mesh is released when all are written
    });
    for (auto first = placed.begin(); first != placed.end();) {
        const auto last = std::find_if(
            first, placed.end(), [first](const PlacedInstance& other) { return other.of->object != first->of->object; });
        place_object(model.objects[first->of->object], {&*first, static_cast<std::size_t>(last - first)}, file.parallel(),
                     mesh);
        first = last;
    }
}

}  // namespace lamella::three_mf
