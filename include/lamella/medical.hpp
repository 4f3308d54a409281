// lamella::medical: label masks, structure sets, tables, pictures, archives and records of slices.
//
//     const lamella::Result<lamella::ImageGeometry> image = lamella::read_image_geometry("ct.nii.gz");
//     const lamella::MaskPart organ{.result = &result, .name = "liver"};  // sliced at the image's slices, in its frame
//     if (image && lamella::write_mask({&organ, 1}, *image, "liver.nii.gz")) {
//         std::printf("written\n");
//     }
//
// This is no medical device: whoever uses it for patients validates what comes of it.
#pragma once

#include "lamella/medical/archive.hpp"
#include "lamella/medical/geometry.hpp"
#include "lamella/medical/labels.hpp"
#include "lamella/medical/mask.hpp"
#include "lamella/medical/picture.hpp"
#include "lamella/medical/record.hpp"
#include "lamella/medical/segmentation.hpp"
#include "lamella/medical/structure_set.hpp"
#include "lamella/medical/table.hpp"
