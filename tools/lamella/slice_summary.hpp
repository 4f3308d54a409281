// What a person is told of a slicing.
#pragma once

#include <string>

#include "lamella/io/mesh_file.hpp"
#include "lamella/io/write.hpp"
#include "lamella/result.hpp"

namespace lamella::cli {

/// Some lines, each a keyword and what there is to say, with a final newline.
std::string summary(const SliceResult& result, const MeshFile& mesh, const ReportContext& context);

}  // namespace lamella::cli
