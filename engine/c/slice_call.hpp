// What the calls that cut a mesh have in common.
#pragma once

#include <memory>

#include "c/call.hpp"
#include "c/call_options.hpp"
#include "c/handles.hpp"
#include "lamella/lamella.h"
#include "lamella/mesh.hpp"
#include "lamella/slice.hpp"

namespace lamella::c {

/// Mesh, options and workspace of one call.
class Call {
public:
    explicit Call(lamella_workspace* workspace) : kept_(workspace) {
        if (kept_ == nullptr) {
            own_ = std::make_unique<lamella_workspace>();
            kept_ = own_.get();
        }
    }

    Status read(const lamella_options* given) { return kept_->options.read(given); }
    Status read(const lamella_mesh* given_mesh, const lamella_options* given) {
        if (Status status = read(given); !status) {
            return status;
        }
        double in_mm = 1;
        if (Status status = read_mesh(given_mesh, mesh, in_mm); !status) {
            return status;
        }
        if (in_mm != 1) {
            options().transform = options().transform * Transform::scale(in_mm);
        }
        return {};
    }

    SliceOptions& options() noexcept { return kept_->options.options; }
    Workspace& workspace() noexcept { return kept_->workspace; }

    MeshView mesh;

private:
    std::unique_ptr<lamella_workspace> own_;
    lamella_workspace* kept_;
};

Status check_prepared(const lamella_prepared* prepared);

/// Runs use(mesh, call) for what a call of C was given.
template <class Use>
std::int32_t called_with(const lamella_mesh* mesh, const lamella_options* options, lamella_workspace* workspace,
                         lamella_error* error, const Use& use) noexcept {
    return called(error, [&]() -> Status {
        Call call(workspace);
        if (Status status = call.read(mesh, options); !status) {
            return status;
        }
        return use(call.mesh, call);
    });
}
template <class Use>
std::int32_t called_with(const lamella_prepared* prepared, const lamella_options* options, lamella_workspace* workspace,
                         lamella_error* error, const Use& use) noexcept {
    return called(error, [&]() -> Status {
        if (Status status = check_prepared(prepared); !status) {
            return status;
        }
        Call call(workspace);
        if (Status status = call.read(options); !status) {
            return status;
        }
        return use(prepared->mesh, call);
    });
}

}  // namespace lamella::c
