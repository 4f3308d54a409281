#include "medical/absent.hpp"
#include "lamella/medical/geometry.hpp"

namespace lamella {

Transform ImageGeometry::slicing_frame(PatientFrame) const noexcept {
    return {};
}

std::vector<double> ImageGeometry::slice_heights_mm(int) const {
    return {};
}

Result<ImageGeometry> read_image_geometry(const std::filesystem::path& path) noexcept {
    return absent("read", path, "images");
}

Result<ImageGeometry> geometry_around(const std::array<double, 3>&, const std::array<double, 3>&,
                                      const std::array<double, 3>&) noexcept {
    return absent("make", "image", "images");
}

}  // namespace lamella
