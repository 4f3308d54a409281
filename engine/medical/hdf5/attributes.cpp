#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>

#include "lamella/io/name_text.hpp"
#include "medical/geometry/headers.hpp"
#include "medical/hdf5/archive_file.hpp"
#include "medical/hdf5/handles.hpp"
#include "options/option_words.hpp"

namespace lamella {

namespace {

constexpr std::array<std::string_view, 3> frames = {"", "LPS", "RAS"};
constexpr std::uint64_t most = std::numeric_limits<std::uint64_t>::max();
constexpr std::size_t longest_text = 65536;

/// Reads `attribute`, whose value has the type and the number of values that are wanted. Throws Refused.
void read_attribute(const InputFile& file, hid_t tree, ArchiveAttribute& attribute) {
    const auto require = [&](bool holds, const char* why) {
        if (!holds) {
            refuse_place(file, attribute.place(), why);
        }
    };
    const hid_t id = H5Aopen_by_name(tree, attribute.group.c_str(), attribute.name.c_str(), H5P_DEFAULT, H5P_DEFAULT);
    require(id >= 0, "missing");
    const Handle open(id, H5Aclose);
    const Handle space(H5Aget_space(id), H5Sclose);
    const Handle type(H5Aget_type(id), H5Tclose);
    const auto read = [&](std::size_t count, bool is_type, void* to) {
        require(H5Sget_simple_extent_npoints(space.id()) == static_cast<hssize_t>(count),
                "not as many values as it should have");
        require(is_type, "not of the type that it should have");
        require(H5Aread(id, type.id(), to) >= 0, "cannot be read");
    };
    if (auto* const text = std::get_if<std::string>(&attribute.value)) {
        const std::size_t size = H5Tget_size(type.id());
        const bool is_text = H5Tget_class(type.id()) == H5T_STRING && H5Tis_variable_str(type.id()) == 0;
        text->resize(std::min(size, longest_text));
        read(1, is_text && size > 0 && size <= longest_text, text->data());
        text->resize(std::min(text->find('\0'), text->size()));
    } else if (auto* const doubles = std::get_if<std::vector<double>>(&attribute.value)) {
        read(doubles->size(), H5Tequal(type.id(), hdf5_type<double>()) > 0, doubles->data());
    } else {
        auto& wholes = std::get<std::vector<std::uint64_t>>(attribute.value);
        read(wholes.size(), H5Tequal(type.id(), hdf5_type<std::uint64_t>()) > 0, wholes.data());
    }
}

/// Visits each attribute: writes down what is const, and reads and checks all else.
class AttributeVisitor {
public:
    AttributeVisitor() = default;
    AttributeVisitor(const InputFile& file, hid_t tree) : file_(&file), tree_(tree) {}

    std::vector<ArchiveAttribute> take() && { return std::move(attributes_); }

    void begin(const char* group) { group_ = group; }

    template <class Text>
    void text(const char* name, Text& value) {
        set(value, exchanged(name, std::string(value)));
    }
    /// As text_of_name(), since any bytes are a name.
    template <class Text>
    void file_name(const char* name, Text& value) {
        set(value, name_of_text(exchanged(name, text_of_name(value))));
    }

    template <class Doubles>
    void numbers(const char* name, Doubles&& doubles) {
        const std::span values(doubles);
        const std::vector<double> found = exchanged(name, std::vector<double>(values.begin(), values.end()));
        require(std::all_of(found.begin(), found.end(), [](double value) { return std::isfinite(value); }), name);
        for (std::size_t i = 0; i < values.size(); ++i) {
            set(values[i], found[i]);
        }
    }
    template <class Double>
    void number(const char* name, Double& value) {
        numbers(name, std::span(&value, 1));
    }

    template <class Whole>
    void whole(const char* name, Whole& value, std::uint64_t least, std::uint64_t largest) {
        const std::uint64_t found = exchanged(name, std::vector{static_cast<std::uint64_t>(value)}).front();
        require(found >= least && found <= largest, name);
        set(value, found);
    }

    template <class Enum>
    void choice(const char* name, Enum& value, std::span<const std::string_view> words) {
        const std::string found = exchanged(name, std::string(words[static_cast<std::size_t>(value)]));
        const auto place = std::find(words.begin(), words.end(), found);
        require(place != words.end(), name);
        set(value, place - words.begin());
    }

    /// Returns whether there is a value: in a file, by the name of one of its members.
    template <class Optional>
    bool optional(const char* name, Optional& value) {
        if constexpr (!std::is_const_v<Optional>) {
            if (H5Aexists_by_name(tree_, group_, name, H5P_DEFAULT) > 0) {
                value.emplace();
            }
        }
        return value.has_value();
    }

    /// By its type. Fill rules of ranges of layers are columns. Counts are the range of layers that was cut, in which the
    /// parts of a slicing differ: the root and the rows say it.
    template <class Option>
    void option(const char* name, Option& value) {
        using T = std::remove_const_t<Option>;
        if constexpr (std::is_same_v<T, double>) {
            number(name, value);
        } else if constexpr (std::is_same_v<T, bool>) {
            whole(name, value, 0, 1);
        } else if constexpr (std::is_enum_v<T>) {
            choice(name, value, detail::words_of(value));
        } else if constexpr (std::is_same_v<T, Transform>) {
            numbers(name, value.m);
        } else if constexpr (std::is_same_v<T, std::optional<double>>) {
            if (optional(name, value)) {
                number(name, *value);
            }
        } else if constexpr (std::is_same_v<T, std::optional<std::vector<double>>>) {
            heights(value);
        } else {
            static_assert(std::is_same_v<T, std::uint64_t> || std::is_same_v<T, std::vector<FillFrom>>);
        }
    }

    /// For values that were read.
    void require(bool holds, const char* name) const {
        if (file_ != nullptr && !holds) {
            refuse_place(*file_, ArchiveAttribute{group_, name, {}}.place(), "out of its range");
        }
    }

private:
    /// A column. Where it has no rows, a list of heights may still be given.
    template <class Heights>
    void heights(Heights& value) {
        std::uint64_t given = value.has_value() ? 1 : 0;
        whole("at_heights", given, 0, 1);
        if constexpr (!std::is_const_v<Heights>) {
            value = given != 0 ? Heights(std::in_place) : std::nullopt;
        }
    }

    /// What is found in the file, or else `value`, which is written down.
    template <class Value>
    Value exchanged(const char* name, Value value) {
        ArchiveAttribute attribute{group_, name, std::move(value)};
        if (file_ != nullptr) {
            read_attribute(*file_, tree_, attribute);
            return std::get<Value>(std::move(attribute.value));
        }
        attributes_.push_back(attribute);
        return std::get<Value>(std::move(attribute.value));
    }

    template <class To, class From>
    static void set(To& to, From&& from) {
        if constexpr (!std::is_const_v<To>) {
            to = static_cast<To>(std::forward<From>(from));
        }
    }

    const InputFile* file_ = nullptr;  ///< to be read; none to write attributes down
    hid_t tree_ = -1;
    const char* group_ = "/";
    std::vector<ArchiveAttribute> attributes_;
};

template <class Slice, class Info>
void visit_mesh(AttributeVisitor& visitor, Slice& slice, Info& info) {
    visitor.begin("/mesh");
    visitor.file_name("name", info.name);
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

template <class Options>
void visit_options(AttributeVisitor& visitor, Options& options) {
    visitor.begin("/options");
#define OPTION(kind, name, path, ...) visitor.option(#name, options.path);
#include "options/options.inc"
}

template <class Info>
void visit_image(AttributeVisitor& visitor, Info& info) {
    visitor.begin("/image");
    if (!visitor.optional("origin_mm", info.geometry)) {
        return;
    }
    auto& image = *info.geometry;
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
        if constexpr (!std::is_const_v<Info>) {
            image.uneven_slices_mm.resize(uneven);
        }
        visitor.numbers("uneven_slices_mm", image.uneven_slices_mm);
    }
}

template <class Slice, class Info>
void visit(AttributeVisitor& visitor, Slice& slice, Info& info) {
    visitor.begin("/");
    visitor.number("grid_mm", slice.grid_mm);
    visitor.require(slice.grid_mm > 0, "grid_mm");
    visitor.whole("grid_doublings", slice.grid_doublings, 0, 1000);
    visit_mesh(visitor, slice, info);
    visit_options(visitor, slice.options);
    visit_image(visitor, info);
    visitor.begin("/");
    visitor.whole("planned_layers", slice.planned_layers, 0, most);  // last: where options differ, that is what is said
}

}  // namespace

std::vector<ArchiveAttribute> attributes_of(const SliceInfo& slice, const ArchiveInfo& info) {
    AttributeVisitor writer;
    visit(writer, slice, info);
    return std::move(writer).take();
}

void read_attributes(const InputFile& file, hid_t tree, SliceInfo& slice, ArchiveInfo& info) {
    AttributeVisitor reader(file, tree);
    visit(reader, slice, info);
}

std::uint64_t whole_of_root(const InputFile& file, hid_t tree, const std::string& name) {
    ArchiveAttribute attribute{"/", name, std::vector<std::uint64_t>(1)};
    read_attribute(file, tree, attribute);
    return std::get<std::vector<std::uint64_t>>(attribute.value).front();
}

void refuse_place(const InputFile& file, const std::string& place, const std::string& why) {
    throw Refused{file.error(ErrorCode::malformed_mesh, place + ": " + why)};
}

}  // namespace lamella
