// The core of lamella: a mesh in memory, cut and judged. Mesh files and writers are in lamella/io.hpp.
#pragma once

#include "lamella/assemble.hpp"
#include "lamella/audit/crossings.hpp"
#include "lamella/audit/ledger.hpp"
#include "lamella/audit/validate.hpp"
#include "lamella/audit/volume.hpp"
#include "lamella/control.hpp"
#include "lamella/error.hpp"
#include "lamella/mesh.hpp"
#include "lamella/mesh/check.hpp"
#include "lamella/mesh/inspect.hpp"
#include "lamella/mesh/weld.hpp"
#include "lamella/planes.hpp"
#include "lamella/result.hpp"
#include "lamella/slice.hpp"
#include "lamella/version.hpp"
