// What every call of lamella.h has in common: what the program gave is read, no exception leaves the call, and its error
// becomes a status and a message.
//
// Structs that begin with their size. A program that was compiled with an older header fills in only the beginning: the rest
// has its defaults. A program with a newer header has fields that the library does not know: they must be 0, since what they
// ask for would not be done.
//
//     the program's      [ size | a | b ]           [ size | a | b | c | d ]
//     the library's      [ size | a | b | c ]       [ size | a | b | c ]
//                                      ^ default                      ^ 0
//
// And C structs that are views of C++ ones: same bytes, another name; with the constants that both state.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/function_ref.hpp"
#include "base/guard.hpp"
#include "lamella/context.hpp"
#include "lamella/error.hpp"
#include "lamella/grid.hpp"
#include "lamella/heights.h"
#include "lamella/heights.hpp"
#include "lamella/lamella.h"
#include "lamella/layers.hpp"
#include "lamella/measures.h"
#include "lamella/measures.hpp"
#include "lamella/options.hpp"
#include "lamella/overlay.h"
#include "lamella/overlay.hpp"
#include "lamella/result.hpp"
#include "lamella/slice.hpp"
#include "lamella/tracks.h"
#include "lamella/tracks.hpp"
#include "lamella/version.hpp"
#include "lamella/weld.hpp"

struct lamella_result {
    lamella::SliceResult result;
};

struct lamella_slicer {
    lamella::Slicer slicer;
    lamella::SliceOptions options;  ///< kept, so that a call allocates nothing for their lists
    lamella::SliceInfo info;        ///< of the last call: lamella_info::layer_of views it
};

struct lamella_overlay {
    lamella::Overlay overlay;
    lamella::SliceInfo info;  ///< of the last call, as of a slicer
};

struct lamella_prepared {
    lamella::PreparedMesh mesh;
};

struct lamella_slabs {
    lamella::Array<lamella::Slab> slabs;
};

struct lamella_tracks {
    lamella::Tracks tracks;
};

struct lamella_welded {
    lamella::WeldedMesh mesh;
};

namespace lamella::c {

/// No version of a struct is larger: what is was not initialised.
inline constexpr std::size_t largest_struct = 4096;

/// A struct's number for lamella_init_sized(), its name there, and where its last field ends.
template <class T>
struct Sized;
// NOLINTBEGIN(bugprone-sizeof-expression): the last field may be a pointer
#define LAMELLA_SIZED(T, KIND, last)                                            \
    template <>                                                                 \
    struct Sized<T> {                                                           \
        static constexpr std::int32_t kind = KIND;                              \
        static constexpr const char* init = "LAMELLA_INIT(&it, " #KIND ")";     \
        static constexpr const char* name = #T;                                 \
        static constexpr std::size_t end = offsetof(T, last) + sizeof(T::last); \
    }
LAMELLA_SIZED(lamella_error, LAMELLA_ERROR, message);
LAMELLA_SIZED(lamella_context, LAMELLA_CONTEXT, reserved);
LAMELLA_SIZED(lamella_mesh, LAMELLA_MESH, reserved);
LAMELLA_SIZED(lamella_source, LAMELLA_SOURCE, part_place_counts);
LAMELLA_SIZED(lamella_options, LAMELLA_OPTIONS, largest_only);
LAMELLA_SIZED(lamella_info, LAMELLA_INFO, copy_count);
LAMELLA_SIZED(lamella_layer_view, LAMELLA_LAYER_VIEW, stitch_count);
LAMELLA_SIZED(lamella_view, LAMELLA_VIEW, info);
LAMELLA_SIZED(lamella_sink, LAMELLA_SINK, object);
LAMELLA_SIZED(lamella_arrays, LAMELLA_ARRAYS, origins);
LAMELLA_SIZED(lamella_destination, LAMELLA_DESTINATION, arrays);
LAMELLA_SIZED(lamella_check_result, LAMELLA_CHECK_RESULT, faults);
LAMELLA_SIZED(lamella_audit_result, LAMELLA_AUDIT_RESULT, reserved);
LAMELLA_SIZED(lamella_layer_set, LAMELLA_LAYER_SET, part);
LAMELLA_SIZED(lamella_rule, LAMELLA_RULE, label_object);
LAMELLA_SIZED(lamella_adaptive, LAMELLA_ADAPTIVE, range_count);
LAMELLA_SIZED(lamella_offset, LAMELLA_OFFSET, arc_tolerance_mm);
LAMELLA_SIZED(lamella_track_options, LAMELLA_TRACK_OPTIONS, pockets);
LAMELLA_SIZED(lamella_track_arrays, LAMELLA_TRACK_ARRAYS, bodies);
#undef LAMELLA_SIZED
// NOLINTEND(bugprone-sizeof-expression)

/// Where pointers have 4 bytes, some structs end in padding: there, a program and its library have to be of one version.
template <class T>
constexpr void check_sized() {
    static_assert(std::is_standard_layout_v<T> && std::is_trivially_copyable_v<T>, "what C can read");
    static_assert(offsetof(T, struct_size) == 0, "the size comes first");
    static_assert(sizeof(void*) == 4 || Sized<T>::end == sizeof(T),
                  "a field of a later version must not lie where programs of this one leave padding unset");
}

[[noreturn]] inline void refuse(std::string message) {
    throw Refused{{ErrorCode::invalid_argument, std::move(message)}};
}

/// The defaults that are not 0.
template <class T>
void set_defaults(T& /*it*/) noexcept {}
void set_defaults(lamella_error& error) noexcept;
void set_defaults(lamella_context& context) noexcept;
void set_defaults(lamella_mesh& mesh) noexcept;
void set_defaults(lamella_options& options) noexcept;
void set_defaults(lamella_arrays& arrays) noexcept;
void set_defaults(lamella_audit_result& found) noexcept;
void set_defaults(lamella_layer_set& set) noexcept;
void set_defaults(lamella_rule& rule) noexcept;
void set_defaults(lamella_adaptive& adaptive) noexcept;
void set_defaults(lamella_offset& offset) noexcept;

template <class T>
T defaults() noexcept {
    T it{};
    set_defaults(it);
    return it;
}

/// The size that the program's struct begins with, 0 of a null one. Throws Refused where it was not initialised.
std::uint32_t size_given(const void* given, const char* name, const char* init);

template <class T>
void require_initialised(const T* given) {
    size_given(given, Sized<T>::name, Sized<T>::init);
}

/// Copies what the program gave over the `bytes` defaults at `whole`. Throws Refused where what the library does not know is
/// set: beyond `bytes`, or the number `reserved`, which may be null.
void copy_given(const void* given, void* whole, std::size_t bytes, const std::int32_t* reserved, const char* name,
                const char* init);

/// What the program gave, and the defaults beyond; all defaults where it gave nothing. Throws Refused.
template <class T>
T read_sized(const T* given) {
    check_sized<T>();
    T whole = defaults<T>();
    const std::int32_t* reserved = nullptr;
    if constexpr (requires { whole.reserved; }) {
        reserved = &whole.reserved;
    }
    copy_given(given, &whole, sizeof whole, reserved, Sized<T>::name, Sized<T>::init);
    return whole;
}

/// As much of `value` as the program's struct holds.
template <class T>
void write_sized(const T& value, T* out) noexcept {
    check_sized<T>();
    if (out != nullptr) {
        const std::uint32_t size = out->struct_size;
        std::memcpy(out, &value, std::min<std::size_t>(size, sizeof(T)));
        out->struct_size = size;
    }
}

/// For each struct of the C header that is an element of an array: the C++ struct that lies in the same bytes.
template <class C>
struct Same;
#define LAMELLA_SAME(C, Cpp)                                   \
    template <>                                                \
    struct Same<C> {                                           \
        using type = Cpp;                                      \
        static_assert(sizeof(C) == sizeof(Cpp), "same bytes"); \
    }
LAMELLA_SAME(lamella_point, Point);
LAMELLA_SAME(lamella_contour, Contour);
LAMELLA_SAME(lamella_layer, Layer);
LAMELLA_SAME(lamella_stitch, Stitch);
LAMELLA_SAME(lamella_point_origin, PointOrigin);
LAMELLA_SAME(lamella_segment, Segment);
LAMELLA_SAME(lamella_part_copy, PartCopy);
LAMELLA_SAME(lamella_slab, Slab);
LAMELLA_SAME(lamella_height_range, HeightRange);
LAMELLA_SAME(lamella_track, Track);
LAMELLA_SAME(lamella_track_link, TrackLink);
LAMELLA_SAME(lamella_pocket, Pocket);
LAMELLA_SAME(lamella_section_measures, SectionMeasures);
LAMELLA_SAME(lamella_memory, Memory);
#undef LAMELLA_SAME

#define LAMELLA_SAME_PLACE(C, c_field, Cpp, field) \
    static_assert(offsetof(C, c_field) == offsetof(Cpp, field), #C "." #c_field " and its C++ field lie in one place")
LAMELLA_SAME_PLACE(lamella_point, y, Point, y);
LAMELLA_SAME_PLACE(lamella_contour, twice_area_low, Contour, twice_area);
LAMELLA_SAME_PLACE(lamella_contour, parent, Contour, parent);
LAMELLA_SAME_PLACE(lamella_contour, point_count, Contour, point_count);
LAMELLA_SAME_PLACE(lamella_contour, segments, Contour, segments);
LAMELLA_SAME_PLACE(lamella_contour, role, Contour, role);
LAMELLA_SAME_PLACE(lamella_contour, orientation, Contour, orientation);
LAMELLA_SAME_PLACE(lamella_contour, flags, Contour, flags);
LAMELLA_SAME_PLACE(lamella_contour, part, Contour, part);
LAMELLA_SAME_PLACE(lamella_layer, top_mm, Layer, top_mm);
LAMELLA_SAME_PLACE(lamella_layer, first_contour, Layer, first_contour);
LAMELLA_SAME_PLACE(lamella_layer, segments, Layer, segments);
LAMELLA_SAME_PLACE(lamella_layer, plane, Layer, plane);
LAMELLA_SAME_PLACE(lamella_stitch, from, Stitch, from);
LAMELLA_SAME_PLACE(lamella_stitch, to, Stitch, to);
LAMELLA_SAME_PLACE(lamella_point_origin, part, PointOrigin, part);
LAMELLA_SAME_PLACE(lamella_point_origin, edge, PointOrigin, edge);
LAMELLA_SAME_PLACE(lamella_point_origin, end_edge, PointOrigin, end_edge);
LAMELLA_SAME_PLACE(lamella_segment, to_key, Segment, to_key);
LAMELLA_SAME_PLACE(lamella_segment, from, Segment, from);
LAMELLA_SAME_PLACE(lamella_segment, from_rank, Segment, from_rank);
LAMELLA_SAME_PLACE(lamella_part_copy, move, PartCopy, move);
LAMELLA_SAME_PLACE(lamella_slab, top_mm, Slab, top_mm);
LAMELLA_SAME_PLACE(lamella_height_range, to_mm, HeightRange, to_mm);
LAMELLA_SAME_PLACE(lamella_height_range, height_mm, HeightRange, height_mm);
LAMELLA_SAME_PLACE(lamella_track, contour, Track, contour);
LAMELLA_SAME_PLACE(lamella_track, centroid_mm, Track, centroid_mm);
LAMELLA_SAME_PLACE(lamella_track, above, Track, above);
LAMELLA_SAME_PLACE(lamella_track, body, Track, body);
LAMELLA_SAME_PLACE(lamella_track_link, upper, TrackLink, upper);
LAMELLA_SAME_PLACE(lamella_pocket, end_layer, Pocket, end_layer);
LAMELLA_SAME_PLACE(lamella_pocket, is_cavity, Pocket, is_cavity);
LAMELLA_SAME_PLACE(lamella_section_measures, known, SectionMeasures, known);
LAMELLA_SAME_PLACE(lamella_section_measures, polar_mm4, SectionMeasures, polar_mm4);
LAMELLA_SAME_PLACE(lamella_section_measures, circularity, SectionMeasures, circularity);
static_assert(std::is_standard_layout_v<Memory>);
LAMELLA_SAME_PLACE(lamella_memory, release_object, Memory, release);
#undef LAMELLA_SAME_PLACE
static_assert(LAMELLA_SOLID == static_cast<int>(PartRole::solid) && LAMELLA_SUPPORT == static_cast<int>(PartRole::support));
static_assert(LAMELLA_NO_TRIANGLE == no_triangle && LAMELLA_NO_EDGE == no_edge && LAMELLA_SEVERAL_PARTS == several_parts);
static_assert(LAMELLA_DEFAULT_GRID_MM == default_grid_mm && LAMELLA_FINEST_GRID == finest_grid &&
              LAMELLA_STITCH_BY_MESH == stitch_by_mesh && LAMELLA_GRID_LIMIT == grid_limit &&
              LAMELLA_ALL_LAYERS == all_layers);
static_assert(LAMELLA_MOST_LAYER_SETS == most_layer_sets && LAMELLA_MOST_LABELS == most_labels);

template <class C>
const typename Same<C>::type* as_cpp(const C* c) noexcept {
    return reinterpret_cast<const typename Same<C>::type*>(c);
}
template <class C>
typename Same<C>::type* as_cpp(C* c) noexcept {
    return reinterpret_cast<typename Same<C>::type*>(c);
}
template <class C>
const C* as_c(const typename Same<C>::type* cpp) noexcept {
    return reinterpret_cast<const C*>(cpp);
}

/// The program's functions. Holds what the C++ context points to: neither copied nor moved.
class Host {
public:
    explicit Host(const lamella_context* given);
    Host(const Host&) = delete;
    Host& operator=(const Host&) = delete;

    Context context;

private:
    lamella_context c_;
};

/// These throw Refused where something is missing, or a list; where a choice is none of 0 to `last`; where not exactly one
/// of the pointers is set, which are the `fields` of a struct.
void require_given(const void* given, const std::string& what);
void require_list(const void* list, std::size_t count, const char* name);
void require_choice(std::int32_t given, std::int32_t last, const char* name);
void require_one(std::initializer_list<const void*> given, const char* fields);

/// These throw Refused where a struct has no size, a pointer is missing or a choice has no meaning.
MeshView read_mesh(const lamella_mesh* given);
/// All defaults where `given` is null. The lists in `options` keep their memory.
void read_options(const lamella_options* given, SliceOptions& options);

lamella_info info_of(const SliceInfo& info) noexcept;
lamella_layer_view view_of(const LayerView& layer) noexcept;

/// Writes what went wrong, or that nothing did, and returns the status.
std::int32_t report(const Status& status, lamella_error* error) noexcept;

/// Runs the body of a call, which may throw Refused.
template <class Body>
std::int32_t called(lamella_error* error, Body&& body) noexcept {
    return report(guarded([&]() -> Status {
                      std::forward<Body>(body)();
                      return {};
                  }),
                  error);
}

/// Throws Refused where there is no place for what a call makes.
inline void require_place(const void* place, const std::string& what, const char* name) {
    if (place == nullptr) {
        refuse("there is nowhere to put " + what + ": " + name + " is NULL");
    }
}

/// fill(result) of `*result`, or of a new one that is put there once it is filled.
template <class Fill>
void fill_result(lamella_result** result, const Fill& fill) {
    require_place(result, "the result", "result");
    std::unique_ptr<lamella_result> fresh;
    lamella_result* to = *result;
    if (to == nullptr) {
        fresh = std::make_unique<lamella_result>();
        to = fresh.get();
    }
    fill(to->result);
    if (fresh != nullptr) {
        *result = fresh.release();
    }
}

/// A handle with an `info` that the program keeps, or one for this call.
template <class Handle>
class Kept {
public:
    explicit Kept(Handle* given) : kept_(given) {
        if (kept_ == nullptr) {
            own_ = std::make_unique<Handle>();
            kept_ = own_.get();
        }
    }
    Handle* operator->() const noexcept { return kept_; }

    /// What the call found, for the program. The list of layers is that of `result` or else of the handle; where the program
    /// keeps neither, it ends with the call.
    void give(Result<SliceInfo> found, lamella_info* info, const SliceResult* result = nullptr) {
        kept_->info = require(std::move(found));
        lamella_info c = info_of(result != nullptr ? result->info : kept_->info);
        if (result == nullptr && own_ != nullptr) {
            c.layer_of = nullptr;
            c.layer_of_count = 0;
            c.copies = nullptr;
            c.copy_count = 0;
        }
        write_sized(c, info);
    }

private:
    std::unique_ptr<Handle> own_;
    Handle* kept_;
};

/// Throws Refused where no place is set, or several.
lamella_destination read_destination(const lamella_destination* given);

/// fill(destination, the result among the destinations or null) with what read_destination() gave. Throws Refused.
void fill_destination(const lamella_destination& to, FunctionRef<void(const Destination&, const SliceResult*)> fill);

/// Contours of the program's. Throws Refused where points are missing.
std::vector<std::span<const Point>> read_paths(const lamella_path* contours, std::size_t count);

}  // namespace lamella::c
