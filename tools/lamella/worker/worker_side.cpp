#include "worker/worker_side.hpp"

#include <charconv>
#include <cstdlib>
#include <system_error>

#include <fcntl.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <csignal>

#include "terminal/failure.hpp"

namespace lamella::cli {

namespace {

/// True if all of `text` is "FD:PID".
bool parse_worker(std::string_view text, int& descriptor, pid_t& process) {
    const std::size_t colon = text.find(':');
    if (colon == std::string_view::npos) {
        return false;
    }
    const char* const middle = text.data() + colon;
    const char* const end = text.data() + text.size();
    const auto first = std::from_chars(text.data(), middle, descriptor);
    const auto second = std::from_chars(middle + 1, end, process);
    return first.ec == std::errc() && first.ptr == middle && second.ec == std::errc() && second.ptr == end;
}

/// The system then rather ends a mesh than the batch.
void be_first_without_memory() noexcept {
    const int descriptor = ::open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC);
    if (descriptor >= 0) {
        (void)!::write(descriptor, "500", 3);
        ::close(descriptor);
    }
}

}  // namespace

void WorkerSide::declare(CLI::App& command) {
    command.add_option("--worker", text_)->group("");
}

void WorkerSide::begin() {
    if (text_.empty()) {
        return;
    }
    pid_t parent = 0;
    if (!parse_worker(text_, descriptor_, parent)) {
        throw Failure(bad_usage, "--worker: is for lamella batch");
    }
    (void)::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) {  // It ended before.
        std::_Exit(bad_input);
    }
    (void)::fcntl(descriptor_, F_SETFD, FD_CLOEXEC);
    be_first_without_memory();
}

void WorkerSide::tell(const SliceFacts& facts) const noexcept {
    try {
        const std::string text = text_of(facts);
        for (std::size_t at = 0; wanted() && at < text.size();) {
            const ssize_t written = ::write(descriptor_, text.data() + at, text.size() - at);
            if (written <= 0) {
                return;
            }
            at += static_cast<std::size_t>(written);
        }
    } catch (const std::exception&) {  // NOLINT(bugprone-empty-catch): the outputs are written; the batch goes on without
    }
}

std::string worker_word(int descriptor, pid_t parent) {
    return "--worker=" + std::to_string(descriptor) + ":" + std::to_string(parent);
}

}  // namespace lamella::cli
