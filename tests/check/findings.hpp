// What the tests of the diagnosis share.
#pragma once

#include <initializer_list>
#include <map>
#include <string>
#include <utility>

#include <catch2/catch.hpp>

#include "engine/shapes.hpp"
#include "lamella/io/check_report.hpp"
#include "lamella/mesh/check.hpp"

namespace lamella::check_test {

using shapes::only;
using shapes::quad;
using shapes::Soup;
using shapes::without;
using shapes::Xyz;

/// The findings, which must not depend on threads.
MeshCheck findings_of(const Soup& soup, CheckOptions options = {});

/// Report and marks without the numbers of triangles, which alone may depend on the order of the input.
std::string text_without_triangles(MeshCheck check);

/// The counts that are not zero, by key.
std::map<std::string, std::uint64_t> counts(const MeshCheck& check);
using Counts = std::map<std::string, std::uint64_t>;

inline const FaultPlace& first(const MeshCheck& check, Fault fault) {
    REQUIRE_FALSE(check.of(fault).places.empty());
    return check.of(fault).places.front();
}

}  // namespace lamella::check_test
