// A binary PLY file of triangles: its vertices stay in memory, its faces are read in pieces.
//
//     header | vertices: rows of one size | faces: rows of one size, a list of three indices among what else they have | ...
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "io/read/ply/ply_header.hpp"
#include "io/read/reader.hpp"
#include "io/stream/triangle_file.hpp"
#include "lamella/array.hpp"

namespace lamella {

class PlyFaces final : public TriangleFile {
public:
    /// `file` is taken; `beginning` holds the header, or as much of it as is looked at. Errors: as TriangleFile::open().
    static Result<std::unique_ptr<TriangleFile>> open(InputFile& file, std::string_view beginning, const Parallel& parallel);

    std::uint64_t resident_bytes() const noexcept override { return facts_.vertex_count * facts_.stride; }
    void load(const Memory* memory, const Parallel& parallel) override;
    std::size_t buffer_bytes() const noexcept override;
    MeshView read(std::uint64_t first, std::size_t count, std::span<std::byte> buffer) const override;

private:
    PlyFaces(InputFile file, std::string_view beginning) : TriangleFile(std::move(file)), beginning_(beginning) {}

    Status prepare(const FileSource& source);
    Status locate(const FileSource& source);
    void describe(const FileSource& source, std::uint64_t end);
    Error first_problem(std::uint64_t complete_rows);
    Error problem_in(std::uint64_t first_row, std::string_view rows) const;
    Error at_byte(ErrorCode code, std::uint64_t byte, const std::string& what) const;
    bool swapped() const noexcept { return header_.encoding == PlyEncoding::big_endian; }
    const PlyElement& faces() const noexcept { return *header_.element_of(PlyRole::faces); }
    const PlyElement& points() const noexcept { return *header_.element_of(PlyRole::vertices); }

    const std::string beginning_;  ///< names in the header refer into it
    PlyHeader header_;
    std::uint64_t vertices_at_ = 0;  ///< bytes in the file
    std::uint64_t faces_at_ = 0;
    std::size_t face_bytes_ = 0;
    Array<std::byte> vertices_;
};

}  // namespace lamella
