// What every reader makes of one file.
#include <catch2/catch.hpp>

#include "golden/calls.hpp"
#include "golden/mesh_files.hpp"
#include "temp_folder.hpp"

namespace golden {

TEST_CASE("files of every format are read to the committed meshes", "[golden][input]") {
    const TempFolder folder;
    Group group("read");
    for (const auto& [name, bytes] : mesh_files()) {
        if (same_input(name, hash_of(bytes))) {
            add_read(group, name, folder.write(name, bytes));
        }
    }
    group.finish();
}

}  // namespace golden
