#include "check/findings.hpp"

namespace lamella::check_test {

std::string text_without_triangles(MeshCheck check) {
    for (FaultFinding& finding : check.findings) {
        for (FaultPlace& place : finding.places) {
            place.triangles = {-1, -1};
        }
    }
    for (MeshShell& shell : check.shells) {
        shell.triangle = -1;
    }
    const Result<std::string> json = make_check_json(check, {}, 1000);
    REQUIRE(json.ok());
    return json.value();
}

MeshCheck findings_of(const Soup& soup, CheckOptions options) {
    options.control.threads = 1;
    const MeshView view = MeshView::soup(std::span<const double>(soup));
    const Result<MeshCheck> one = check(view, options);
    INFO((one ? "" : one.error().message));
    REQUIRE(one.ok());
    options.control.threads = 3;
    const Result<MeshCheck> three = check(view, options);
    REQUIRE(three.ok());
    CHECK(make_check_json(one.value(), {}, 1000).value() == make_check_json(three.value(), {}, 1000).value());
    return one.value();
}

Counts counts(const MeshCheck& check) {
    Counts found;
    for (std::size_t i = 0; i < fault_count; ++i) {
        if (check.findings[i].count > 0) {
            found[std::string(key_of(static_cast<Fault>(i)))] = check.findings[i].count;
        }
    }
    return found;
}

}  // namespace lamella::check_test
