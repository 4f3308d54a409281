#include "check/findings.hpp"

#include "engine/slicing.hpp"

namespace lamella::check_test {

MeshCheck findings_of(const Soup& soup, const CheckOptions& options) {
    const MeshView view = MeshView::soup(std::span<const double>(soup));
    MeshCheck one = value_of(check(view, options, {.threads = 1}));
    const MeshCheck three = value_of(check(view, options, {.threads = 3}));
    CHECK(make_check_json(one, {}, 1000).value() == make_check_json(three, {}, 1000).value());
    return one;
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
