// Outputs that are written while a mesh larger than memory is sliced: each layer is cut, written, forgotten.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "lamella/io/svg.hpp"
#include "lamella/medical/table.hpp"
#include "lamella/slice_file.hpp"
#include "outputs/output_formats.hpp"

namespace lamella::cli {

class StreamedOutputs {
public:
    /// Whether all of them are of formats that take one layer after the other: SVG and tables.
    static bool serve(const std::vector<PlannedOutput>& outputs);

    /// `mesh_name`: of the rows of tables. `image`: at whose slices the mesh is cut, or null; it must outlive this.
    StreamedOutputs(std::vector<PlannedOutput> outputs, std::string mesh_name, const ImageGeometry* image);

    /// Which hold the hash of the result.
    bool have_records() const;

    /// Errors are kept, and finish() throws the first.
    void begin(const FileOutline& outline) noexcept;
    void add(const LayerView& view) noexcept;
    bool failed() const noexcept;

    /// Puts the files in their places, or none where some failed before. Throws Failure.
    void finish();

private:
    using Stream = std::variant<SvgStream, LayerTableStream>;

    static bool has_failed(const Stream& stream) noexcept;
    Result<Stream> open(const PlannedOutput& output, const FileOutline& outline) const;

    std::vector<PlannedOutput> outputs_;
    std::string mesh_name_;
    const ImageGeometry* image_;
    std::vector<Stream> streams_;
    Status begun_;
};

}  // namespace lamella::cli
