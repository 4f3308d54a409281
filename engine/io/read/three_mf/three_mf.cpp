// 3MF: a zip archive of XML parts (3MF core specification and production extension). The parts are streamed: neither an XML
// text nor a tree of it is ever held, only the vertices and triangles that it lists.
#include <algorithm>
#include <chrono>
#include <limits>
#include <utility>

#include "base/clock.hpp"
#include "io/read/reader.hpp"
#include "io/read/three_mf/three_mf_build.hpp"
#include "io/read/three_mf/three_mf_model.hpp"
#include "io/read/three_mf/zip_archive.hpp"

namespace lamella {

namespace {

/// What the parts of a file may expand to. Their text is not held, so that this bounds the time: real files compress by
/// about ten.
std::uint64_t text_limit(const FileSource& file) {
    constexpr std::uint64_t largest_ratio = 32;
    return file.memory_limit() + largest_ratio * std::min(file.size(), std::numeric_limits<std::uint64_t>::max() / 128);
}

void warn_of_other_bytes(const ZipArchive& package, three_mf::Model& model) {
    if (package.bytes_before() > 0) {
        model.warnings.push_back("ignored " + std::to_string(package.bytes_before()) + " bytes before the zip archive");
    }
    if (package.bytes_after() > 0) {
        model.warnings.push_back("ignored " + std::to_string(package.bytes_after()) + " bytes after the zip archive");
    }
}

Result<three_mf::Model> load(FileSource& file, std::chrono::steady_clock::time_point& start) {
    const Result<Array<std::byte>> bytes = file.take(file.size());
    if (!bytes) {
        return bytes.error();
    }
    start = Clock::now();
    Result<ZipArchive> package = ZipArchive::open(file, bytes.value().span(), text_limit(file));
    if (!package) {
        return package.error();
    }
    Result<three_mf::Model> model = three_mf::read_model(package.value(), file);
    if (model) {
        warn_of_other_bytes(package.value(), model.value());
    }
    return model;
}

Result<MeshFile> build(const FileSource& file, three_mf::Model& model) {
    if (model.items.empty()) {
        return error_in_part(file, ErrorCode::empty_mesh, model.parts.front(), 0,
                             model.unprintable_items == 0 ? "has nothing in its build"
                                                          : "has nothing in its build but items marked as not printable");
    }
    MeshFile mesh;
    std::vector<three_mf::Instance> instances;
    if (const std::optional<three_mf::BuildProblem> problem =
            three_mf::list_instances(model, file.memory_limit(), file.parallel(), instances, mesh.parts)) {
        return error_in_part(file, problem->code, model.parts[problem->place.part], problem->place.line, problem->what);
    }
    if (instances.empty()) {
        return file.error(ErrorCode::empty_mesh,
                          mesh.parts.empty() ? "holds no triangles" : "holds nothing solid: " + model.warnings.back());
    }
    three_mf::place(model, instances, file.memory(), file.parallel(), mesh);
    mesh.text = true;
    mesh.mm_per_unit = model.mm_per_unit;
    mesh.states_unit = true;
    for (const std::string& warning : model.warnings) {
        mesh.warnings.push_back(file.name() + ": " + warning);
    }
    return mesh;
}

}  // namespace

bool looks_like_3mf(const FileSource& source) {
    return source.sample().starts_with(zip_magic);
}

Result<MeshFile> read_3mf(FileSource& source) {
    std::chrono::steady_clock::time_point start;
    Result<three_mf::Model> model = load(source, start);
    if (!model) {
        return model.error();
    }
    Result<MeshFile> mesh = build(source, model.value());
    if (mesh) {
        mesh->parse_ms = milliseconds_since(start);
    }
    return mesh;
}

}  // namespace lamella
