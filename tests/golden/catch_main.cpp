// Catch2's main, compiled with the golden cases: the library that Debian has of it is built for GCC's C++ library.
#define CATCH_CONFIG_MAIN
#include <catch2/catch.hpp>
