#include "golden/golden_file.hpp"

#include <cstdlib>
#include <fstream>
#include <iomanip>

#include <catch2/catch.hpp>

namespace golden {

namespace {

const std::string path = std::string(LAMELLA_TESTS_DIR) + "/golden/hashes.txt";

bool is_updating() {
    return std::getenv("LAMELLA_UPDATE_GOLDEN") != nullptr;  // NOLINT(concurrency-mt-unsafe)
}

std::string group_of(const std::string& name) {
    const std::size_t colon = name.find(": ");
    return colon == std::string::npos ? "" : name.substr(0, colon);
}

Hashes read_lines() {
    Hashes lines;
    std::ifstream in(path);
    std::uint64_t hash = 0;
    std::string name;
    while (in >> std::hex >> hash && std::getline(in >> std::ws, name)) {
        lines[name] = hash;
    }
    return lines;
}

void write_lines(const Hashes& lines) {
    std::ofstream out(path);
    for (const auto& [name, hash] : lines) {
        out << std::hex << std::setw(16) << std::setfill('0') << hash << ' ' << name << '\n';
    }
    REQUIRE(out.good());
}

}  // namespace

void add(Hashes& hashes, const std::string& name, std::uint64_t hash) {
    INFO(name);
    CHECK(hashes.emplace(name, hash).second);
}

void check_golden(const std::string& group, const Hashes& produced) {
    Hashes lines = read_lines();
    Hashes committed = lines;
    std::erase_if(committed, [&](const auto& line) { return group_of(line.first) != group; });
    Hashes found;
    for (const auto& [name, hash] : produced) {
        found.emplace(group.empty() ? name : group + ": " + name, hash);
    }
    if (is_updating()) {
        std::erase_if(lines, [&](const auto& line) { return committed.count(line.first) == 1; });
        lines.insert(found.begin(), found.end());
        write_lines(lines);
        return;
    }
    for (const auto& [name, hash] : found) {
        INFO(name << ", committed: " << committed.count(name));
        CHECK(committed[name] == hash);
        committed.erase(name);
    }
    for (const auto& [name, hash] : committed) {
        FAIL_CHECK("committed, but no longer produced: " << name);
    }
}

bool same_input(const std::string& name, std::uint64_t hash) {
    if (is_updating() || read_lines()["input: " + name] == hash) {
        return true;
    }
    FAIL_CHECK("the input differs, so that no result is compared: " << name);
    return false;
}

}  // namespace golden
