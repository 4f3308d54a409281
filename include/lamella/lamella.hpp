// All of lamella.
#pragma once

#include "lamella/assemble.hpp"
#include "lamella/inspect.hpp"
#include "lamella/mesh.hpp"
#include "lamella/planes.hpp"
#include "lamella/result.hpp"
#include "lamella/slice.hpp"
#include "lamella/status.hpp"
#include "lamella/stl.hpp"
#include "lamella/write.hpp"
