#include "io/vdb/grid_sets.h"

#include "engine/rebuild/warp_grid.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <map>

namespace slicemorph {
namespace {

/// A grid's name without the number that VdbEntry adds: `density[1]`, the second grid named
/// density, is `density`.
std::string plainName(const VdbEntry& entry) {
  const size_t bracket = entry.name.rfind('[');
  const bool numbered = bracket != std::string::npos && bracket > 0 && entry.name.back() == ']' &&
                        entry.name.find_first_not_of("0123456789", bracket + 1) == entry.name.size() - 1;
  return numbered ? entry.name.substr(0, bracket) : entry.name;
}

openvdb::GridBase::ConstPtr headerOf(const VdbFile& file, size_t index) {
  const openvdb::GridBase::ConstPtr header = file.readHeader(index);
  return header && canCarry(*header) ? header : nullptr;
}

}  // namespace

GridSets pairGrids(const std::vector<LoadedObject>& inputs, bool onlyNamed) {
  GridSets result;
  std::map<std::pair<std::string, int>, size_t> known;  // name and occurrence to the index of a set
  std::vector<std::string> types;
  for (size_t k = 0; k < inputs.size(); ++k) {
    if (!inputs[k].file) continue;
    const VdbFile& file = *inputs[k].file;
    std::map<std::string, int> seen;
    for (size_t i = 0; i < file.entries().size(); ++i) {
      const std::string name = plainName(file.entries()[i]);
      const std::pair<std::string, int> key{name, seen[name]++};
      if (onlyNamed && inputs[k].named && i != inputs[k].grid) continue;
      const openvdb::GridBase::ConstPtr header = headerOf(file, i);
      const std::string of = "grid '" + file.entries()[i].name + "' of " + inputs[k].object.name;
      if (!header) {
        result.notes.emplace_back(
            "vdb.grid-left-out", Severity::kNote, of,
            "is left out: values of the type " + file.entries()[i].type + " cannot be morphed");
        continue;
      }
      const auto [at, fresh] = known.emplace(key, result.sets.size());
      if (fresh) {
        result.sets.push_back({name, std::vector<std::optional<size_t>>(inputs.size())});
        types.push_back(header->valueType());
      } else if (types[at->second] != header->valueType()) {
        result.notes.emplace_back("vdb.grid-left-out", Severity::kNote, of,
                                  "is left out: it holds " + header->valueType() +
                                      " values, the one before of that name " + types[at->second]);
        continue;
      }
      result.sets[at->second].index[k] = i;
    }
  }
  return result;
}

GridSet shapeSet(const std::vector<LoadedObject>& inputs) {
  GridSet set;
  for (const LoadedObject& input : inputs) {
    const bool named = input.file && input.fog;
    if (named && set.name.empty()) set.name = plainName(input.file->entries()[input.grid]);
    set.index.push_back(named ? std::optional(input.grid) : std::nullopt);
  }
  return set;
}

std::vector<openvdb::GridBase::ConstPtr> readGrids(const GridSet& set,
                                                   const std::vector<LoadedObject>& inputs) {
  std::vector<openvdb::GridBase::ConstPtr> grids;
  for (size_t k = 0; k < inputs.size(); ++k)
    grids.push_back(set.index[k] ? inputs[k].file->readDelayed(*set.index[k]) : nullptr);
  return grids;
}

}  // namespace slicemorph
