// Settings of objects that slicers keep beside a 3MF model.

#include <deque>
#include <set>

#include "io/read/three_mf/three_mf_model.hpp"

namespace lamella::three_mf {

namespace {

/// A range of an object's triangles.
struct Volume {
    std::uint32_t first = 0;
    std::uint32_t last = 0;
    Label label;
};

/// Reads either file, and does to each object what it says when it has been read:
///
///     <config> <object id=""> <metadata key="name" value=""/>
///                             <volume firstid="" lastid=""> <metadata key="volume_type" value=""/> ...
///                             <part id="" subtype="">       <metadata key="name" value=""/> ...
class SettingsReader : public PackageReader {
public:
    using PackageReader::PackageReader;

private:
    void begin_element(const XmlName& name, const XmlAttributes& attributes) override {
        ++depth_;
        if (depth_ == 1 && name.local != "config") {
            fail("expected 'config', found " + in_quotes(name.local));
        } else if (depth_ == 2) {
            in_object_ = name.local == "object";
            id_ = in_object_ ? number(attributes, "id") : 0;
            label_ = {};
            ranges_.clear();
            components_.clear();
        } else if (depth_ == 3 && in_object_) {
            const bool is_volume = name.local == "volume" || name.local == "part";
            volume_label_ = is_volume ? begin_volume(name.local == "volume", attributes) : nullptr;
        }
        Label* const label = depth_ == 3 ? &label_ : depth_ == 4 ? volume_label_ : nullptr;
        if (in_object_ && name.local == "metadata" && label != nullptr) {
            set(*label, attributes);
        }
    }
    void end_element(const XmlName&) override {
        if (depth_-- == 2 && in_object_) {
            apply();
        }
    }

    Label* begin_volume(bool is_range, const XmlAttributes& attributes) {
        Volume volume;
        volume.first = number(attributes, is_range ? "firstid" : "id");
        volume.last = is_range ? number(attributes, "lastid") : 0;
        keep(2 * (sizeof(Object) + sizeof(Reference)) + 1024);  // and what maps and lists take
        if (is_range) {
            return &ranges_.emplace_back(std::move(volume)).label;
        }
        Label& label = components_[volume.first].emplace_back();
        set_role(label, attributes.find("subtype").value_or("normal_part"));
        return &label;
    }

    void set(Label& label, const XmlAttributes& attributes) {
        const std::string_view key = attributes.find("key").value_or("");
        const std::string_view value = attributes.find("value").value_or("");
        if (key == "name") {
            keep(4 * value.size());
            label.name = printable(std::string(value));
        } else if (key == "volume_type") {
            set_role(label, value);
        } else if (key == "modifier" && value == "1") {  // of versions without types
            label.role = PartRole::modifier;
        }
    }

    void set_role(Label& label, std::string_view name) {
        const std::optional<PartRole> role = role_of(name);
        label.role = role.value_or(PartRole::solid);
        if (!role) {
            warn("unknown type of volume " + in_quotes(name) + ", read as solid");
        }
    }

    void apply() {
        const auto found = model_.object_index.find(Model::key(0, id_));
        if (found == model_.object_index.end()) {
            return warn("settings of object " + std::to_string(id_) + ", which the model has not");
        }
        Object& object = model_.objects[found->second];
        if (!label_.name.empty()) {
            model_.label_of(object).name = label_.name;
        }
        if (!components_.empty()) {
            label_components(object);
        }
        if (!ranges_.empty()) {
            check_ranges(object);
            cut(found->second);
        }
    }

    /// Labels an object that is one volume.
    void relabel(Object& object, const Label& volume) {
        Label& label = model_.label_of(object);
        label = {volume.name.empty() ? label.name : volume.name, volume.role};
    }

    /// By their ids. One mesh may be several components: each takes the next volume of that id.
    void label_components(Object& object) {
        if (object.components.empty()) {
            return relabel(object, components_.begin()->second.front());
        }
        std::set<std::uint32_t> used;
        for (Reference& component : object.components) {
            if (const auto own = components_.find(component.id); own != components_.end()) {
                component.label = model_.add_label(own->second.front());
                used.insert(component.id);
                if (own->second.size() > 1) {
                    own->second.pop_front();
                }
            }
        }
        for (const auto& [id, labels] : components_) {
            if (!used.contains(id)) {
                warn("settings of part " + std::to_string(id) + ", which object " + std::to_string(object.id) + " has not");
            }
        }
    }

    /// Fails unless they are all triangles of the object, each once. Gives them names.
    void check_ranges(const Object& object) {
        const std::string name = "object " + std::to_string(object.id);
        for (std::size_t i = 0; i < ranges_.size(); ++i) {
            if (ranges_[i].label.name.empty() && ranges_.size() > 1) {
                ranges_[i].label.name = (label_.name.empty() ? name : label_.name) + ", volume " + std::to_string(i + 1);
            }
        }
        std::sort(ranges_.begin(), ranges_.end(), [](const Volume& a, const Volume& b) { return a.first < b.first; });
        std::uint64_t next = 0;
        for (const Volume& range : ranges_) {
            if (range.first != next || range.last < range.first || range.last >= object.triangles.size()) {
                fail("a volume of triangles " + std::to_string(range.first) + " to " + std::to_string(range.last) + " of " +
                     name + ", which has " + std::to_string(object.triangles.size()) + " and whose next is " +
                     std::to_string(next));
            }
            next = std::uint64_t{range.last} + 1;
        }
        if (next != object.triangles.size()) {
            fail("triangle " + std::to_string(next) + " of " + name + " is in none of its volumes");
        }
    }

    void cut(std::uint32_t index) {
        if (ranges_.size() == 1) {
            return relabel(model_.objects[index], ranges_.front().label);
        }
        const Array<Vertex> vertices = model_.objects[index].vertices.joined();
        const Array<Triangle> triangles = model_.objects[index].triangles.joined();
        for (Volume& range : ranges_) {
            add_volume(index, vertices, triangles.span().subspan(range.first, std::size_t{range.last} - range.first + 1),
                       std::move(range.label));
        }
    }

    /// A new object of those triangles and the range of vertices that they use, as a component of the object of that index.
    void add_volume(std::uint32_t index, const Array<Vertex>& vertices, std::span<const Triangle> triangles, Label label) {
        std::uint32_t low = triangles.front()[0];
        std::uint32_t high = low;
        for (const Triangle& triangle : triangles) {
            low = std::min(low, *std::min_element(triangle.begin(), triangle.end()));
            high = std::max(high, *std::max_element(triangle.begin(), triangle.end()));
        }
        keep(2 * (triangles.size_bytes() + (high - low + std::uint64_t{1}) * sizeof(Vertex)));
        Object volume{
            .id = id_, .vertices = ChunkList<Vertex>(model_.memory), .triangles = ChunkList<Triangle>(model_.memory)};
        for (std::uint32_t vertex = low; vertex <= high; ++vertex) {
            volume.vertices.push_back(vertices[vertex]);
        }
        for (const Triangle& triangle : triangles) {
            volume.triangles.push_back({triangle[0] - low, triangle[1] - low, triangle[2] - low});
        }
        Reference component;
        component.part = part_of_volumes;
        component.id = static_cast<std::uint32_t>(model_.objects.size());
        component.label = model_.add_label(std::move(label));
        model_.object_index.emplace(Model::key(component.part, component.id), component.id);
        model_.objects[index].components.push_back(component);
        model_.objects.push_back(std::move(volume));
    }

    std::uint32_t number(const XmlAttributes& attributes, std::string_view name) const {
        std::uint32_t value = 0;
        const std::optional<std::string_view> text = attributes.find(name);
        if (!text || !integer_in(*text, value)) {
            fail("expected a number as '" + std::string(name) + "', found " + in_quotes(text.value_or("")));
        }
        return value;
    }

    void warn(const std::string& what) {
        if (warnings_++ < 8) {
            PackageReader::warn(what);
        }
    }

    int warnings_ = 0;
    std::uint64_t depth_ = 0;
    bool in_object_ = false;
    std::uint32_t id_ = 0;  // of the object at hand, as what follows
    Label label_;
    std::vector<Volume> ranges_;
    std::map<std::uint32_t, std::deque<Label>> components_;  // by id
    Label* volume_label_ = nullptr;                          // of the volume at hand, if there is one
};

}  // namespace

void apply_settings(ZipArchive& package, Model& model) {
    for (const std::string part : {"Metadata/Slic3r_PE_model.config", "Metadata/model_settings.config"}) {
        if (package.contains(part)) {
            SettingsReader(model, part).read(package);
        }
    }
}

}  // namespace lamella::three_mf
