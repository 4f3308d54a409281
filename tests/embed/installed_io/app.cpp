#include <cstdio>
#include <filesystem>

#include <lamella/io.hpp>
#include <lamella/lamella.hpp>

int main(int count, char** words) {
    const auto file = lamella::read_mesh(words[count - 1]);
    if (!file) {
        std::fprintf(stderr, "%s\n", file.error().message.c_str());
        return 1;
    }
    lamella::SliceOptions options;
    options.layer_height_mm = 0.5;
    const auto result = lamella::slice(*file, options);
    if (!result || !lamella::write_layers(*result, "layers.svg") || !lamella::make_report_json(*result)) {
        return 1;
    }
    std::filesystem::remove("layers.svg");
    std::printf("%zu layers, %zu contours\n", result->layers.size(), result->contours.size());
}
