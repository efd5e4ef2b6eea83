#pragma once

#include "slicemorph/errors.h"
#include "slicemorph/voxelise.h"
#include "tests/support/with_threads.h"

#include <gtest/gtest.h>

#include <initializer_list>
#include <string>
#include <vector>

/// What tests ask of an in-between's level set.
namespace slicemorph {

/// The vertices of its surface, world units.
inline std::vector<Vec3d> surfacePoints(const FloatGrid& levelSet) {
  std::vector<Vec3d> points;
  for (const openvdb::Vec3s& p : surfaceOf(levelSet).points) points.emplace_back(p);
  return points;
}

/// All active voxels with their values, for comparing results byte by byte.
inline std::string bytesOf(const FloatGrid& grid) {
  std::string bytes;
  const auto append = [&](const auto& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
  };
  for (auto value = grid.cbeginValueOn(); value; ++value)
    append(value.getCoord()[0]), append(value.getCoord()[1]), append(value.getCoord()[2]), append(*value);
  return bytes;
}

/// Expects from `make` the same level set, with something in it, on one thread and on each of these numbers of threads.
template <typename Make>
void expectSameForThreads(const Make& make, std::initializer_list<size_t> counts = {2, 4}) {
  const auto bytes = [&](size_t threads) { return withThreads(threads, [&] { return bytesOf(*make()); }); };
  const std::string one = bytes(1);
  EXPECT_FALSE(one.empty());
  for (const size_t threads : counts) EXPECT_EQ(one, bytes(threads)) << threads << " threads";
}

/// What a call says when it throws InputError; empty if it does not.
template <typename Call>
std::string refusal(const Call& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace slicemorph
