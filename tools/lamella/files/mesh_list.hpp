// The meshes of a command that takes several: files, folders and standard input.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "files/mesh_input.hpp"
#include "terminal/failure.hpp"
#include "terminal/interrupt.hpp"

namespace lamella::cli {

struct MeshListArguments {
    std::vector<std::string> given;  ///< as typed
    MeshArguments each;              ///< how to read each; its mesh is left empty
};

/// Declares the meshes, --unit, --grid and --threads on `command`, to be stored in `arguments`.
void declare_mesh_list(CLI::App& command, MeshListArguments& arguments);

class MeshList {
public:
    /// Lists the meshes in folders and in the folders below them. Throws Failure (bad_usage) if standard input is given
    /// twice, or if --unit or --grid is none.
    explicit MeshList(const MeshListArguments& arguments);

    /// A list of files and folders, and not one file.
    bool several() const noexcept { return several_; }
    std::vector<std::string> paths() const;

    using Use = std::function<void(const MeshArguments&)>;
    using Refuse = std::function<void(const MeshArguments&, const Failure&)>;

    /// Calls `use` for one mesh after the other. A Failure by which one of several cannot be used is printed and passed to
    /// `refuse`, and the rest goes on; in the end one Failure for all is returned. A Failure of the output, or of the only
    /// mesh, is thrown.
    [[nodiscard]] std::optional<Failure> for_each(Interrupt& interrupt, const Use& use, const Refuse& refuse) const;

private:
    struct Entry {
        std::string path;
        std::string problem;  ///< why there is nothing to read, if so
    };

    void add_folder(const std::string& path);
    void add_contents(const std::string& folder);

    MeshArguments each_;
    bool several_;
    std::vector<Entry> entries_;
};

}  // namespace lamella::cli
