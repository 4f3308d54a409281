// Handles and structs of lamella.h, as tests hold them.
#pragma once

#include <cstdint>
#include <memory>

#include "lamella/overlay.h"

namespace c_handles {

struct Freed {
    void operator()(lamella_result* result) const { lamella_result_free(result); }
    void operator()(lamella_slicer* slicer) const { lamella_slicer_free(slicer); }
    void operator()(lamella_overlay* overlay) const { lamella_overlay_free(overlay); }
    void operator()(lamella_prepared* prepared) const { lamella_prepared_free(prepared); }
    void operator()(lamella_welded* welded) const { lamella_welded_free(welded); }
};
template <class Handle>
using Owned = std::unique_ptr<Handle, Freed>;

/// A struct of C with its defaults, as fresh<lamella_view>(LAMELLA_VIEW).
template <class T>
T fresh(std::int32_t kind) {
    T it;
    LAMELLA_INIT(&it, kind);
    return it;
}

inline lamella_destination into(lamella_result** result, const lamella_sink* sink, const lamella_arrays* arrays) {
    auto to = fresh<lamella_destination>(LAMELLA_DESTINATION);
    to.result = result;
    to.sink = sink;
    to.arrays = arrays;
    return to;
}

}  // namespace c_handles
