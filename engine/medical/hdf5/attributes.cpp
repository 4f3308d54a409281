#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "lamella/io/name_text.hpp"
#include "medical/geometry/headers.hpp"
#include "medical/hdf5/archive_file.hpp"
#include "options/option_words.hpp"

namespace lamella {

namespace {

constexpr std::array<std::string_view, 3> frames = {"", "LPS", "RAS"};
constexpr std::array<std::string_view, 1> formats = {archive_format};
constexpr std::uint64_t most = std::numeric_limits<std::uint64_t>::max();

/// Visits each attribute: lists its value, or sets it by that of an open archive and checks it.
class AttributeVisitor {
public:
    AttributeVisitor() = default;
    AttributeVisitor(const InputFile& file, hid_t root) : file_(&file), root_(root) {}

    std::vector<ArchiveAttribute> take() && { return std::move(attributes_); }

    void begin(const char* group) { group_ = group; }

    void text(const char* name, std::string& value) { exchange(name, value); }

    void numbers(const char* name, std::span<double> values) {
        std::vector<double> found(values.begin(), values.end());
        exchange(name, found);
        require(std::all_of(found.begin(), found.end(), [](double value) { return std::isfinite(value); }), name);
        std::copy(found.begin(), found.end(), values.begin());
    }
    void number(const char* name, double& value) { numbers(name, {&value, 1}); }

    template <class Whole>
    void whole(const char* name, Whole& value, std::uint64_t least, std::uint64_t largest) {
        std::vector<std::uint64_t> found = {static_cast<std::uint64_t>(value)};
        exchange(name, found);
        require(found[0] >= least && found[0] <= largest, name);
        value = static_cast<Whole>(found[0]);
    }

    template <class Enum>
    void choice(const char* name, Enum& value, std::span<const std::string_view> words) {
        std::string word(words[static_cast<std::size_t>(value)]);
        exchange(name, word);
        const auto place = std::find(words.begin(), words.end(), word);
        require(place != words.end(), name);
        value = static_cast<Enum>(place - words.begin());
    }

    /// Returns whether there is a value: in a file, by the name of one of its members.
    template <class Value>
    bool optional(const char* name, std::optional<Value>& value) {
        if (file_ != nullptr && H5Aexists_by_name(root_, group_, name, H5P_DEFAULT) > 0) {
            value.emplace();
        }
        return value.has_value();
    }

    /// By its type. Fill rules of ranges of layers are columns. Counts are the range of layers that was cut, in which the
    /// parts of a slicing differ: the root and the rows say it.
    template <class Option>
    void option(const char* name, Option& value) {
        if constexpr (std::is_same_v<Option, double>) {
            number(name, value);
        } else if constexpr (std::is_same_v<Option, bool>) {
            whole(name, value, 0, 1);
        } else if constexpr (std::is_enum_v<Option>) {
            choice(name, value, detail::words_of(value));
        } else if constexpr (std::is_same_v<Option, Transform>) {
            numbers(name, value.m);
        } else if constexpr (std::is_same_v<Option, std::optional<double>>) {
            if (optional(name, value)) {
                number(name, *value);
            }
        } else if constexpr (std::is_same_v<Option, std::optional<std::vector<double>>>) {
            bool given = value.has_value();  // the list is a column, and may have no rows
            whole("at_heights", given, 0, 1);
            if (given && !value) {
                value.emplace();
            }
        } else {
            static_assert(std::is_same_v<Option, std::uint64_t> || std::is_same_v<Option, std::vector<FillFrom>>);
        }
    }

    /// Throws Refused if a value that was read does not hold.
    void require(bool holds, const char* name, const char* why = "out of its range") const {
        if (file_ != nullptr && !holds) {
            refuse_place(*file_, ArchiveAttribute{group_, name, {}}.place(), why);
        }
    }

private:
    /// Lists `value`, or sets it by an attribute of its type and number of values.
    template <class Value>
    void exchange(const char* name, Value& value) {
        if (file_ == nullptr) {
            attributes_.push_back({group_, name, value});
            return;
        }
        const hid_t id = H5Aopen_by_name(root_, group_, name, H5P_DEFAULT, H5P_DEFAULT);
        require(id >= 0, name, "missing");
        const Handle open(id, H5Aclose);
        const Handle space(H5Aget_space(id), H5Sclose);
        const Handle type(H5Aget_type(id), H5Tclose);
        std::size_t count = 1;
        bool is_type = false;
        if constexpr (std::is_same_v<Value, std::string>) {
            constexpr std::size_t longest_text = 65536;
            const std::size_t size = H5Tget_size(type.id());
            is_type = H5Tget_class(type.id()) == H5T_STRING && H5Tis_variable_str(type.id()) == 0 && size > 0 &&
                      size <= longest_text;
            value.resize(std::min(size, longest_text));
        } else {
            count = value.size();
            is_type = H5Tequal(type.id(), hdf5_type<typename Value::value_type>()) > 0;
        }
        require(H5Sget_simple_extent_npoints(space.id()) == static_cast<hssize_t>(count), name,
                "not as many values as it should have");
        require(is_type, name, "not of the type that it should have");
        require(H5Aread(id, type.id(), value.data()) >= 0, name, "cannot be read");
        if constexpr (std::is_same_v<Value, std::string>) {
            value.resize(std::min(value.find('\0'), value.size()));
        }
    }

    const InputFile* file_ = nullptr;  ///< to be read; none to list attributes
    hid_t root_ = -1;
    const char* group_ = "/";
    std::vector<ArchiveAttribute> attributes_;
};

void visit_mesh(AttributeVisitor& visitor, SliceInfo& slice, ArchiveInfo& info) {
    visitor.begin("/mesh");
    std::string name = text_of_name(info.name);  // since any bytes are a name
    visitor.text("name", name);
    info.name = name_of_text(name);
    visitor.text("sha256", info.mesh_sha256);
    visitor.choice("patient_frame", info.frame, frames);
    visitor.whole("triangles", slice.triangles, 0, most);
    visitor.whole("degenerate", slice.degenerate, 0, most);
    visitor.numbers("min_mm", slice.box.min_mm);
    visitor.numbers("max_mm", slice.box.max_mm);
    visitor.whole("meshes", slice.part_count, 1, several_parts - 1);
    if (visitor.optional("weld_tolerance_mm", info.weld)) {
        visitor.number("weld_tolerance_mm", info.weld->tolerance_mm);
        visitor.whole("weld_joined", info.weld->joined, 0, most);
    }
}

void visit_image(AttributeVisitor& visitor, ArchiveInfo& info) {
    visitor.begin("/image");
    if (!visitor.optional("origin_mm", info.geometry)) {
        return;
    }
    ImageGeometry& image = *info.geometry;
    static constexpr std::array<const char*, 3> size_names = {"size_i", "size_j", "size_k"};
    static constexpr std::array<const char*, 3> axis_names = {"axis_i", "axis_j", "axis_k"};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        visitor.whole(size_names[axis], image.size[axis], 1, largest_image_side);
        visitor.numbers(axis_names[axis], image.axes[axis]);
        visitor.require(std::abs(length(image.axes[axis]) - 1) < 1e-3, axis_names[axis]);
    }
    visitor.numbers("origin_mm", image.origin_mm);
    visitor.numbers("spacing_mm", image.spacing_mm);
    visitor.require(*std::min_element(image.spacing_mm.begin(), image.spacing_mm.end()) > 0, "spacing_mm");
    visitor.whole("subslices", info.subslices, 1, 1000);
    std::uint64_t uneven = image.uneven_slices_mm.size();
    visitor.whole("uneven_slices", uneven, 0, most_uneven_slices);
    if (uneven > 0) {
        visitor.require(uneven == image.size[2], "uneven_slices");
        image.uneven_slices_mm.resize(uneven);
        visitor.numbers("uneven_slices_mm", image.uneven_slices_mm);
    }
}

void visit(AttributeVisitor& visitor, SliceInfo& slice, ArchiveInfo& info, std::uint64_t& hash) {
    visitor.begin("/");
    visitor.number("grid_mm", slice.grid_mm);
    visitor.require(slice.grid_mm > 0, "grid_mm");
    visitor.whole("grid_doublings", slice.grid_doublings, 0, 1000);
    visit_mesh(visitor, slice, info);
    visitor.begin("/options");
#define OPTION(kind, name, path, ...) visitor.option(#name, slice.options.path);
#include "options/options.inc"
    visit_image(visitor, info);
    visitor.begin("/");
    visitor.whole("planned_layers", slice.planned_layers, 0, most);  // last: where options differ, that is what is said
    std::size_t format = 0;
    std::uint64_t version = archive_version;
    visitor.choice("format", format, formats);
    visitor.whole("format_version", version, archive_version, archive_version);
    visitor.whole("result_hash", hash, 0, most);
    visitor.whole("first_layer", slice.first_layer, 0, most);
}

}  // namespace

std::vector<ArchiveAttribute> attributes_of(SliceInfo slice, ArchiveInfo info, std::uint64_t hash) {
    AttributeVisitor lister;
    visit(lister, slice, info, hash);
    return std::move(lister).take();
}

void read_attributes(const InputFile& file, hid_t root, ReadTree& tree) {
    AttributeVisitor reader(file, root);
    visit(reader, tree.result.info, tree.info, tree.hash);
}

void refuse_place(const InputFile& file, const std::string& place, const std::string& why) {
    throw Refused{file.error(ErrorCode::malformed_mesh, place + ": " + why)};
}

}  // namespace lamella
