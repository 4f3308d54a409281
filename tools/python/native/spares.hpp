// Memory of calls and results that are over, for those to come: fresh pages cost a slice of a small mesh more than its
// arithmetic.
#pragma once

#include <mutex>
#include <vector>

#include "lamella/result.hpp"
#include "lamella/slice.hpp"

namespace lamella::python {

/// One result and a few workspaces, none of more than 64 MB. Whoever finds them in use by another thread goes without:
/// nobody waits, and a forked process does not hang where its parent held the lock.
class Spares {
public:
    /// Of the module. It is never destroyed: results may go after everything else.
    static Spares& all() noexcept;

    Workspace take_workspace() noexcept;
    SliceResult take_result() noexcept;
    void give(Workspace&& workspace) noexcept;
    void give(SliceResult&& result) noexcept;

private:
    static constexpr std::size_t most_bytes = std::size_t{64} << 20;
    static constexpr std::size_t most_workspaces = 4;

    std::mutex mutex_;
    std::vector<Workspace> workspaces_;
    SliceResult result_;
};

}  // namespace lamella::python
