// Shared by the tests of the diagnosis.
#pragma once

#include <catch2/catch.hpp>

#include "engine/shapes.hpp"
#include "engine/slicing.hpp"
#include "lamella/check.hpp"
#include "lamella/io/check_report.hpp"

namespace lamella::check_test {

using shapes::only;
using shapes::quad;
using shapes::Soup;
using shapes::without;
using shapes::Xyz;

/// The findings, which must not depend on threads.
inline MeshCheck findings_of(const Soup& soup, const CheckOptions& options = {}) {
    const MeshView view = MeshView::soup(std::span<const double>(soup));
    MeshCheck one = value_of(check(view, options, {.threads = 1}));
    const MeshCheck three = value_of(check(view, options, {.threads = 3}));
    CHECK(make_check_json(one, {}, 1000).value() == make_check_json(three, {}, 1000).value());
    return one;
}

}  // namespace lamella::check_test
