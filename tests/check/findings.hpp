// Shared by the tests of the diagnosis.
#pragma once

#include <initializer_list>
#include <map>
#include <string>
#include <utility>

#include <catch2/catch.hpp>

#include "engine/shapes.hpp"
#include "lamella/check.hpp"
#include "lamella/io/check_report.hpp"

namespace lamella::check_test {

using shapes::only;
using shapes::quad;
using shapes::Soup;
using shapes::without;
using shapes::Xyz;

/// The findings, which must not depend on threads.
MeshCheck findings_of(const Soup& soup, const CheckOptions& options = {});

/// The counts that are not zero, by key.
std::map<std::string, std::uint64_t> counts(const MeshCheck& check);
using Counts = std::map<std::string, std::uint64_t>;

inline const FaultPlace& first(const MeshCheck& check, Fault fault) {
    REQUIRE_FALSE(check.of(fault).places.empty());
    return check.of(fault).places.front();
}

}  // namespace lamella::check_test
