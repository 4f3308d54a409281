// What HDF5 calls the numbers of an archive, and what the archive calls itself.
#pragma once

#include <string_view>

#include <hdf5.h>

#include "medical/hdf5/columns.hpp"

namespace lamella {

inline constexpr std::string_view archive_format = "lamella archive";
inline constexpr std::uint64_t archive_version = 1;

/// Little-endian, whatever the host is.
inline hid_t hdf5_type(NumberType number) {
    switch (number) {
        case NumberType::i8:
            return H5T_STD_I8LE;
        case NumberType::u8:
            return H5T_STD_U8LE;
        case NumberType::u16:
            return H5T_STD_U16LE;
        case NumberType::i32:
            return H5T_STD_I32LE;
        case NumberType::u32:
            return H5T_STD_U32LE;
        case NumberType::i64:
            return H5T_STD_I64LE;
        case NumberType::u64:
            return H5T_STD_U64LE;
        case NumberType::f64:
            return H5T_IEEE_F64LE;
    }
    return -1;
}

}  // namespace lamella
