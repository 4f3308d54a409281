#include "lamella/io/text_file.hpp"

#include "base/guard.hpp"
#include "io/write/output_file.hpp"

namespace lamella {

Status write_text_file(const std::filesystem::path& path, const std::string& text) noexcept {
    return guarded([&]() -> Status {
        Result<OutputFile> file = OutputFile::create(path);
        if (!file) {
            return file.error();
        }
        file->append(text);
        return file->commit();
    });
}

}  // namespace lamella
