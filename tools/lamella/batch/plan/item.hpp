// One mesh of a batch: what is sliced, how, and into which files.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace lamella::cli::batch {

/// A file that decides what comes out, as it was found: with its time, or with its content by --hash.
struct InputFact {
    std::string path;
    std::uint64_t bytes = 0;
    std::int64_t modified_ns = 0;  ///< since 1970; 0 with a hash
    std::string sha256;            ///< empty without --hash

    bool operator==(const InputFact&) const = default;
};

struct Item {
    std::string mesh;
    std::vector<std::string> words;    ///< options that decide what comes out: "--layer-height=0.5"
    std::vector<std::string> plain;    ///< options that do not: "--map"
    std::vector<std::string> outputs;  ///< as slice takes them
    std::string to;                    ///< formats
    std::string report;
    std::vector<std::string> files;  ///< all that come to lie on disk, but for the report; the first one names the item
    std::vector<std::string> option_files;  ///< that the options name: images, planes, transforms
    std::optional<int> threads;             ///< asked for
    std::string place;                      ///< FILE:LINE of a manifest, else empty
    std::vector<InputFact> inputs;          ///< the mesh, then option_files; found when the item's turn comes
    std::uint64_t file_bytes = 0;

    const std::string& key() const { return files.front(); }
};

}  // namespace lamella::cli::batch
