#include "golden/golden_file.hpp"

#include <cstdlib>
#include <fstream>
#include <iomanip>
#include <sstream>
#include <utility>

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

Group::Group(std::string name) : name_(std::move(name)) {
    for (const auto& [line, hash] : read_lines()) {
        if (group_of(line) == name_) {
            committed_[line] = hash;
        }
    }
}

void Group::output(const std::string& name, std::uint64_t hash) {
    const std::string full_name = name_.empty() ? name : name_ + ": " + name;
    INFO(full_name);
    CHECK(group_of(full_name) == name_);
    CHECK(produced_.emplace(full_name, hex(hash)).second);  // names are distinct
    if (!is_updating()) {
        const auto line = committed_.find(full_name);
        CHECK((line == committed_.end() ? "nothing committed" : line->second) == hex(hash));
    }
}

void Group::finish() {
    if (is_updating()) {
        Lines lines = read_lines();
        for (const auto& [name, hash] : committed_) {
            lines.erase(name);
        }
        lines.insert(produced_.begin(), produced_.end());
        write_lines(lines);
        return;
    }
    for (const auto& [name, hash] : committed_) {
        INFO("committed, but no longer produced: " << name);
        CHECK(produced_.count(name) == 1);
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
