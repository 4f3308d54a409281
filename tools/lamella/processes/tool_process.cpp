#include "processes/tool_process.hpp"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "terminal/console.hpp"
#include "terminal/failure.hpp"

namespace lamella::cli {

namespace {

constexpr std::size_t most_text = std::size_t{1} << 20;  ///< of one process that is kept
constexpr const char* own_program = "/proc/self/exe";    ///< also where its file was replaced meanwhile

Failure no_process(int error_number) {
    return {bad_input, "cannot start a process for a mesh: " + std::generic_category().message(error_number)};
}

/// The same in the place of no standard stream, of which some may be closed, and inherited by no other process.
Descriptor above_streams(const Descriptor& descriptor) {
    const int above = ::fcntl(descriptor.number(), F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
    if (above < 0) {
        throw no_process(errno);
    }
    return Descriptor(above);
}

/// How a process is to be started.
struct SpawnSettings {
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;

    SpawnSettings() {
        ::posix_spawn_file_actions_init(&files);
        ::posix_spawnattr_init(&attributes);
    }
    ~SpawnSettings() {
        ::posix_spawn_file_actions_destroy(&files);
        ::posix_spawnattr_destroy(&attributes);
    }
    SpawnSettings(const SpawnSettings&) = delete;
    SpawnSettings& operator=(const SpawnSettings&) = delete;
};

/// The environment of this process, but for the date of the call.
std::vector<std::string> environment_of(const ToolCall& call) {
    constexpr std::string_view date = "SOURCE_DATE_EPOCH=";
    std::vector<std::string> all;
    for (char** variable = environ; *variable != nullptr; ++variable) {
        if (!call.date_of_build || !std::string_view(*variable).starts_with(date)) {
            all.emplace_back(*variable);
        }
    }
    if (call.date_of_build && !call.date_of_build->empty()) {
        all.push_back(std::string(date) + *call.date_of_build);
    }
    return all;
}

std::vector<char*> pointers_to(std::vector<std::string>& words) {
    std::vector<char*> pointers;
    pointers.reserve(words.size() + 1);
    for (std::string& word : words) {
        pointers.push_back(word.data());
    }
    pointers.push_back(nullptr);
    return pointers;
}

pid_t spawn(const ToolCall& call, int input, int output) {
    std::vector<std::string> words = {"lamella", call.command, "--worker"};
    words.insert(words.end(), call.words.begin(), call.words.end());
    std::vector<std::string> environment = environment_of(call);
    SpawnSettings settings;
    ::posix_spawn_file_actions_adddup2(&settings.files, input, STDIN_FILENO);
    ::posix_spawn_file_actions_adddup2(&settings.files, output, STDOUT_FILENO);
    ::posix_spawn_file_actions_adddup2(&settings.files, output, STDERR_FILENO);
    if (!call.folder.empty()) {
        ::posix_spawn_file_actions_addchdir_np(&settings.files, call.folder.c_str());
    }
    ::posix_spawnattr_setflags(&settings.attributes, POSIX_SPAWN_SETPGROUP);
    (void)std::signal(SIGCHLD, SIG_DFL);  // Where it is ignored, nobody learns how a process ended.
    pid_t process = -1;
    const int error_number = ::posix_spawn(&process, own_program, &settings.files, &settings.attributes,
                                           pointers_to(words).data(), pointers_to(environment).data());
    if (error_number != 0) {
        throw no_process(error_number);
    }
    return process;
}

}  // namespace

ToolProcess::Pipe ToolProcess::Pipe::make() {
    std::array<int, 2> ends{};
    if (::pipe(ends.data()) != 0) {
        throw no_process(errno);
    }
    const Descriptor reading(ends[0]);
    const Descriptor writing(ends[1]);
    return {above_streams(reading), above_streams(writing)};
}

ToolProcess::ToolProcess(const ToolCall& call) : ToolProcess(call, Pipe::make(), Pipe::make()) {}

ToolProcess::ToolProcess(const ToolCall& call, Pipe input, Pipe output)
    : life_(std::move(input.writing)),
      output_(std::move(output.reading)),
      process_(spawn(call, input.reading.number(), output.writing.number())) {
    (void)::fcntl(output_.number(), F_SETFL, O_NONBLOCK);
}

bool ToolProcess::read() {
    std::array<char, 4096> piece{};
    while (true) {
        const ssize_t count = ::read(output_.number(), piece.data(), piece.size());
        if (count <= 0) {
            return count < 0;
        }
        text_.append(piece.data(), static_cast<std::size_t>(count));
        if (text_.size() > most_text) {
            text_.erase(0, text_.size() - most_text / 2);
        }
    }
}

ProcessEnd ToolProcess::await() {
    int status = 0;
    rusage used{};
    while (::wait4(process_, &status, 0, &used) < 0 && errno == EINTR) {
    }
    // A process that starts as a copy of this one counts this one's memory, too.
    const std::uint64_t peak_bytes = static_cast<std::uint64_t>(used.ru_maxrss) * 1024;
    return {.exit_status = WIFEXITED(status) ? WEXITSTATUS(status) : 0,
            .signal_number = WIFSIGNALED(status) ? WTERMSIG(status) : 0,
            .peak_bytes = peak_bytes > peak_rss_bytes() ? peak_bytes : 0};
}

void ToolProcess::ask_to_end() const noexcept {
    ::kill(process_, SIGTERM);
}

void ToolProcess::kill() const noexcept {
    ::kill(process_, SIGKILL);
}

void end_with_starter() {
    // The other process holds the other end of standard input, and never writes to it: it ends with that, however that ends.
    std::thread([] {
        char none = 0;
        ssize_t got = 0;
        do {
            got = ::read(STDIN_FILENO, &none, 1);
        } while (got > 0 || (got < 0 && errno == EINTR));
        std::_Exit(bad_input);
    }).detach();
    std::ofstream("/proc/self/oom_score_adj") << "500";  // The system then rather ends a mesh than the batch.
}

void wait_for_output(const std::vector<const ToolProcess*>& processes, std::chrono::milliseconds longest) {
    std::vector<pollfd> polled;
    polled.reserve(processes.size());
    for (const ToolProcess* const process : processes) {
        polled.push_back({process->output(), POLLIN, 0});
    }
    (void)::poll(polled.data(), polled.size(), static_cast<int>(longest.count()));
}

}  // namespace lamella::cli
