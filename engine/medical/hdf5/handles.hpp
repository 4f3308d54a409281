// HDF5's identifiers as values, its failures as exceptions, and its names of number types.
#pragma once

#include <type_traits>
#include <utility>

#include <hdf5.h>

#include "base/guard.hpp"

namespace lamella {

/// While it lives, HDF5 prints nothing of its errors.
class QuietErrors {
public:
    QuietErrors() noexcept : known_(H5Eget_auto2(H5E_DEFAULT, &print_, &context_) >= 0) {
        H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    }
    ~QuietErrors() {
        H5Eclear2(H5E_DEFAULT);
        if (known_) {
            H5Eset_auto2(H5E_DEFAULT, print_, context_);
        }
    }
    QuietErrors(const QuietErrors&) = delete;
    QuietErrors& operator=(const QuietErrors&) = delete;

private:
    H5E_auto2_t print_ = nullptr;
    void* context_ = nullptr;
    bool known_;
};

/// For calls that fail only where memory or the disk of a temporary file ends.
inline void checked(herr_t status) {
    if (status < 0) {
        throw Refused{{ErrorCode::out_of_memory, "HDF5 fails: no memory, or no space for a temporary file"}};
    }
}

/// Owns an identifier.
class Handle {
public:
    /// Throws Refused where there is none.
    Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) { checked(id < 0 ? -1 : 0); }
    Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
    Handle& operator=(Handle&&) = delete;
    Handle(const Handle&) = delete;
    Handle& operator=(const Handle&) = delete;
    ~Handle() {
        if (id_ >= 0) {
            close_(id_);
        }
    }

    hid_t id() const noexcept { return id_; }

private:
    hid_t id_;
    herr_t (*close_)(hid_t);
};

/// How files are opened: as plain files whatever the environment says, and never locked, which file systems of clusters may
/// refuse.
inline Handle plain_file_access() {
    Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    checked(H5Pset_fapl_sec2(access.id()));
#if H5_VERSION_GE(1, 12, 1) || (H5_VERSION_GE(1, 10, 7) && !H5_VERSION_GE(1, 12, 0))
    checked(H5Pset_file_locking(access.id(), false, true));
#endif
    return access;
}

/// Little-endian, whatever the host is.
template <class Number>
hid_t hdf5_type() {
    constexpr bool is_signed = std::is_signed_v<Number>;
    if constexpr (std::is_same_v<Number, double>) {
        return H5T_IEEE_F64LE;
    } else if constexpr (sizeof(Number) == 1) {
        return is_signed ? H5T_STD_I8LE : H5T_STD_U8LE;
    } else if constexpr (sizeof(Number) == 2) {
        return is_signed ? H5T_STD_I16LE : H5T_STD_U16LE;
    } else if constexpr (sizeof(Number) == 4) {
        return is_signed ? H5T_STD_I32LE : H5T_STD_U32LE;
    } else {
        return is_signed ? H5T_STD_I64LE : H5T_STD_U64LE;
    }
}

}  // namespace lamella
