// The frame of every call of lamella.h: no exception leaves it, its error becomes a status and a message.
#pragma once

#include <memory>
#include <utility>

#include "base/guard.hpp"
#include "c/handles.hpp"

namespace lamella::c {

/// Writes what went wrong, or that nothing did, and returns the status.
std::int32_t report(const Status& status, lamella_error* error) noexcept;

/// Runs the body of a call.
template <class Body>
std::int32_t called(lamella_error* error, Body&& body) noexcept {
    return report(guarded(std::forward<Body>(body)), error);
}

/// Fills `*result`, or a new one that is put there once it is filled.
template <class Fill>
Status fill_result(lamella_result** result, const Fill& fill) {
    if (result == nullptr) {
        return Error{ErrorCode::invalid_argument, "there is nowhere to put the result: result is NULL"};
    }
    std::unique_ptr<lamella_result> fresh;
    if (*result == nullptr) {
        fresh = std::make_unique<lamella_result>();
    }
    Status status = fill(fresh != nullptr ? fresh->result : (*result)->result);
    if (status && fresh != nullptr) {
        *result = fresh.release();
    }
    return status;
}

/// Moves what a call of C++ gave into `*result`.
inline Status give_result(Result<SliceResult> given, lamella_result** result) {
    return fill_result(result, [&](SliceResult& filled) -> Status {
        if (!given) {
            return given.error();
        }
        filled = std::move(*given);
        return {};
    });
}

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
        if (prepared == nullptr) {
            return Error{ErrorCode::invalid_argument, "the prepared mesh is NULL"};
        }
        Call call(workspace);
        if (Status status = call.read(options); !status) {
            return status;
        }
        return use(prepared->mesh, call);
    });
}

}  // namespace lamella::c
