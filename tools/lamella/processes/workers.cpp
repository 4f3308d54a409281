#include "processes/workers.hpp"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <new>
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

#include <nlohmann/json.hpp>

#include "terminal/console.hpp"
#include "terminal/numbers.hpp"

namespace lamella::cli {

namespace {

constexpr std::chrono::milliseconds patience{2000};      ///< between asking a process to end and killing it
constexpr std::size_t most_text = std::size_t{1} << 20;  ///< of one process that is kept
constexpr const char* own_program = "/proc/self/exe";    ///< also where its file was replaced meanwhile

Failure no_process(int error_number) {
    return {bad_input, "cannot start a process for a mesh: " + std::generic_category().message(error_number)};
}

struct Pipe {
    Descriptor reading;
    Descriptor writing;
};

/// In the place of no standard stream, of which some may be closed, and inherited by no other process.
Pipe pipe_above_streams() {
    std::array<int, 2> ends{};
    if (::pipe(ends.data()) != 0) {
        throw no_process(errno);
    }
    const std::array<Descriptor, 2> low = {Descriptor(ends[0]), Descriptor(ends[1])};
    Pipe pipe{Descriptor(::fcntl(ends[0], F_DUPFD_CLOEXEC, STDERR_FILENO + 1)),
              Descriptor(::fcntl(ends[1], F_DUPFD_CLOEXEC, STDERR_FILENO + 1))};
    if (pipe.reading.number() < 0 || pipe.writing.number() < 0) {
        throw no_process(errno);
    }
    return pipe;
}

pid_t spawn(const ToolCall& call, int input, int output) {
    std::vector<std::string> words = {"lamella", call.command, "--worker"};
    words.insert(words.end(), call.words.begin(), call.words.end());
    std::vector<char*> pointers;
    pointers.reserve(words.size() + 1);
    for (std::string& word : words) {
        pointers.push_back(word.data());
    }
    pointers.push_back(nullptr);
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    ::posix_spawn_file_actions_init(&files);
    ::posix_spawnattr_init(&attributes);
    ::posix_spawn_file_actions_adddup2(&files, input, STDIN_FILENO);
    ::posix_spawn_file_actions_adddup2(&files, output, STDOUT_FILENO);
    ::posix_spawn_file_actions_adddup2(&files, output, STDERR_FILENO);
    if (!call.folder.empty()) {
        ::posix_spawn_file_actions_addchdir_np(&files, call.folder.c_str());
    }
    ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    (void)std::signal(SIGCHLD, SIG_DFL);  // Where it is ignored, nobody learns how a process ended.
    pid_t process = -1;
    const int error_number = ::posix_spawn(&process, own_program, &files, &attributes, pointers.data(), environ);
    ::posix_spawn_file_actions_destroy(&files);
    ::posix_spawnattr_destroy(&attributes);
    if (error_number != 0) {
        throw no_process(error_number);
    }
    return process;
}

/// Takes what a process has printed. False when it has ended.
bool read_output(int output, std::string& text) {
    std::array<char, 4096> piece{};
    while (true) {
        const ssize_t count = ::read(output, piece.data(), piece.size());
        if (count <= 0) {
            return count < 0;
        }
        text.append(piece.data(), static_cast<std::size_t>(count));
        if (text.size() > most_text) {
            text.erase(0, text.size() - most_text / 2);
        }
    }
}

/// From here on this process ends when its standard input does, and the system chooses it first when memory runs out.
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

/// The last line that is no warning: why slice failed.
std::string last_message(std::string_view text) {
    constexpr std::string_view before = "lamella: ";
    constexpr std::string_view warning = "lamella: warning: ";
    std::string last;
    for (const std::string_view line : split(text, '\n')) {
        if (!line.empty() && !line.starts_with(warning)) {
            last = line.substr(line.starts_with(before) ? before.size() : 0);
        }
    }
    return last;
}

/// How many processes the system has killed for want of memory since it was started, its control groups' included.
std::uint64_t kills_without_memory() {
    return system_number("/proc/vmstat", "oom_kill").value_or(0);
}

/// The facts that a process passed on which printed `text`; empty if it did not.
nlohmann::ordered_json facts_at_end_of(std::string_view text) {
    const std::size_t before = text.rfind("\n{");
    std::string_view line = text.substr(before == std::string_view::npos ? 0 : before + 1);
    line = line.substr(0, line.find('\n'));
    nlohmann::ordered_json facts = nlohmann::ordered_json::parse(line, nullptr, false);
    return facts.is_object() ? facts : nlohmann::ordered_json::object();
}

}  // namespace

void declare_worker(CLI::App& command) {
    command.add_flag_callback("--worker", end_with_starter)->group("");
}

void pass_on(const CLI::App& command, const SliceFacts& facts) {
    if (command.count("--worker") > 0) {
        nlohmann::ordered_json json = {{"triangles", facts.triangles}, {"layers", facts.layers},
                                       {"contours", facts.contours},   {"open_contours", facts.open_contours},
                                       {"stitch_mm", facts.stitch_mm}, {"warnings", nlohmann::ordered_json::array()}};
        for (const std::string& warning : facts.warnings) {
            json["warnings"].push_back(printable(warning));
        }
        print(json.dump() + "\n");
    }
}

WorkerPool::WorkerPool(double timeout_s) : timeout_s_(timeout_s), kills_without_memory_(kills_without_memory()) {}

void WorkerPool::start(std::size_t item, const ToolCall& call) {
    const auto deadline =
        timeout_s_ > 0
            ? Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(timeout_s_))
            : Clock::time_point::max();
    workers_.reserve(workers_.size() + 1);
    Pipe life = pipe_above_streams();
    Pipe output = pipe_above_streams();
    (void)::fcntl(output.reading.number(), F_SETFL, O_NONBLOCK);
    const pid_t process = spawn(call, life.reading.number(), output.writing.number());
    workers_.push_back({item, process, std::move(life.writing), std::move(output.reading), deadline});
}

std::vector<WorkerEnd> WorkerPool::wait(std::chrono::milliseconds longest) {
    std::vector<pollfd> polled;
    for (const Worker& worker : workers_) {
        polled.push_back({worker.output.number(), POLLIN, 0});
    }
    (void)::poll(polled.data(), polled.size(), static_cast<int>(longest.count()));
    std::vector<WorkerEnd> ended;
    for (auto worker = workers_.begin(); worker != workers_.end();) {
        if (read_output(worker->output.number(), worker->text)) {
            ++worker;
        } else {
            ended.push_back(end_of(*worker));
            worker = workers_.erase(worker);
        }
    }
    end_late_ones();
    return ended;
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

WorkerEnd WorkerPool::end_of(const Worker& worker) {
    int status = 0;
    rusage used{};
    while (::wait4(worker.process, &status, 0, &used) < 0 && errno == EINTR) {
    }
    // A process that starts as a copy of this one counts this one's memory, too.
    const std::uint64_t peak_bytes = static_cast<std::uint64_t>(used.ru_maxrss) * 1024;
    WorkerEnd end{.item = worker.item, .peak_bytes = peak_bytes > peak_rss_bytes() ? peak_bytes : 0};
    if (worker.late) {
        end.failure = "took longer than " + exact_text(timeout_s_) + " s";
        end.may_retry = true;
    } else if (WIFSIGNALED(status)) {
        end.failure = reason_of_signal(WTERMSIG(status));
        end.may_retry = true;
        end.lacked_memory = WTERMSIG(status) == SIGKILL;
    } else if (WEXITSTATUS(status) != 0) {
        end.failure = last_message(worker.text);
        end.lacked_memory = end.failure.ends_with("out of memory");
        end.may_retry = end.lacked_memory;
        if (end.failure.empty()) {
            end.failure = "ended with exit status " + std::to_string(WEXITSTATUS(status));
        }
    } else {
        end.facts = facts_at_end_of(worker.text);
    }
    return end;
}

WorkerPool::~WorkerPool() {
    for (Worker& worker : workers_) {
        worker.deadline = Clock::now();
    }
    end_late_ones();
    try {
        while (!workers_.empty()) {
            (void)wait(std::chrono::milliseconds(100));
        }
    } catch (const std::bad_alloc&) {  // They end with what they read from.
        workers_.clear();
    }
}

}  // namespace lamella::cli
