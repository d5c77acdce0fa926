/// tinygltf itself instead of Debian's library, so that the sanitizers check it and the fuzzer sees
/// its coverage.
#define TINYGLTF_IMPLEMENTATION
#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <tiny_gltf.h>
