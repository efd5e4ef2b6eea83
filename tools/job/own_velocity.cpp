#include "tools/job/own_velocity.h"

#include "io/atomic_file.h"
#include "io/vdb/vector_parts.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/vdb_writer.h"

#include <openvdb/tools/ValueTransformer.h>

#include <algorithm>
#include <fstream>
#include <set>

namespace slicemorph {
namespace {

using openvdb::GridBase;
using Scalable = openvdb::TypeList<FloatGrid, openvdb::DoubleGrid, openvdb::Vec3SGrid, openvdb::Vec3DGrid>;

template <typename Grid>
void scale(Grid& grid, double factor) {
  using Value = typename Grid::ValueType;
  const auto times = [factor](const Value& value) {
    if constexpr (openvdb::VecTraits<Value>::IsVec)
      return Value(value * typename Value::ValueType(factor));
    else
      return Value(value * factor);
  };
  // Also where a grid is not active: interpolation looks there.
  openvdb::tools::foreach (grid.beginValueAll(), [&](const auto& it) { it.setValue(times(*it)); });
}

bool isVectors(const GridBase& grid) {
  return grid.isType<openvdb::Vec3SGrid>() || grid.isType<openvdb::Vec3DGrid>();
}

void copyBytes(const std::string& from, const std::string& to) {
  std::ifstream in(from, std::ios::binary);
  AtomicFile file(to);
  std::vector<char> part(size_t(1) << 20);
  while (in.read(part.data(), std::streamsize(part.size())) || in.gcount() > 0)
    file.write({part.data(), size_t(in.gcount())});
  if (!in.eof()) throw IoError(from, "cannot be read");
  file.commit();
}

std::string withoutNumber(const std::string& name) { return name.substr(0, name.find('[')); }

}  // namespace

bool isOwnVelocity(const GridSet& set, const GridBase& grid, const VelocitySettings& velocity) {
  return (isVelocityName(set.name) && (isVectors(grid) || !velocity.add)) || set.name == velocity.name;
}

GridBase::ConstPtr scaledVectors(const GridBase::ConstPtr& grid, double factor) {
  if (factor == 1) return grid;
  const GridBase::Ptr scaled = grid->deepCopyGrid();
  scaled->apply<Scalable>([&](auto& typed) { scale(typed, factor); });
  return scaled;
}

void copyAtSpeed(const FrameJob& job, const MorphSettings& settings) {
  const VdbFile file(job.given);
  std::set<size_t> velocities;  // or their components
  if (job.speed != 1)
    for (const std::vector<size_t>& grids : findVelocities(file, settings.velocity.name))
      velocities.insert(grids.begin(), grids.end());
  const auto asked = [&](size_t i) {
    const std::string name = withoutNumber(file.entries()[i].name);
    return settings.grids.empty() || std::count(settings.grids.begin(), settings.grids.end(), name) > 0;
  };
  bool all = true;
  for (size_t i = 0; i < file.entries().size(); ++i) all = all && asked(i);
  if (all && velocities.empty()) return copyBytes(job.given, job.path);
  openvdb::GridCPtrVec grids;
  for (size_t i = 0; i < file.entries().size(); ++i) {
    if (!asked(i)) continue;
    const GridBase::ConstPtr grid = file.read(i);
    grids.push_back(velocities.count(i) ? scaledVectors(grid, job.speed) : grid);
  }
  VdbOutput options;
  options.metadata = file.metadata(), options.compression = file.compression();
  options.framesPerSecond = settings.framesPerSecond, options.frame = job.number;
  writeVdb(job.path, grids, options);
}

}  // namespace slicemorph
