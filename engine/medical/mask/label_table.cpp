#include "medical/mask/label_table.hpp"

#include <string>
#include <string_view>

#include "io/write/output_file.hpp"
#include "lamella/io/name_text.hpp"
#include "medical/tables/csv_text.hpp"

namespace lamella {

Status write_label_table(std::span<const MaskPart> parts, const MaskSummary& summary, const std::filesystem::path& path) {
    std::string name = path.string();
    for (const char* end : {".gz", ".nii", ".nrrd", ".seg"}) {
        const std::string_view tail(end);
        if (name.size() > tail.size() && std::string_view(name).ends_with(tail)) {
            name.resize(name.size() - tail.size());
        }
    }
    Result<OutputFile> file = OutputFile::create(name + ".labels.csv");
    if (!file) {
        return file.error();
    }
    file->append("label,name,voxels\n");
    for (std::size_t i = 0; i < parts.size(); ++i) {
        file->append(std::to_string(i + 1) + "," + csv_text(text_of_name(parts[i].name)) + "," +
                     std::to_string(summary.voxels[i]) + "\n");
    }
    return file->commit();
}

}  // namespace lamella
