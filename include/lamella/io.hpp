// lamella::io: mesh files, layered SVG and reports.
#pragma once

#include "lamella/io/check_report.hpp"
#include "lamella/io/mesh_file.hpp"
#include "lamella/io/write.hpp"
