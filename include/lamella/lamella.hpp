// All of lamella.
#pragma once

#include "lamella/assemble.hpp"
#include "lamella/check.hpp"
#include "lamella/check_report.hpp"
#include "lamella/crossings.hpp"
#include "lamella/inspect.hpp"
#include "lamella/ledger.hpp"
#include "lamella/mesh.hpp"
#include "lamella/mesh_file.hpp"
#include "lamella/planes.hpp"
#include "lamella/result.hpp"
#include "lamella/slice.hpp"
#include "lamella/status.hpp"
#include "lamella/volume.hpp"
#include "lamella/weld.hpp"
#include "lamella/write.hpp"
