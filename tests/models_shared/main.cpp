// Exit status 77 tells ctest that there was nothing to test.
#define CATCH_CONFIG_RUNNER
#include <cstdio>
#include <filesystem>

#include <catch2/catch.hpp>

int main(int argc, char** argv) {
    constexpr int skipped = 77;
    if (!std::filesystem::is_regular_file(LAMELLA_SHARED_MODELS "/liver.stl")) {
        std::printf("skipped: no test meshes in %s\n", LAMELLA_SHARED_MODELS);
        return skipped;
    }
    return Catch::Session().run(argc, argv);
}
