#include "medical/hdf5/handles.hpp"

#include "io/read/input_file.hpp"

namespace lamella {

namespace {

/// The innermost description: entries come from the inside out.
herr_t take_first(unsigned number, const H5E_error2_t* error, void* into) {
    if (number == 0 && error->desc != nullptr) {
        try {
            *static_cast<std::string*>(into) = error->desc;
        } catch (const std::bad_alloc&) {
            return -1;
        }
    }
    return 0;
}

}  // namespace

QuietErrors::QuietErrors() noexcept {
    known_ = H5Eget_auto2(H5E_DEFAULT, &print_, &context_) >= 0;
    if (known_) {
        H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    }
}

QuietErrors::~QuietErrors() {
    H5Eclear2(H5E_DEFAULT);
    if (known_) {
        H5Eset_auto2(H5E_DEFAULT, print_, context_);
    }
}

std::string hdf5_words() {
    std::string words;
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, take_first, &words);
    return printable(words);
}

Refused hdf5_failure() {
    return {{ErrorCode::out_of_memory, "HDF5 fails: " + hdf5_words()}};
}

}  // namespace lamella
