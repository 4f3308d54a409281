// lamella tracks: islands of an archive from layer to layer, as words or as a table.
#include <memory>
#include <string>

#include "files/mesh_input.hpp"
#include "lamella/medical.hpp"
#include "lamella/tracks.hpp"

namespace lamella::cli {

namespace {

struct TracksArguments : MeshArguments {
    bool table = false;
};

std::string table_of(const SliceResult& stack, const Tracks& tracks) {
    std::string text = "layer,height_mm,area_mm2,x_mm,y_mm,below,above,body\n";
    for (const Track& island : tracks.islands) {
        text += std::to_string(island.layer) + "," + exact_text(stack[island.layer].plane_mm) + "," +
                exact_text(island.area_mm2) + "," + exact_text(island.centroid_mm[0]) + "," +
                exact_text(island.centroid_mm[1]) + "," + std::to_string(island.below) + "," + std::to_string(island.above) +
                "," + std::to_string(island.body) + "\n";
    }
    return text;
}

std::string words_of(const SliceResult& stack, const Tracks& tracks) {
    std::uint64_t births = 0;
    for (const Track& island : tracks.islands) {
        births += island.below == 0 && island.layer > 0 ? 1 : 0;
    }
    double volumes[2] = {};
    std::uint64_t counts[2] = {};
    for (const Pocket& pocket : tracks.pockets) {
        volumes[pocket.is_cavity ? 1 : 0] += pocket.volume_mm3;
        ++counts[pocket.is_cavity ? 1 : 0];
    }
    const auto line = [](const std::string& name, const std::string& text) {
        return name + std::string(10 - name.size(), ' ') + text + "\n";
    };
    const auto pockets = [&](std::size_t kind) {
        return grouped(counts[kind]) + ", " + measure_text(volumes[kind]) + " mm3";
    };
    return line("islands", grouped(tracks.islands.size()) + " in " + counted(stack.size(), "layer") + ", in " +
                               counted(tracks.bodies, "body", "bodies")) +
           line("begin", grouped(births) + " with nothing below, above the lowest layer") + line("cavities", pockets(1)) +
           line("cups", pockets(0));
}

void show_tracks(const TracksArguments& arguments, Interrupt& interrupt) {
    Stages stages(arguments.progress, arguments.threads, interrupt);
    const Archive archive = stages.done("reading " + printable(arguments.mesh), [&](const Context& context) {
        return read_archive(path_of(arguments.mesh), context);
    });
    const Tracks tracks = stages.done("following islands", [&](const Context& context) {
        return find_tracks(archive.result, {.pockets = true}, context);
    });
    print(arguments.table ? table_of(archive.result, tracks) : words_of(archive.result, tracks));
}

}  // namespace

void add_tracks_command(CLI::App& app, Interrupt& interrupt) {
    CLI::App* const command = app.add_subcommand("tracks", "Follow the islands of an archive (.h5) from layer to layer");
    const auto arguments = std::make_shared<TracksArguments>();
    add_text(*command, "archive", arguments->mesh, "IN.h5", "Archive of lamella slice or combine")->required();
    command->add_flag("--table", arguments->table, "Print a line of CSV for each island instead of a summary");
    declare_running(*command, *arguments);
    command->callback([arguments, &interrupt] { show_tracks(*arguments, interrupt); });
}

}  // namespace lamella::cli
