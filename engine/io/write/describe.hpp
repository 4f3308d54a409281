// The rules that a result was made by, as sentences for every output.
#pragma once

#include <string>

#include "base/words.hpp"
#include "lamella/mesh/weld.hpp"
#include "lamella/planes.hpp"
#include "lamella/result.hpp"

namespace lamella {

const char* name_of(PlaneSide side) noexcept;
const char* name_of(Datum datum) noexcept;
const char* name_of(GapSense sense) noexcept;

/// Where the planes lie and how each was rounded, as one sentence.
std::string describe(const LayerPlan& plan);

/// What was joined before slicing, as a sentence.
std::string describe_weld(const WeldedMesh& welded);

/// What is inside, and what the regions went through, as sentences.
std::string describe_rules(const SliceResult& result);

}  // namespace lamella
