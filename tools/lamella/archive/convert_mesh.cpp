#include "archive/convert_mesh.hpp"

#include "files/output_path.hpp"
#include "lamella/io/mesh_writer.hpp"
#include "terminal/console.hpp"
#include "terminal/failure.hpp"
#include "terminal/numbers.hpp"

namespace lamella::cli {

void convert_mesh(const std::vector<std::string>& inputs, const std::string& output, const MeshArguments& reading,
                  Interrupt& interrupt) {
    if (inputs.size() != 1) {
        throw Failure(bad_usage, "--output: '" + output + "' takes one mesh");
    }
    require_writable(output);
    require_different(output, inputs.front(), "--output", "the mesh");
    interrupt.tidy({output});
    MeshArguments arguments = reading;
    arguments.mesh = inputs.front();
    ProgressBar bar(arguments.progress);
    const MeshFile mesh = read_mesh_and_warn(arguments, bar);
    const Result<WrittenMesh> written = write_mesh(mesh, output, {.stop = interrupt.defer()});
    if (!written) {
        throw failure_of(written.error());
    }
    if (written->rounded) {
        warn(output + ": coordinates are rounded to the 32 bits of STL; PLY keeps them");
    }
    if (mesh.states_unit && mesh.mm_per_unit != 1) {
        const std::string unit = exact_text(mesh.mm_per_unit);
        warn(output + ": does not state that its unit is " + unit + " mm; slice it with --unit " + unit);
    }
    print_words(output + ": " + counted(mesh.triangle_count, "triangle") + " of " + description(mesh) + "\n", false);
}

}  // namespace lamella::cli
