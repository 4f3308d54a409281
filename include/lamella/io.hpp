// lamella::io: mesh files, files of layers and reports.
//
//     const lamella::Result<lamella::MeshFile> file = lamella::read_mesh("liver.stl");
//     if (file) {
//         const lamella::Result<lamella::SliceResult> sliced = lamella::slice(*file);
//         if (sliced && lamella::write_layers(*sliced, "liver.svg")) {
//             std::printf("%zu layers\n", sliced->layers.size());
//         }
//     }
#pragma once

#include "lamella/io/check_report.hpp"
#include "lamella/io/layer_file.hpp"
#include "lamella/io/mesh_file.hpp"
#include "lamella/io/mesh_stream.hpp"
#include "lamella/io/mesh_writer.hpp"
#include "lamella/io/name_text.hpp"
#include "lamella/io/report.hpp"
#include "lamella/io/text_file.hpp"
