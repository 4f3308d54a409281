#include "golden/golden_file.hpp"

#include <cstdlib>
#include <fstream>
#include <iomanip>
#include <sstream>

#include <catch2/catch.hpp>

namespace golden {

namespace {

const std::string path = std::string(LAMELLA_TESTS_DIR) + "/golden/hashes.txt";

using Lines = std::map<std::string, std::string>;  // hash by name

bool is_updating() {
    return std::getenv("LAMELLA_UPDATE_GOLDEN") != nullptr;  // NOLINT(concurrency-mt-unsafe)
}

std::string hex(std::uint64_t hash) {
    std::ostringstream out;
    out << std::hex << std::setw(16) << std::setfill('0') << hash;
    return out.str();
}

std::string group_of(const std::string& name) {
    const std::size_t colon = name.find(": ");
    return colon == std::string::npos ? "" : name.substr(0, colon);
}

Lines read_lines() {
    Lines lines;
    std::ifstream in(path);
    std::string hash;
    std::string name;
    while (in >> hash && std::getline(in >> std::ws, name)) {
        lines[name] = hash;
    }
    return lines;
}

void write_lines(const Lines& lines) {
    std::ofstream out(path);
    for (const auto& [name, hash] : lines) {
        out << hash << ' ' << name << '\n';
    }
    REQUIRE(out.good());
}

}  // namespace

void add(Hashes& hashes, const std::string& name, std::uint64_t hash) {
    INFO(name);
    CHECK(hashes.emplace(name, hash).second);
}

void check_golden(const std::string& group, const Hashes& produced) {
    Lines lines = read_lines();
    Lines committed = lines;
    std::erase_if(committed, [&](const auto& line) { return group_of(line.first) != group; });
    Lines found;
    for (const auto& [name, hash] : produced) {
        found.emplace(group.empty() ? name : group + ": " + name, hex(hash));
    }
    if (is_updating()) {
        std::erase_if(lines, [&](const auto& line) { return committed.count(line.first) == 1; });
        lines.insert(found.begin(), found.end());
        write_lines(lines);
        return;
    }
    for (const auto& [name, hash] : found) {
        INFO(name);
        const auto line = committed.find(name);
        CHECK((line == committed.end() ? "nothing committed" : line->second) == hash);
    }
    for (const auto& [name, hash] : committed) {
        INFO("committed, but no longer produced: " << name);
        CHECK(found.count(name) == 1);
    }
}

bool same_input(const std::string& name, std::uint64_t hash) {
    const Lines lines = read_lines();
    const auto line = lines.find("input: " + name);
    if (is_updating() || (line != lines.end() && line->second == hex(hash))) {
        return true;
    }
    FAIL_CHECK("the input differs, so that no result is compared: " << name);
    return false;
}

}  // namespace golden
