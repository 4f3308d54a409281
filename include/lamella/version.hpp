// The library's version, in the one place where it is written down: the build reads it from here.
//
//     static_assert(lamella::version_major == 0 && lamella::version_minor >= 3);
//     std::printf("lamella %s\n", lamella::version);
#pragma once

namespace lamella {

inline constexpr int version_major = 0;
inline constexpr int version_minor = 3;
inline constexpr int version_patch = 0;
inline constexpr const char* version = "0.3.0";

}  // namespace lamella
