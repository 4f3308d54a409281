#include "io/write/file_json.hpp"

namespace lamella {

void write_file(JsonText& json, const MeshFile& file) {
    json.object("file", [&] {
        json.member("format", name_of(file.format));
        json.member("text", file.text);
        json.member("compressed", file.compressed);
        json.member("bytes", file.file_bytes);
        json.member("mm_per_unit", file.mm_per_unit);
        json.member("states_unit", file.states_unit);
        json.member_if(file.patient_frame != PatientFrame::unstated, "patient_frame", name_of(file.patient_frame));
    });
}

void write_box(JsonText& json, const double (&min_mm)[3], const double (&max_mm)[3]) {
    json.object("box_mm", [&] {
        json.list("min", min_mm);
        json.list("max", max_mm);
    });
}

}  // namespace lamella
