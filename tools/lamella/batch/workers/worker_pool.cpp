#include "batch/workers/worker_pool.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "terminal/console.hpp"
#include "terminal/failure.hpp"
#include "worker/worker_side.hpp"

namespace lamella::cli::batch {

namespace {

constexpr int facts_descriptor = 3;                      ///< in the process
constexpr std::size_t most_text = std::size_t{1} << 20;  ///< of messages and facts that are kept
constexpr std::chrono::milliseconds patience{2000};      ///< between asking a process to end and killing it
constexpr const char* own_program = "/proc/self/exe";

Failure no_process(int error_number) {
    return {bad_input, "cannot start a process for a mesh: " + std::generic_category().message(error_number)};
}

struct Pipe {
    std::array<int, 2> ends = {-1, -1};

    Pipe() {
        if (::pipe2(ends.data(), O_CLOEXEC) != 0) {
            throw no_process(errno);
        }
        (void)::fcntl(ends[0], F_SETFL, O_NONBLOCK);
    }
    ~Pipe() {
        for (const int end : ends) {
            if (end >= 0) {
                ::close(end);
            }
        }
    }
    Pipe(const Pipe&) = delete;
    Pipe& operator=(const Pipe&) = delete;

    int release_reading() noexcept { return std::exchange(ends[0], -1); }
};

/// A process begins with the signals that this one handles at their defaults, and in a group of its own: Ctrl-C reaches the
/// batch alone, which then ends its processes.
struct SpawnRules {
    posix_spawn_file_actions_t actions{};
    posix_spawnattr_t attributes{};

    SpawnRules(int nothing, int messages, int facts) {
        posix_spawn_file_actions_init(&actions);
        posix_spawnattr_init(&attributes);
        posix_spawn_file_actions_adddup2(&actions, nothing, STDIN_FILENO);
        posix_spawn_file_actions_adddup2(&actions, nothing, STDOUT_FILENO);
        posix_spawn_file_actions_adddup2(&actions, messages, STDERR_FILENO);
        posix_spawn_file_actions_adddup2(&actions, facts, facts_descriptor);
        sigset_t signals;
        sigemptyset(&signals);
        posix_spawnattr_setsigmask(&attributes, &signals);
        sigaddset(&signals, SIGPIPE);
        sigaddset(&signals, SIGXFSZ);
        posix_spawnattr_setsigdefault(&attributes, &signals);
        posix_spawnattr_setpgroup(&attributes, 0);
        posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
    }
    ~SpawnRules() {
        posix_spawn_file_actions_destroy(&actions);
        posix_spawnattr_destroy(&attributes);
    }
    SpawnRules(const SpawnRules&) = delete;
    SpawnRules& operator=(const SpawnRules&) = delete;
};

/// The last line that is no warning: why slice failed.
std::string last_message(const std::string& text) {
    constexpr std::string_view before = "lamella: ";
    constexpr std::string_view warning = "lamella: warning: ";
    std::string last;
    for (std::size_t begin = 0; begin < text.size();) {
        const std::size_t end = std::min(text.find('\n', begin), text.size());
        const std::string_view line = std::string_view(text).substr(begin, end - begin);
        if (!line.empty() && !line.starts_with(warning)) {
            last = line.substr(line.starts_with(before) ? before.size() : 0);
        }
        begin = end + 1;
    }
    return last;
}

/// How many processes the system has killed for want of memory since it was started, its control groups' included.
std::uint64_t kills_without_memory() {
    std::ifstream file("/proc/vmstat");
    std::string name;
    std::uint64_t count = 0;
    while (file >> name >> count) {
        if (name == "oom_kill") {
            return count;
        }
    }
    return 0;
}

double seconds(const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

}  // namespace

WorkerPool::WorkerPool(double timeout_s)
    : timeout_s_(timeout_s),
      nothing_(::open("/dev/null", O_RDWR | O_CLOEXEC)),
      kills_without_memory_(kills_without_memory()) {
    if (nothing_ < 0) {
        throw no_process(errno);
    }
}

WorkerPool::~WorkerPool() {
    end_all();
    ::close(nothing_);
}

void WorkerPool::start(std::size_t item, const std::string& command, const std::vector<std::string>& words) {
    std::vector<std::string> all = {"lamella", command, worker_word(facts_descriptor)};
    all.insert(all.end(), words.begin(), words.end());
    std::vector<char*> pointers;
    pointers.reserve(all.size() + 1);
    for (std::string& word : all) {
        pointers.push_back(word.data());
    }
    pointers.push_back(nullptr);
    Pipe facts;
    Pipe messages;
    const SpawnRules rules(nothing_, messages.ends[1], facts.ends[1]);
    Worker worker;
    workers_.reserve(workers_.size() + 1);
    const int refused =
        ::posix_spawn(&worker.process, own_program, &rules.actions, &rules.attributes, pointers.data(), environ);
    if (refused != 0) {
        throw no_process(refused);
    }
    worker.item = item;
    worker.facts = facts.release_reading();
    worker.messages = messages.release_reading();
    if (timeout_s_ > 0) {
        worker.deadline =
            Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(timeout_s_));
    }
    workers_.push_back(std::move(worker));
}

std::vector<WorkerEnd> WorkerPool::wait(std::chrono::milliseconds longest) {
    std::vector<pollfd> polled;
    for (const Worker& worker : workers_) {
        polled.push_back({worker.facts, POLLIN, 0});
        polled.push_back({worker.messages, POLLIN, 0});
    }
    (void)::poll(polled.data(), polled.size(), static_cast<int>(longest.count()));
    std::vector<WorkerEnd> ended;
    std::vector<Worker> running;
    for (Worker& worker : workers_) {
        bool over = false;
        bool ignored = false;
        drain(worker.messages, worker.message_text, ignored);
        drain(worker.facts, worker.facts_text, over);
        if (over) {
            drain(worker.messages, worker.message_text, ignored);
            ended.push_back(reap(worker));
        } else {
            running.push_back(std::move(worker));
        }
    }
    workers_ = std::move(running);
    end_late_ones();
    return ended;
}

void WorkerPool::drain(int descriptor, std::string& text, bool& ended) {
    std::array<char, 4096> piece{};
    while (true) {
        const ssize_t count = ::read(descriptor, piece.data(), piece.size());
        if (count <= 0) {
            ended = count == 0;
            return;
        }
        text.append(piece.data(), static_cast<std::size_t>(count));
        if (text.size() > most_text) {
            text.erase(0, text.size() - most_text / 2);
        }
    }
}

void WorkerPool::end_late_ones() {
    const Clock::time_point now = Clock::now();
    for (Worker& worker : workers_) {
        if (now >= worker.deadline) {
            ::kill(worker.process, worker.late ? SIGKILL : SIGTERM);
            worker.late = true;
            worker.deadline = now + patience;
        }
    }
}

std::string WorkerPool::reason_of_signal(int signal_number) {
    const std::uint64_t kills = kills_without_memory();
    if (signal_number == SIGKILL && kills > kills_without_memory_) {
        kills_without_memory_ = kills;
        return "was ended by the system, whose memory ran out";
    }
    return "ended by signal " + std::to_string(signal_number) + " (" + ::strsignal(signal_number) + ")";
}

WorkerEnd WorkerPool::reap(Worker& worker) {
    int status = 0;
    rusage used{};
    while (::wait4(worker.process, &status, 0, &used) < 0 && errno == EINTR) {
    }
    ::close(worker.facts);
    ::close(worker.messages);
    WorkerEnd end;
    end.item = worker.item;
    end.peak_bytes = static_cast<std::uint64_t>(used.ru_maxrss) * 1024;
    end.cpu_s = seconds(used.ru_utime) + seconds(used.ru_stime);
    if (worker.late) {
        end.failure = "took longer than " + exact_text(timeout_s_) + " s";
        end.may_retry = true;
    } else if (WIFSIGNALED(status)) {
        const int signal_number = WTERMSIG(status);
        end.failure = reason_of_signal(signal_number);
        end.may_retry = true;
        end.lacked_memory = signal_number == SIGKILL;
    } else if (WEXITSTATUS(status) != 0) {
        end.failure = last_message(worker.message_text);
        end.lacked_memory = end.failure.ends_with("out of memory");
        end.may_retry = end.lacked_memory;
        if (end.failure.empty()) {
            end.failure = "ended with exit status " + std::to_string(WEXITSTATUS(status));
        }
    } else {
        end.facts = parse_facts(worker.facts_text);
    }
    return end;
}

void WorkerPool::end_all() noexcept {
    for (const Worker& worker : workers_) {
        ::kill(worker.process, SIGTERM);
    }
    const Clock::time_point until = Clock::now() + patience;
    for (const Worker& worker : workers_) {
        while (::waitpid(worker.process, nullptr, WNOHANG) == 0) {
            if (Clock::now() >= until) {
                ::kill(worker.process, SIGKILL);
            }
            ::usleep(5000);
        }
        ::close(worker.facts);
        ::close(worker.messages);
    }
    workers_.clear();
}

}  // namespace lamella::cli::batch
