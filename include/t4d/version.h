#pragma once

/// The version of the library, from which that of the build, the program and the packages is read.
/// Before 1.0 another minor version may have another interface.
#define T4D_VERSION_MAJOR 0
#define T4D_VERSION_MINOR 3
#define T4D_VERSION_PATCH 0

namespace t4d {

/// The version as one number that grows with the version: 300 for 0.3.0, 10203 for 1.2.3.
inline constexpr int kVersion =
    T4D_VERSION_MAJOR * 10'000 + T4D_VERSION_MINOR * 100 + T4D_VERSION_PATCH;

}  // namespace t4d
