#include "processes/workers.hpp"

#include <csignal>
#include <cstring>
#include <new>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "files/text_input.hpp"
#include "terminal/console.hpp"

namespace lamella::cli {

namespace {

constexpr std::chrono::milliseconds patience{2000};  ///< between asking a process to end and killing it

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

/// The facts that a process passed on which printed `text`; none if it did not.
std::optional<SliceFacts> facts_at_end_of(std::string_view text) {
    const std::size_t before = text.rfind("\n{");
    std::string_view line = text.substr(before == std::string_view::npos ? 0 : before + 1);
    line = line.substr(0, line.find('\n'));
    try {
        return facts_of(nlohmann::ordered_json::parse(line));
    } catch (const nlohmann::json::exception&) {
        return std::nullopt;
    }
}

}  // namespace

void add_facts(nlohmann::ordered_json& json, const SliceFacts& facts) {
    json["triangles"] = facts.triangles;
    json["layers"] = facts.layers;
    json["contours"] = facts.contours;
    json["open_contours"] = facts.open_contours;
    json["close_gaps_mm"] = facts.close_gaps_mm;
    json["warnings"] = nlohmann::ordered_json::array();
    for (const std::string& warning : facts.warnings) {
        json["warnings"].push_back(printable(warning));
    }
}

SliceFacts facts_of(const nlohmann::ordered_json& json) {
    return {json.at("triangles").get<std::uint64_t>(), json.at("layers").get<std::uint64_t>(),
            json.at("contours").get<std::uint64_t>(),  json.at("open_contours").get<std::uint64_t>(),
            json.value("close_gaps_mm", 0.0),          json.at("warnings").get<std::vector<std::string>>()};
}

void declare_worker(CLI::App& command) {
    command.add_flag_callback("--worker", end_with_starter)->group("");
}

void pass_on(const CLI::App& command, const SliceFacts& facts) {
    if (command.count("--worker") > 0) {
        nlohmann::ordered_json json = nlohmann::ordered_json::object();
        add_facts(json, facts);
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
    workers_.push_back({item, ToolProcess(call), deadline});
}

std::vector<WorkerEnd> WorkerPool::wait(std::chrono::milliseconds longest) {
    std::vector<const ToolProcess*> processes;
    for (const Worker& worker : workers_) {
        processes.push_back(&worker.process);
    }
    wait_for_output(processes, longest);
    std::vector<WorkerEnd> ended;
    for (auto worker = workers_.begin(); worker != workers_.end();) {
        if (worker->process.read()) {
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
            worker.late ? worker.process.kill() : worker.process.ask_to_end();
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

WorkerEnd WorkerPool::end_of(Worker& worker) {
    const ProcessEnd how = worker.process.await();
    WorkerEnd end{.item = worker.item, .failure = {}, .facts = {}, .peak_bytes = how.peak_bytes};
    if (worker.late) {
        end.failure = "took longer than " + exact_text(timeout_s_) + " s";
        end.may_retry = true;
    } else if (how.signal_number != 0) {
        end.failure = reason_of_signal(how.signal_number);
        end.may_retry = true;
        end.lacked_memory = how.signal_number == SIGKILL;
    } else if (how.exit_status != 0) {
        end.failure = last_message(worker.process.text());
        end.lacked_memory = end.failure.ends_with("out of memory");
        end.may_retry = end.lacked_memory;
        if (end.failure.empty()) {
            end.failure = "ended with exit status " + std::to_string(how.exit_status);
        }
    } else {
        end.facts = facts_at_end_of(worker.process.text());
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
