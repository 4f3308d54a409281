#include "mesh_words.hpp"

#include "console.hpp"

namespace lamella::cli {

std::string description(const MeshFile& mesh) {
    std::string text = std::string(mesh.text ? "text" : "binary") + " " + std::string(name_of(mesh.format)) + ", " +
                       file_size_text(mesh.file_bytes) + (mesh.compressed ? " of gzip" : "");
    if (mesh.mm_per_unit != 1) {
        text += ", in units of " + exact_text(mesh.mm_per_unit) + " mm";
    }
    if (mesh.patient_frame != PatientFrame::unstated) {
        text += ", patient frame " + std::string(name_of(mesh.patient_frame));
    }
    return text;
}

std::string mesh_formats() {
    std::string names;
    for (const std::string_view name : format_names()) {
        names += (names.empty() ? "" : ", ") + std::string(name);
    }
    return names + "; gzip of any";
}

}  // namespace lamella::cli
