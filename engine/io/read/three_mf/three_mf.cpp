// 3MF: a zip archive of XML parts (3MF core specification and production extension). The parts are streamed: neither an XML
// text nor a tree of it is ever held, only the vertices and triangles that it lists.
#include <limits>

#include "io/read/three_mf/three_mf_model.hpp"

namespace lamella {

namespace three_mf {

namespace {

constexpr std::string_view package_relationships = "_rels/.rels";
constexpr std::string_view content_types = "[Content_Types].xml";

/// Finds the root model part among the relationships of a package.
class RelationshipReader : public PackageReader {
public:
    using PackageReader::PackageReader;

    const std::string& root() const noexcept { return root_; }  ///< empty: none

private:
    void begin_element(const XmlName& name, const XmlAttributes& attributes) override {
        constexpr XmlName relationship{"http://schemas.openxmlformats.org/package/2006/relationships", "Relationship"};
        constexpr std::string_view model_type = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel";
        if (name != relationship || attributes.find("Type") != model_type) {
            return;
        }
        const std::optional<std::string_view> target = attributes.find("Target");
        const std::optional<std::string> part = target ? path_within(*target) : std::nullopt;
        if (!part || attributes.find("TargetMode") == "External") {
            fail("the model is no part of the package");
        } else if (!root_.empty()) {
            fail("a second model");
        } else {
            root_ = *part;
        }
    }

    std::string root_;
};

std::string find_root(ZipArchive& package, Model& model) {
    const std::string part(package_relationships);
    if (!package.contains(part)) {
        const std::string mesh = package.first_part([](std::string_view name) { return is_named_as_mesh(path_of(name)); });
        package.refuse(mesh.empty() ? part : mesh,
                       mesh.empty() ? "is missing" : "is a mesh in a zip archive that is no 3MF package: unpack it first");
    }
    RelationshipReader relationships(model, part);
    relationships.read(package);
    if (relationships.root().empty()) {
        package.refuse(part, "names no model: is no 3MF package");
    }
    return relationships.root();
}

}  // namespace

/// A damaged part can fail as XML before its checksum is known, and damage is the better message.
void PackageReader::read(ZipArchive& package) {
    package.read(name_, [this](std::string_view piece) { return feed_part(piece); });
    finish();
    if (failure()) {
        package.refuse(name_, failure()->what, failure()->line);
    }
    if (const std::optional<XmlFault>& unbound = unbound_name()) {
        model_.warn(printable(name_), unbound->line, unbound->what);
    }
}

std::optional<PartRole> role_of(std::string_view word) noexcept {
    constexpr std::array<std::array<std::string_view, 4>, 6> words = {
        {{"ModelPart", "normal_part"},
         {"NegativeVolume", "negative_part"},
         {"ParameterModifier", "modifier_part", "cura:infill_mesh", "cura:cutting_mesh"},
         {"SupportBlocker", "support_blocker", "cura:anti_overhang_mesh"},
         {"SupportEnforcer", "support_enforcer"},
         {"cura:support_mesh"}}};
    for (std::size_t role = 0; role < words.size() && !word.empty(); ++role) {
        if (std::find(words[role].begin(), words[role].end(), word) != words[role].end()) {
            return static_cast<PartRole>(role);
        }
    }
    return std::nullopt;
}

Part Model::part_of(const std::string& name) {
    const auto [at, is_new] = part_index.emplace(name, static_cast<Part>(parts.size()));
    if (is_new) {
        parts.push_back(name);
    }
    return at->second;
}

namespace {

/// Fills in `model`: the root part, found by the package's relationships, and all parts that it refers to.
void load(const FileSource& file, std::span<const std::byte> bytes, Model& model) {
    // Bytes that the parts may expand to. Their text is not held, so that this bounds the time: real files compress by ten.
    constexpr std::uint64_t largest_ratio = 32;
    const std::uint64_t text_limit =
        file.memory_limit() + largest_ratio * std::min(file.size(), std::numeric_limits<std::uint64_t>::max() / 128);
    ZipArchive package(file, bytes, text_limit);
    const std::string root = find_root(package, model);
    if (!package.contains(content_types)) {
        model.warnings.push_back("has no part '" + std::string(content_types) + "', as a 3MF package must");
    }
    model.part_of(root);
    for (Part part = 0; part < model.parts.size(); ++part) {  // the root part adds to them
        read_part(package, model, part);
    }
    apply_settings(package, model);
    for (const auto& [count, where] :
         {std::pair(package.bytes_before(), "before"), std::pair(package.bytes_after(), "after")}) {
        if (count > 0) {
            model.warnings.push_back("ignored " + std::to_string(count) + " bytes " + where + " the zip archive");
        }
    }
}

void build(const FileSource& file, Model& model, MeshFile& mesh) {
    if (model.items.empty()) {
        refuse_part(file, ErrorCode::empty_mesh, model.parts.front(), 0,
                    model.unprintable_items == 0 ? "has nothing in its build"
                                                 : "has nothing in its build but items marked as not printable");
    }
    std::vector<Instance> instances;
    list_instances(model, file, instances, mesh.parts);
    if (instances.empty() || instances.front().role != PartRole::solid) {
        file.refuse(ErrorCode::empty_mesh, mesh.parts.empty()  ? "holds no triangles"
                                           : instances.empty() ? "holds nothing solid: " + model.warnings.back()
                                                               : "holds nothing solid, only what takes away or labels");
    }
    place(model, instances, file, mesh);
    mesh.text = true;
    mesh.mm_per_unit = model.mm_per_unit;
    mesh.states_unit = true;
    for (const std::string& warning : model.warnings) {
        mesh.warnings.push_back(file.name() + ": " + warning);
    }
}

}  // namespace

}  // namespace three_mf

bool looks_like_3mf(const FileSource& source) {
    return source.sample().starts_with(zip_magic);
}

void parse_3mf(FileContents& file, MeshFile& mesh) {
    three_mf::Model model(file.source);
    three_mf::load(file.source, file.bytes.span(), model);
    file.bytes = Array<std::byte>();
    three_mf::build(file.source, model, mesh);
}

}  // namespace lamella
