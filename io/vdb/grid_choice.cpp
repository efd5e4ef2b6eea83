#include "io/vdb/grid_choice.h"

#include "engine/volume/same_grid.h"
#include "engine/volume/surface_colors.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <set>

namespace slicemorph {
namespace {

openvdb::GridBase::Ptr headerOrNull(const VdbFile& file, size_t index) {
  try {
    return file.readHeader(index);
  } catch (const IoError&) {
    return nullptr;
  }
}

/// Whether nearly all of the grid's box is active, by the statistics in its header. A narrow band fills a
/// small part of its box, the domain of a simulation all of it; 90 % is far from both.
bool isDense(const openvdb::GridBase& grid) {
  const auto count = grid.getMetadata<openvdb::Int64Metadata>(openvdb::GridBase::META_FILE_VOXEL_COUNT);
  const auto low = grid.getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MIN);
  const auto high = grid.getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MAX);
  if (!count || !low || !high) return false;
  const openvdb::CoordBBox box{openvdb::Coord(low->value()), openvdb::Coord(high->value())};
  return double(count->value()) > 0.9 * double(box.volume());
}

/// The words of a name, lower case: `phi_obstacle`, `phiObstacle` and `phi.Obstacle2` are phi and obstacle.
std::vector<std::string> wordsOf(const std::string& name) {
  std::vector<std::string> words(1);
  char before = 0;
  for (char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::islower(static_cast<unsigned char>(before)) && std::isupper(byte)) words.emplace_back();
    if (std::isalpha(byte))
      words.back() += char(std::tolower(byte));
    else if (!words.back().empty())
      words.emplace_back();
    before = c;
  }
  if (words.back().empty()) words.pop_back();
  return words;
}

/// Names as Mantaflow (Blender), FLIP solvers of Houdini, RealFlow and Bifrost have them.
const std::set<std::string> kLiquidWords{"phi", "liquid", "fluid", "water"};
const std::set<std::string> kStaticWords{
    "obstacle", "obstacles",  "obs",       "collision", "collisions", "collider", "colliders", "static",
    "boundary", "boundaries", "container", "tank",      "guide",      "guiding",  "in",        "out",
    "inflow",   "outflow",    "inlet",     "outlet",    "emitter",    "emission", "domain"};

bool holdsAny(const std::vector<std::string>& words, const std::set<std::string>& of) {
  return std::any_of(words.begin(), words.end(), [&](const std::string& word) { return of.count(word) > 0; });
}

/// The kinds of grids in the order in which they are tried.
enum Kind { kLiquid, kLiquidPart, kLevelSet, kDensity, kDense, kUnknown, kFog, kKinds };
const std::array<const char*, kKinds> kWhy{"a level set that is named as the surface of a liquid",
                                           "a level set that is named as a part of a liquid",
                                           "a level set",
                                           "the density",
                                           "a level set with values all over its box",
                                           "values of no class",
                                           "a fog volume"};

Kind kindOf(const openvdb::GridBase& grid) {
  const openvdb::GridClass gridClass = grid.getGridClass();
  if (gridClass == openvdb::GRID_LEVEL_SET) {
    const std::vector<std::string> words = wordsOf(grid.getName());
    const bool liquid = isLiquidName(grid.getName());
    if (!words.empty() && (words.back() == "surface" || (liquid && words.size() == 1))) return kLiquid;
    return liquid ? kLiquidPart : isDense(grid) ? kDense : kLevelSet;
  }
  if (grid.getName() == "density") return kDensity;
  return gridClass == openvdb::GRID_FOG_VOLUME ? kFog : kUnknown;
}

/// The statistics by which two files' grids can be told apart without reading them.
bool haveOtherStatistics(const openvdb::GridBase& a, const openvdb::GridBase& b) {
  for (const char* name : {openvdb::GridBase::META_FILE_VOXEL_COUNT, openvdb::GridBase::META_FILE_BBOX_MIN,
                           openvdb::GridBase::META_FILE_BBOX_MAX}) {
    const openvdb::Metadata::ConstPtr x = a[name], y = b[name];
    if (x && y && x->str() != y->str()) return true;
  }
  return false;
}

/// Whether a grid is the same in another file.
bool isSameIn(const VdbFile& file, size_t index, const VdbFile& other) {
  const openvdb::GridBase::Ptr header = headerOrNull(file, index);
  for (size_t i = 0; header && i < other.entries().size(); ++i) {
    if (other.entries()[i].name != file.entries()[index].name) continue;
    const openvdb::GridBase::Ptr there = headerOrNull(other, i);
    if (!there || !isScalar(*there) || haveOtherStatistics(*header, *there)) return false;
    const FloatGrid::ConstPtr a = asFloatGrid(file.read(index)), b = asFloatGrid(other.read(i));
    return isSame(*a, *b);
  }
  return false;
}

/// Marks the level sets that are the same in all other files, unless all are.
void markUnchanged(const VdbFile& file, const std::vector<std::string>& besides,
                   std::vector<GridCandidate>& candidates) {
  std::vector<GridCandidate*> levelSets;
  for (GridCandidate& c : candidates)
    if (const auto header = headerOrNull(file, c.index);
        !c.isStatic && header->getGridClass() == openvdb::GRID_LEVEL_SET)
      levelSets.push_back(&c);
  if (levelSets.size() < 2 || besides.empty()) return;
  std::vector<GridCandidate*> unchanged;
  for (GridCandidate* c : levelSets)
    if (std::all_of(besides.begin(), besides.end(),
                    [&](const std::string& path) { return isSameIn(file, c->index, VdbFile(path)); }))
      unchanged.push_back(c);
  if (unchanged.size() == levelSets.size()) return;
  for (GridCandidate* c : unchanged) c->isStatic = true, c->why += " that does not change";
}

std::string listOf(const VdbFile& file) {
  if (file.entries().empty()) return "the file holds no grids";
  std::string list = "the file holds";
  for (size_t i = 0; i < file.entries().size(); ++i) {
    const openvdb::GridBase::Ptr grid = headerOrNull(file, i);
    const std::string kind =
        grid ? grid->valueType() + ", " + openvdb::GridBase::gridClassToMenuName(grid->getGridClass())
             : file.entries()[i].type;
    list += (i ? ", '" : " '") + file.entries()[i].name + "' (" + kind + ")";
  }
  return list;
}

}  // namespace

bool isScalar(const openvdb::GridBase& grid) {
  return grid.isType<FloatGrid>() || grid.isType<openvdb::DoubleGrid>();
}

size_t findGrid(const VdbFile& file, const InputSpec& input) {
  const std::string& name = input.selection;
  for (size_t i = 0; i < file.entries().size(); ++i) {
    const bool first = file.entries()[i].name == name + "[0]";
    if (file.entries()[i].name != name && !first) continue;
    const openvdb::GridBase::Ptr grid = file.readHeader(i);
    if (grid && isScalar(*grid)) return i;
    throw InputError(input.path, "grid '" + name + "' holds " + (grid ? grid->valueType() : "unknown") +
                                     " values, no scalar ones that have a surface; " + listOf(file));
  }
  throw InputError(input.path, "there is no grid '" + name + "'; " + listOf(file));
}

std::string plainName(const VdbEntry& entry) {
  const size_t bracket = entry.name.rfind('[');
  const bool numbered = bracket != std::string::npos && bracket > 0 && entry.name.back() == ']' &&
                        entry.name.find_first_not_of("0123456789", bracket + 1) == entry.name.size() - 1;
  return numbered ? entry.name.substr(0, bracket) : entry.name;
}

bool isLiquidName(const std::string& name) {
  return holdsAny(wordsOf(name), kLiquidWords) && !isStaticName(name);
}

bool isStaticName(const std::string& name) { return holdsAny(wordsOf(name), kStaticWords); }

std::vector<GridCandidate> gridCandidates(const VdbFile& file, const std::string& path,
                                          const std::vector<std::string>& besides) {
  std::vector<GridCandidate> candidates;
  std::vector<Kind> kinds(file.entries().size(), kKinds);
  for (size_t i = 0; i < file.entries().size(); ++i) {
    const openvdb::GridBase::Ptr grid = headerOrNull(file, i);
    if (!grid || !isScalar(*grid)) continue;
    kinds[i] = kindOf(*grid);
    const bool still = isStaticName(grid->getName());
    candidates.push_back(
        {i, still, kWhy[kinds[i]] + std::string(still ? " that is named as what stands still" : "")});
  }
  if (candidates.empty())
    throw InputError(path, "no grid of scalar values to take a surface from; " + listOf(file));
  markUnchanged(file, besides, candidates);
  std::stable_sort(candidates.begin(), candidates.end(), [&](const GridCandidate& a, const GridCandidate& b) {
    return std::pair(a.isStatic, kinds[a.index]) < std::pair(b.isStatic, kinds[b.index]);
  });
  return candidates;
}

std::vector<size_t> gridsToTry(const VdbFile& file, const std::string& path) {
  std::vector<size_t> indices;
  for (const GridCandidate& candidate : gridCandidates(file, path)) indices.push_back(candidate.index);
  return indices;
}

std::optional<size_t> findColors(const VdbFile& file) {
  const auto rank = [](const std::string& name) { return name == "Cd" ? 0 : name == "color" ? 1 : 2; };
  std::optional<size_t> best;
  int least = 3;
  for (size_t i = 0; i < file.entries().size(); ++i) {
    const openvdb::GridBase::Ptr grid = headerOrNull(file, i);
    if (!grid || !isColorName(grid->getName()) || rank(grid->getName()) >= least) continue;
    if (!grid->isType<openvdb::Vec3SGrid>() && !grid->isType<openvdb::Vec3DGrid>()) continue;
    best = i, least = rank(grid->getName());
  }
  return best;
}

openvdb::Vec3SGrid::ConstPtr asColorGrid(const openvdb::GridBase::Ptr& grid) {
  if (const auto doubles = openvdb::GridBase::grid<openvdb::Vec3DGrid>(grid)) {
    return openvdb::Vec3SGrid::ConstPtr(new openvdb::Vec3SGrid(*doubles));
  }
  return openvdb::GridBase::grid<openvdb::Vec3SGrid>(grid);
}

FloatGrid::ConstPtr asFloatGrid(const openvdb::GridBase::Ptr& grid) {
  if (const auto doubles = openvdb::GridBase::grid<openvdb::DoubleGrid>(grid)) {
    return FloatGrid::ConstPtr(new FloatGrid(*doubles));
  }
  return openvdb::GridBase::grid<FloatGrid>(grid);
}

}  // namespace slicemorph
