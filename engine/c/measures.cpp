// The call of measures.h.
#include <algorithm>
#include <string>

#include "c/call.hpp"

namespace api = lamella::c;

namespace {

/// Throws Refused where the program's array is not as long.
void copy_rows(const lamella::Array<lamella::SectionMeasures>& rows, lamella_section_measures* to, std::size_t count,
               const char* what) {
    api::require_list(to, count, what);
    if (count != rows.size()) {
        api::refuse("there are " + std::to_string(rows.size()) + " " + what + ", and room for " + std::to_string(count));
    }
    std::copy(rows.begin(), rows.end(), api::as_cpp(to));
}

}  // namespace

int32_t lamella_measure(const lamella_result* result, int32_t feret, const lamella_context* context,
                        lamella_section_measures* layers, size_t layer_count, lamella_section_measures* islands,
                        size_t island_count, lamella_error* error) {
    return api::called(error, [&] {
        api::require_given(result, "the result");
        const api::Host host(context);
        const lamella::MeasureOptions how{.islands = islands != nullptr, .feret = feret != 0};
        const lamella::Measures found = lamella::require(lamella::measure(result->result, how, host.context));
        copy_rows(found.layers, layers, layer_count, "layers");
        if (islands != nullptr) {
            copy_rows(found.islands, islands, island_count, "islands");
        }
    });
}
