#include "processes/worker_side.hpp"

#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <thread>

#include <unistd.h>

#include <nlohmann/json.hpp>

#include "terminal/console.hpp"
#include "terminal/failure.hpp"

namespace lamella::cli {

namespace {

/// The batch holds the other end of standard input, and never writes to it: it ends with the batch, however that ends.
void end_with_batch() {
    std::thread([] {
        char none = 0;
        ssize_t got = 0;
        do {
            got = ::read(STDIN_FILENO, &none, 1);
        } while (got > 0 || (got < 0 && errno == EINTR));
        std::_Exit(bad_input);
    }).detach();
}

/// The system then rather ends a mesh than the batch.
void be_first_without_memory() {
    std::ofstream("/proc/self/oom_score_adj") << "500";
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
    command
        .add_flag_callback("--worker",
                           [] {
                               end_with_batch();
                               be_first_without_memory();
                           })
        ->group("");
}

void pass_on(const CLI::App& command, const SliceFacts& facts) {
    if (command.count("--worker") > 0) {
        nlohmann::ordered_json json = nlohmann::ordered_json::object();
        add_facts(json, facts);
        print(json.dump() + "\n");
    }
}

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

}  // namespace lamella::cli
