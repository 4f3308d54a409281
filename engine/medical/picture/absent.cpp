// Stands in where libpng is missing.
#include "medical/absent.hpp"
#include "lamella/medical/picture.hpp"

namespace lamella {

Status write_layer_picture(std::span<const PicturePart>, std::uint64_t, const std::filesystem::path& path,
                           const PictureOptions&) noexcept {
    return absent("write", path, "PNG (libpng-dev)");
}

Status write_contact_sheet(std::span<const PicturePart>, const std::filesystem::path& path, const PictureOptions&) noexcept {
    return absent("write", path, "PNG (libpng-dev)");
}

}  // namespace lamella
