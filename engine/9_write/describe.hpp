// The rules that a result was made by, in words: every output carries them.
#pragma once

#include <string>

#include "lamella/planes.hpp"
#include "lamella/result.hpp"

namespace lamella {

const char* name_of(Side side) noexcept;
const char* name_of(Datum datum) noexcept;

/// Shortest decimal text that reads back as the same number.
std::string exact_text(double value);

/// Where the planes lie and how each was rounded, as one sentence.
std::string describe(const LayerPlan& plan);

/// What is inside, and which gaps were closed, as a sentence or two.
std::string describe_rules(const SliceResult& result);

}  // namespace lamella
