// The examples of headers and pages, which extract.awk makes into functions.
#pragma once

#include <string>
#include <vector>

#include "lamella/lamella.hpp"

struct Example {
    std::string place;  ///< the file, and the example's number in it
    void (*run)(const lamella::MeshView& mesh, const lamella::SliceResult& result, lamella::SliceOptions& options);
};

const std::vector<Example>& all_examples();
