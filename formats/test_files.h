#pragma once

#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "platform/test_folder.h"
#include "t4d/surface.h"

/// Helpers for tests of readers and writers.
namespace t4d::formats {

/// A path in a folder that only this process uses.
inline std::filesystem::path temporaryPath(const std::string& name) {
  static const platform::TestFolder folder;
  return folder / name;
}

inline std::filesystem::path writeFile(const std::string& name, const std::string& bytes) {
  const auto path = temporaryPath(name);
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

/// The mesh in a file of these bytes; the test fails when it is refused.
inline LoadedMesh readBytes(const std::string& name, const std::string& bytes,
                            Keep keep = Keep::Shape) {
  auto loaded = readTriangleMesh(writeFile(name, bytes), keep);
  EXPECT_TRUE(loaded) << loaded.error().text();
  return loaded ? *loaded : LoadedMesh{};
}

/// `WHERE: MESSAGE` of the error, without the folder of the file.
inline std::string textOf(const Error& error, const std::filesystem::path& path) {
  std::string text = error.text();
  const std::string folder = path.parent_path().string() + "/";
  for (auto at = text.find(folder); at != text.npos; at = text.find(folder)) {
    text.erase(at, folder.size());
  }
  return text;
}

/// The error of a triangle mesh file with these bytes, as textOf; "(was accepted)" without one.
inline std::string errorOf(const std::string& name, const std::string& bytes) {
  const auto path = writeFile(name, bytes);
  const auto loaded = readTriangleMesh(path);
  return loaded ? "(was accepted)" : textOf(loaded.error(), path);
}

/// The bytes of a number in the machine's order, which is little-endian.
template <class T>
std::string bytesOf(T value) {
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &value, sizeof(T));
  return bytes;
}

/// A cube from 0 to 1 as six squares facing outward, and its corners.
inline constexpr int kCubeSquares[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                           {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
inline model::Point3 cubeCorner(int i) {
  return {double(i & 1), double(i >> 1 & 1), double(i >> 2)};
}

}  // namespace t4d::formats
