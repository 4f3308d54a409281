#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <system_error>
#include <thread>

#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/system/machine.hpp"
#include "system/process.hpp"

namespace lamella::cli {

namespace {

/// The number after `key` in a file of the system, in which it counts kilobytes; 0 if it is not there.
std::uint64_t system_bytes(const char* path, std::string_view key) {
    std::ifstream file(path);
    std::uint64_t kilobytes = 0;
    for (std::string word; file >> word;) {
        if (word == key && file >> kilobytes) {
            return kilobytes * 1024;
        }
    }
    return 0;
}

/// Takes no lock, which glibc's strerror() may.
const char* text_of_error(int number) {
#ifdef __GLIBC__
    return ::strerrordesc_np(number);
#else
    return std::strerror(number);
#endif
}

/// Until exec, only calls that need no lock of another thread.
[[noreturn]] void run_program(char* const* words, const std::string& folder, int output, int exit_status) {
    ::setpgid(0, 0);
    const bool ready = ::dup2(::open("/dev/null", O_RDONLY | O_CLOEXEC), STDIN_FILENO) >= 0 &&
                       ::dup2(output, STDOUT_FILENO) >= 0 && ::dup2(output, STDERR_FILENO) >= 0 &&
                       (folder.empty() || ::chdir(folder.c_str()) == 0);
    // The link leads to this program even where its file was replaced meanwhile.
    if (ready) {
        ::execv("/proc/self/exe", words);
    }
    ::dprintf(output, "%s%s\n", cannot_start, text_of_error(errno));
    ::_exit(exit_status);
}

}  // namespace

void take_signals(void (*take)(void* own, int number), void* own) {
    sigset_t signals;
    sigemptyset(&signals);
    for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
        // A caller that ignores a signal (nohup, a shell's background jobs) means it for its children too.
        struct sigaction action {};
        if (::sigaction(number, nullptr, &action) != 0 || action.sa_handler != SIG_IGN) {
            sigaddset(&signals, number);
        }
    }
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    // A closed pipe and a file size limit become errors of write(), reported like a full disk.
    (void)std::signal(SIGPIPE, SIG_IGN);
    (void)std::signal(SIGXFSZ, SIG_IGN);
    std::thread([=] {
        for (int number = 0; sigwait(&signals, &number) == 0;) {
            take(own, number);
        }
    }).detach();
}

void end_by_signal(int number) noexcept {
    sigset_t only;
    sigemptyset(&only);
    sigaddset(&only, number);
    (void)std::signal(number, SIG_DFL);
    pthread_sigmask(SIG_UNBLOCK, &only, nullptr);
    (void)::raise(number);
}

ChildProcess::ChildProcess(std::vector<std::string> words, const std::string& folder, int exit_status_of_no_program) {
    words.insert(words.begin(), "lamella");
    words.insert(words.begin() + 2, "--worker=" + std::to_string(process_number()));
    std::vector<char*> pointers;
    pointers.reserve(words.size() + 1);
    for (std::string& word : words) {
        pointers.push_back(word.data());
    }
    pointers.push_back(nullptr);
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) {
        throw std::system_error(errno, std::generic_category());
    }
    (void)std::signal(SIGCHLD, SIG_DFL);  // Where it is ignored, nobody learns how a process ended.
    const pid_t process = ::fork();
    if (process == 0) {
        run_program(pointers.data(), folder, ends[1], exit_status_of_no_program);
    }
    const int failure = process < 0 ? errno : 0;
    ::close(ends[1]);  // so that the end of the process is the end of what it prints
    if (failure != 0) {
        ::close(ends[0]);
        throw std::system_error(failure, std::generic_category());
    }
    output_ = ends[0];
    process_ = process;
}

ChildProcess::~ChildProcess() {
    ::close(static_cast<int>(output_));
}

bool ChildProcess::read_output(std::string& text, std::chrono::milliseconds longest) {
    const int output = static_cast<int>(output_);
    pollfd polled{.fd = output, .events = POLLIN, .revents = 0};
    if (::poll(&polled, 1, static_cast<int>(longest.count())) <= 0) {
        return true;
    }
    std::array<char, 4096> piece{};
    const ssize_t count = ::read(output, piece.data(), piece.size());
    text.append(piece.data(), static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
    return count > 0 || (count < 0 && errno == EINTR);
}

void ChildProcess::ask_to_end() noexcept {
    ::kill(static_cast<pid_t>(process_), SIGTERM);
}

void ChildProcess::kill() noexcept {
    ::kill(static_cast<pid_t>(process_), SIGKILL);
}

ProcessOutcome ChildProcess::wait() {
    int status = 0;
    rusage used{};
    while (::wait4(static_cast<pid_t>(process_), &status, 0, &used) < 0 && errno == EINTR) {
    }
    // A process that starts as a copy of this one counts this one's memory, too.
    const std::uint64_t peak_bytes = static_cast<std::uint64_t>(used.ru_maxrss) * 1024;
    ProcessOutcome outcome{.peak_bytes = peak_bytes > peak_rss_bytes() ? peak_bytes : 0};
    if (WIFSIGNALED(status)) {
        const int number = WTERMSIG(status);
        outcome.crash = "ended by signal " + std::to_string(number) + " (" + ::strsignal(number) + ")";
        outcome.lacked_memory = number == SIGKILL;  // as the system does when memory runs out
    } else {
        outcome.exit_status = WEXITSTATUS(status);
    }
    return outcome;
}

bool end_with(std::uint64_t starter) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    std::ofstream("/proc/self/oom_score_adj") << "500";
    return static_cast<std::uint64_t>(::getppid()) == starter;
}

std::filesystem::path program_path() {
    std::error_code unknown;
    return std::filesystem::read_symlink("/proc/self/exe", unknown);
}

bool runs_this_program(std::uint64_t process) {
    std::error_code unknown;
    const std::filesystem::path own = program_path();
    const std::filesystem::path other = std::filesystem::read_symlink("/proc/" + std::to_string(process) + "/exe", unknown);
    return !unknown && own == other && !own.empty() && process != process_number();
}

std::uint64_t peak_rss_bytes() {
    // Not getrusage(): what it reports survives exec, so a large parent process would be reported instead.
    return system_bytes("/proc/self/status", "VmHWM:");
}

int granted_processors() {
    cpu_set_t set;
    CPU_ZERO(&set);
    return ::sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
}

std::uint64_t free_memory_bytes() {
    return system_bytes("/proc/meminfo", "MemAvailable:");
}

}  // namespace lamella::cli
