/// tinygltf itself, in the place of Debian's library: so the sanitizers watch it and the fuzzer
/// sees where in it an input gets.
#define TINYGLTF_IMPLEMENTATION
#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <tiny_gltf.h>
