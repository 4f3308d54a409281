// Reports as JSON: what was asked, what came of it, and what the program that writes it adds.
//
//     const lamella::Result<lamella::Audit> found = lamella::audit(result, mesh);
//     const lamella::ReportMember mine{.place = lamella::ReportPlace::at_end, .key = "machine", .value = "printer 3"};
//     const lamella::Result<std::string> report =
//         lamella::make_report_json(result, {.audit = found ? &*found : nullptr, .members = {&mine, 1}});
//     if (report) {
//         std::printf("%s", report->c_str());
//     }
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "lamella/audit.hpp"
#include "lamella/check.hpp"
#include "lamella/error.hpp"
#include "lamella/io/mesh_file.hpp"
#include "lamella/result.hpp"
#include "lamella/weld.hpp"

namespace lamella {

/// Where a member that the program adds stands in a report. The report of a check has an "ms" only where the program adds
/// times, and nothing after it.
enum class ReportPlace : std::uint8_t {
    after_mesh,  ///< after the members "mesh" and before "file"
    in_times,    ///< within "ms", after the times of slicing and before "report", which making the report itself took
    after_times,
    at_end,
};

/// A member that the program adds: its own times, paths, warnings. It refers to what must outlive the call that it is passed
/// to. Text is as utf8_text() has it.
struct ReportMember {
    ReportPlace place = ReportPlace::at_end;
    std::string_view key;
    std::variant<std::nullptr_t, std::uint64_t, double, std::string_view, std::span<const std::string>> value;
};

/// What a report tells beside the result: each part only if it is there.
struct ReportParts {
    std::string_view mesh_name{};             ///< "mesh"
    const MeshFile* file = nullptr;           ///< "file": format, unit, size
    const WeldedMesh* welded = nullptr;       ///< "weld", if that is what was sliced
    const Audit* audit = nullptr;             ///< "volume", "ledger", "crossings": what was asked
    std::span<const ReportMember> members{};  ///< those of the program
};

/// The report of a slicing, indented, with a final newline. Errors: out_of_memory.
Result<std::string> make_report_json(const SliceResult& result, const ReportParts& parts = {}) noexcept;

/// The mesh's name, the file and the program's members alone, as of a mesh that could not be used. Errors: out_of_memory.
Result<std::string> make_mesh_json(const ReportParts& parts) noexcept;

}  // namespace lamella
