#include "batch/workers/worker_pool.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "terminal/console.hpp"

namespace lamella::cli::batch {

namespace {

constexpr std::size_t most_text = std::size_t{1} << 20;  ///< of messages and facts that are kept
constexpr std::chrono::milliseconds patience{2000};      ///< between asking a process to end and killing it

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

WorkerPool::WorkerPool(WorkerStarter& starter, double timeout_s)
    : starter_(starter), timeout_s_(timeout_s), kills_without_memory_(kills_without_memory()) {}

WorkerPool::~WorkerPool() {
    end_all();
}

void WorkerPool::start(std::size_t item, const WorkerCall& call) {
    Pipe facts;
    Pipe messages;
    Worker worker;
    workers_.reserve(workers_.size() + 1);
    worker.process = starter_.start(call, facts.ends[1], messages.ends[1]);
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
    const auto [status, used] = *starter_.end_of(worker.process, true);
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
        while (still_runs(worker)) {
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

bool WorkerPool::still_runs(const Worker& worker) noexcept {
    try {
        return !starter_.end_of(worker.process, false).has_value();
    } catch (const Failure&) {  // Workers end with their starter.
        return false;
    }
}

}  // namespace lamella::cli::batch
