#include "io/write/json.hpp"

#include <variant>

#include <nlohmann/json.hpp>

#include "lamella/io/name_text.hpp"

namespace lamella {

void JsonText::value(double number) {
    put(nlohmann::json(number).dump());
}

void JsonText::value(std::string_view text) {
    put(nlohmann::json(utf8_text(text)).dump());
}

void JsonText::key(std::string_view name) {
    value(name);
    text_ += ": ";
    after_key_ = true;
}

/// A value or its beginning: after its key, or on a line of its own.
void JsonText::put(std::string_view word) {
    if (!after_key_ && depth_ > 0) {
        if (const char last = text_.back(); last != '{' && last != '[') {
            text_ += ',';
        }
        break_line();
    }
    after_key_ = false;
    text_ += word;
}

// --- Members of every report

namespace {

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

}  // namespace

void write_members(JsonText& json, const ReportParts& parts, ReportPlace place) {
    for (const ReportMember& member : parts.members) {
        if (member.place == place) {
            std::visit([&](const auto& value) { json.member(member.key, value); }, member.value);
        }
    }
}

void write_mesh(JsonText& json, const ReportParts& parts) {
    json.member("mesh", parts.mesh_name);
    write_members(json, parts, ReportPlace::after_mesh);
    if (parts.file != nullptr) {
        write_file(json, *parts.file);
    }
}

void write_box(JsonText& json, const Box& box) {
    json.object("box_mm", [&] {
        json.member("min", box.min_mm);
        json.member("max", box.max_mm);
    });
}

}  // namespace lamella
