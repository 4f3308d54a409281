// The SHA-256 of a mesh file, computed while it is sliced.
#pragma once

#include <atomic>
#include <chrono>
#include <future>
#include <string>

#include "lamella/medical.hpp"
#include "terminal/console.hpp"

namespace lamella::cli {

/// Reads a file beside the first pass of a slice: one that is larger than memory comes from the disk once for both.
class SealAside {
public:
    /// Of an empty path nothing is computed aside.
    explicit SealAside(const std::string& path = {}) {
        if (!path.empty()) {
            seal_ = std::async(std::launch::async, [this, path] { return seal_file(path_of(path), {.stop = *this}); });
        }
    }
    ~SealAside() { ended_ = true; }  // then waits for it
    SealAside(const SealAside&) = delete;
    SealAside& operator=(const SealAside&) = delete;

    /// True where it is to end before it is done.
    bool operator()() const noexcept { return ended_; }

    /// Once. Computed here if not aside.
    Result<FileSeal> seal(const std::string& path, const Context& context, const ImageOptions& image) {
        if (!seal_.valid()) {
            return seal_file(path_of(path), context, image);
        }
        while (seal_.wait_for(std::chrono::milliseconds(20)) == std::future_status::timeout) {
            ended_ = ended_ || (context.stop && context.stop());
        }
        return seal_.get();
    }

private:
    std::atomic<bool> ended_ = false;
    std::future<Result<FileSeal>> seal_;
};

}  // namespace lamella::cli
