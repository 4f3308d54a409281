// lamella view: the page that slices, with meshes in it. The page is made by tools/view/build.sh and lies beside the tool,
// where it was built. A mesh goes into it as its file is, deflated, so that the page cuts what the tool cuts.
#include <zlib.h>

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "files/mesh_input.hpp"
#include "io/write/output_file.hpp"
#include "lamella/io/name_text.hpp"
#include "system/process.hpp"

namespace lamella::cli {

namespace {

constexpr std::string_view place_of_meshes = "<!-- meshes -->";
constexpr std::size_t most_page_bytes = 16'000'000;
constexpr std::size_t most_mesh_bytes = 250'000'000;  ///< a browser takes half a minute to open what is made of more

struct ViewArguments : MeshArguments {
    std::vector<std::string> meshes;
    std::string output;
};

std::string read_page() {
    const std::filesystem::path path = program_path().parent_path().parent_path() / "share" / "lamella" / "view.html";
    std::error_code unknown;
    refuse_if(!std::filesystem::exists(path, unknown), bad_input,
              "the page is not installed with this tool: tools/view/build.sh of the source code makes it, by npm and "
              "emscripten; then build and install lamella again");
    std::string page = read_bytes(path_text(path), most_page_bytes);
    refuse_if(page.find(place_of_meshes) == std::string::npos, bad_input, printable(path_text(path)) + ": is not the page");
    return page;
}

/// As HTML has it between quote marks.
std::string attribute(std::string_view text) {
    std::string escaped;
    for (const char c : utf8_text(text)) {
        escaped += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '"' ? "&quot;" : std::string(1, c);
    }
    return escaped;
}

/// As gzip has it, with neither a time nor a name. Throws std::bad_alloc.
std::string deflated(std::string_view bytes) {
    if (bytes.starts_with("\x1f\x8b")) {
        return std::string(bytes);
    }
    constexpr int gzip = 16;
    z_stream stream{};
    if (deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, MAX_WBITS + gzip, MAX_MEM_LEVEL, Z_DEFAULT_STRATEGY) !=
        Z_OK) {
        throw std::bad_alloc();
    }
    std::string out(deflateBound(&stream, static_cast<uLong>(bytes.size())), 0);
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream.avail_in = static_cast<uInt>(bytes.size());
    stream.next_out = reinterpret_cast<Bytef*>(out.data());
    stream.avail_out = static_cast<uInt>(out.size());
    ::deflate(&stream, Z_FINISH);
    out.resize(stream.total_out);
    deflateEnd(&stream);
    return out;
}

void append_base64(OutputFile& out, std::string_view bytes) {
    constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t three = 0;
        const std::size_t held = std::min<std::size_t>(3, bytes.size() - i);
        for (std::size_t b = 0; b < 3; ++b) {
            three = three << 8 | (b < held ? static_cast<unsigned char>(bytes[i + b]) : 0U);
        }
        std::array<char, 4> four{};
        for (std::size_t d = 0; d < 4; ++d) {
            four[d] = d <= held ? digits[three >> (18 - 6 * d) & 63] : '=';
        }
        out.append({four.data(), four.size()});
    }
}

/// The page's script element with the mesh in it.
void append_mesh(OutputFile& out, const std::string& path, const ViewArguments& arguments, Stages& stages) {
    FileStatus status;
    refuse_if(status_of(path_of(path), status) == 0 && status.size > most_mesh_bytes, bad_input,
              printable(path) + ": has more than " + file_size_text(most_mesh_bytes) +
                  ", too much for a page; drop it on the page without a mesh that lamella view -o PAGE.html writes");
    MeshArguments reading = arguments;
    reading.mesh = path;
    read_mesh_and_warn(reading, stages);  // what the page would refuse is refused here
    const std::string name = path_text(path_of(path).filename());
    out.append("<script type=\"text/plain\" class=\"mesh\" data-name=\"" + attribute(name) + "\">");
    append_base64(out, deflated(read_bytes(path, most_mesh_bytes)));
    out.append("</script>\n");
}

void write_page(const ViewArguments& arguments, Interrupt& interrupt) {
    FilePlan files;
    for (const std::string& mesh : arguments.meshes) {
        files.reads(mesh, "the mesh");
    }
    files.writes(arguments.output, "--output", "another output");
    require_writable(arguments.output);
    const std::string page = read_page();
    const std::size_t place = page.find(place_of_meshes);
    interrupt.tidy({arguments.output});
    Stages stages(arguments.progress, arguments.threads, interrupt);
    OutputFile out = done_or_thrown(OutputFile::create(output_path(arguments.output)));
    out.append(std::string_view(page).substr(0, place));
    for (const std::string& mesh : arguments.meshes) {
        append_mesh(out, mesh, arguments, stages);
    }
    out.append(std::string_view(page).substr(place + place_of_meshes.size()));
    done_or_thrown(out.commit());
    print_words(output_name(arguments.output) + ": a page with " + counted(arguments.meshes.size(), "mesh", "meshes") +
                    "; open it in a browser\n",
                is_standard(arguments.output));
}

}  // namespace

void add_view_command(CLI::App& app, Interrupt& interrupt) {
    CLI::App* const command = app.add_subcommand("view", "Write a page that slices meshes in a browser");
    const auto arguments = std::make_shared<ViewArguments>();
    add_text(*command, "mesh", arguments->meshes, "MESH ...", "Mesh files to put into the page; none: drop them onto it");
    add_text(*command, "-o,--output", arguments->output, "PAGE.html|-", "Page to write; - for standard output")->required();
    declare_running(*command, *arguments);
    command->callback([arguments, &interrupt] { write_page(*arguments, interrupt); });
}

}  // namespace lamella::cli
