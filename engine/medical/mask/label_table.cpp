#include "medical/mask/label_table.hpp"

#include <string>
#include <string_view>

#include "io/write/output_file.hpp"

namespace lamella {

namespace {

/// Quoted for CSV where it has to be.
std::string quoted_name(const std::string& text) {
    if (text.find_first_of(",\"\r\n") == std::string::npos) {
        return text;
    }
    std::string all = "\"";
    for (const char c : text) {
        all += c == '"' ? "\"\"" : std::string(1, c);
    }
    return all + "\"";
}

}  // namespace

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
        file->append(std::to_string(i + 1) + "," + quoted_name(parts[i].name) + "," + std::to_string(summary.voxels[i]) +
                     "\n");
    }
    return file->commit();
}

}  // namespace lamella
