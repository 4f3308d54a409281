#include "processes/process.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "files/mesh_input.hpp"
#include "terminal/console.hpp"

namespace lamella::cli {

namespace {

constexpr std::chrono::milliseconds patience{2000};  ///< between asking a process to end and killing it
constexpr std::chrono::milliseconds between_looks{100};
constexpr std::size_t most_text = std::size_t{1} << 20;  ///< of one process that is kept

constexpr const char* cannot_start = "cannot start a process for a mesh: ";

Failure no_process(int error_number) {
    return {bad_input, cannot_start + std::generic_category().message(error_number)};
}

pid_t spawn(std::vector<std::string> words, const std::string& folder, int output) {
    words.insert(words.begin(), "lamella");
    words.insert(words.begin() + 2, "--worker=" + std::to_string(::getpid()));
    std::vector<char*> pointers;
    pointers.reserve(words.size() + 1);
    for (std::string& word : words) {
        pointers.push_back(word.data());
    }
    pointers.push_back(nullptr);
    (void)std::signal(SIGCHLD, SIG_DFL);  // Where it is ignored, nobody learns how a process ended.
    const pid_t process = ::fork();
    if (process < 0) {
        throw no_process(errno);
    }
    if (process == 0) {  // until exec, only calls that need no lock of another thread
        ::setpgid(0, 0);
        const bool ready = ::dup2(::open("/dev/null", O_RDONLY | O_CLOEXEC), STDIN_FILENO) >= 0 &&
                           ::dup2(output, STDOUT_FILENO) >= 0 && ::dup2(output, STDERR_FILENO) >= 0 &&
                           (folder.empty() || ::chdir(folder.c_str()) == 0);
        // The link leads to this program even where its file was replaced meanwhile.
        if (ready) {
            ::execv("/proc/self/exe", pointers.data());
        }
        ::dprintf(output, "%s%s\n", cannot_start, ::strerrordesc_np(errno));
        ::_exit(bad_input);
    }
    return process;
}

/// Waits so long for the process to print something, and takes that. False when it has ended.
bool read_output(int output, std::string& text, std::chrono::milliseconds longest) {
    pollfd polled{.fd = output, .events = POLLIN, .revents = 0};
    if (::poll(&polled, 1, static_cast<int>(longest.count())) <= 0) {
        return true;
    }
    std::array<char, 4096> piece{};
    const ssize_t count = ::read(output, piece.data(), piece.size());
    text.append(piece.data(), static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
    if (text.size() > most_text) {
        text.erase(0, text.size() - most_text / 2);
    }
    return count > 0 || (count < 0 && errno == EINTR);
}

/// From here on this process ends when the one that started it does.
void end_with(pid_t starter) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != starter) {  // It has ended before.
        std::_Exit(bad_input);
    }
    std::ofstream("/proc/self/oom_score_adj") << "500";
}

/// Sets the failure of a process that ended with `status`, or its facts, by what it has printed: warnings, and in the end
/// the facts or the reason.
void set_outcome(int status, std::string_view text, ProcessEnd& end) {
    constexpr std::string_view before = "lamella: ";
    std::string last;
    for (const std::string_view line : split(text, '\n')) {
        if (Facts facts = Facts::parse(line, nullptr, false); facts.is_object()) {
            end.facts = std::move(facts);
        } else if (!line.empty() && !line.starts_with("lamella: warning: ")) {
            last = line.substr(line.starts_with(before) ? before.size() : 0);
        }
    }
    if (WIFSIGNALED(status)) {
        const int number = WTERMSIG(status);
        end.failure = "ended by signal " + std::to_string(number) + " (" + ::strsignal(number) + ")";
        end.lacked_memory = number == SIGKILL;  // as the system does when memory runs out
        end.may_retry = true;
    } else if (WEXITSTATUS(status) != 0) {
        end.failure = last.empty() ? "ended with exit status " + std::to_string(WEXITSTATUS(status)) : last;
        end.lacked_memory = last.ends_with("out of memory");
        end.may_retry = end.lacked_memory;
    }
}

}  // namespace

void declare_worker(CLI::App& command) {
    command.add_option_function<pid_t>("--worker", end_with)->group("");
}

ProcessEnd run_process(std::vector<std::string> words, const std::string& folder, double timeout_s,
                       const std::function<bool()>& stop) {
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) {
        throw no_process(errno);
    }
    const Descriptor reading(ends[0]);
    std::optional<Descriptor> writing(ends[1]);
    const pid_t process = spawn(std::move(words), folder, writing->number());
    writing.reset();  // so that the end of the process is the end of what it prints
    const Stopwatch watch;
    bool late = false;
    std::optional<double> asked_ms;
    std::string text;
    while (read_output(reading.number(), text, between_looks)) {
        late = late || (timeout_s > 0 && watch.ms() >= 1000 * timeout_s);
        if (late || stop()) {
            const bool kills = asked_ms && watch.ms() >= *asked_ms + static_cast<double>(patience.count());
            ::kill(process, kills ? SIGKILL : asked_ms ? 0 : SIGTERM);
            asked_ms = asked_ms.value_or(watch.ms());
        }
    }
    int status = 0;
    rusage used{};
    while (::wait4(process, &status, 0, &used) < 0 && errno == EINTR) {
    }
    // A process that starts as a copy of this one counts this one's memory, too.
    const std::uint64_t peak_bytes = static_cast<std::uint64_t>(used.ru_maxrss) * 1024;
    ProcessEnd end{.peak_bytes = peak_bytes > peak_rss_bytes() ? peak_bytes : 0};
    set_outcome(status, text, end);
    if (late) {
        end.failure = "took longer than " + exact_text(timeout_s) + " s";
        end.may_retry = true;
    }
    return end;
}

}  // namespace lamella::cli
