// What every call of lamella.h has in common: what the program gave is read, no exception leaves the call, and its error
// becomes a status and a message.
#pragma once

#include <initializer_list>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/guard.hpp"
#include "c/structs.hpp"
#include "lamella/context.hpp"
#include "lamella/lamella.h"
#include "lamella/slice.hpp"
#include "lamella/weld.hpp"

struct lamella_result {
    lamella::SliceResult result;
};

struct lamella_slicer {
    lamella::Slicer slicer;
    lamella::SliceOptions options;  ///< kept, so that a call allocates nothing for their lists
    lamella::SliceInfo info;        ///< of the last call: lamella_info::layer_of views it
};

struct lamella_prepared {
    lamella::PreparedMesh mesh;
};

struct lamella_welded {
    lamella::WeldedMesh mesh;
};

namespace lamella::c {

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

}  // namespace lamella::c
