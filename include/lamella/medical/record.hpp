// Records: what an output was made of, so that anyone can check it years later.
//
//     lamella::Record record;
//     const lamella::Result<lamella::FileSeal> seal = lamella::seal_file("liver.nii.gz");
//     if (seal) {
//         record.output = *seal;
//         const lamella::Status written = lamella::write_record(record, "liver.nii.gz.lamella.json");
//     }
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "lamella/context.hpp"
#include "lamella/error.hpp"
#include "lamella/medical/geometry.hpp"

namespace lamella {

/// A file by its content.
struct FileSeal {
    std::string path;  ///< as it was named
    std::uint64_t bytes = 0;
    std::string sha256;  ///< 64 hexadecimal digits
    friend bool operator==(const FileSeal&, const FileSeal&) = default;
};

/// What stands beside an output NAME as NAME.lamella.json. It holds no time.
struct Record {
    std::string version;           ///< of the library
    std::string command;           ///< of the tool that made the output: "slice", "convert", "combine" or "merge"
    std::vector<FileSeal> inputs;  ///< meshes, archives or parts in the order of labels, then the files that options name
    FileSeal output;               ///< named as it lies beside the record
    std::vector<std::string> options;  ///< the words of the command that decide the output
    std::string patient_frame;         ///< "LPS", "RAS" or ""
    std::vector<double> grid_mm;       ///< of each mesh
    /// Of each mesh, as SliceResult::stitch_mm; empty in records of earlier versions.
    std::vector<double> stitch_mm;
    std::string fill_rule;
    std::vector<std::string> result_hashes;  ///< SliceResult::hash() of each mesh: 16 hexadecimal digits
    std::string source_date_epoch;           ///< SOURCE_DATE_EPOCH of the environment, or ""
    friend bool operator==(const Record&, const Record&) = default;
};

/// Of a folder, its DICOM series, the one with this UID or else the only one: the bytes of all slices, and SHA-256 over the
/// digests of their files, 32 bytes each, in the order of slices. O(bytes). Errors: unreadable_file, malformed_mesh (a
/// folder that read_image_geometry() refuses), cancelled, out_of_memory.
Result<FileSeal> seal_file(const std::filesystem::path& path, const Context& context = {},
                           const ImageOptions& image = {}) noexcept;

/// Errors: unwritable_file, out_of_memory.
Status write_record(const Record& record, const std::filesystem::path& path) noexcept;

/// Errors: unreadable_file, malformed_mesh (not a record; with the place), out_of_memory.
Result<Record> read_record(const std::filesystem::path& path) noexcept;

}  // namespace lamella
