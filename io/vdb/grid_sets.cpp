#include "io/vdb/grid_sets.h"

#include "engine/rebuild/warp_grid.h"
#include "io/vdb/grid_choice.h"
#include "io/vdb/vector_parts.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <map>

namespace slicemorph {
namespace {

openvdb::GridBase::ConstPtr headerOf(const VdbFile& file, size_t index) {
  const openvdb::GridBase::ConstPtr header = file.readHeader(index);
  return header && canCarry(*header) ? header : nullptr;
}

/// The grids of a file as sets take them: each alone, or three as the components of one.
struct Item {
  size_t index;
  std::string name;  ///< of the set
  std::string key;   ///< what is paired: three components are no one grid of vectors
  std::string type;  ///< of the values; empty: cannot be morphed
  std::vector<std::string> parts;
  std::array<size_t, 2> others;
};

std::vector<Item> itemsOf(const VdbFile& file) {
  const std::vector<VectorParts> vectors = findVectorParts(file);
  std::vector<Item> items;
  for (size_t i = 0; i < file.entries().size(); ++i) {
    const auto isPart = [&](const VectorParts& v, size_t from) {
      return std::find(v.index.begin() + long(from), v.index.end(), i) != v.index.end();
    };
    if (std::any_of(vectors.begin(), vectors.end(),
                    [&](const VectorParts& v) { return v.index[0] != i && isPart(v, 1); }))
      continue;
    const openvdb::GridBase::ConstPtr header = headerOf(file, i);
    Item item{i, plainName(file.entries()[i]), "", header ? header->valueType() : "", {}, {}};
    item.key = item.name;
    for (const VectorParts& v : vectors) {
      if (v.index[0] != i) continue;
      item.name = v.name;
      for (size_t part : v.index) item.parts.push_back(file.entries()[part].name);
      item.key = item.parts[0] + " " + item.parts[1] + " " + item.parts[2];
      item.others = {v.index[1], v.index[2]};
    }
    items.push_back(std::move(item));
  }
  return items;
}

}  // namespace

GridSets pairGrids(const std::vector<LoadedObject>& inputs, bool onlyNamed) {
  GridSets result;
  std::map<std::pair<std::string, int>, size_t> known;  // key and occurrence to the index of a set
  std::vector<std::string> types;
  for (size_t k = 0; k < inputs.size(); ++k) {
    if (!inputs[k].file) continue;
    const VdbFile& file = *inputs[k].file;
    std::map<std::string, int> seen;
    for (const Item& item : itemsOf(file)) {
      const std::pair<std::string, int> key{item.key, seen[item.key]++};
      if (onlyNamed && inputs[k].named && item.index != inputs[k].grid) continue;
      const std::string of = "grid '" + file.entries()[item.index].name + "' of " + inputs[k].object.name;
      if (item.type.empty()) {
        result.notes.emplace_back(
            "vdb.grid-left-out", Severity::kNote, of,
            "is left out: values of the type " + file.entries()[item.index].type + " cannot be morphed");
        continue;
      }
      const auto [at, fresh] = known.emplace(key, result.sets.size());
      if (fresh) {
        result.sets.push_back({item.name, std::vector<std::optional<size_t>>(inputs.size()), item.parts,
                               std::vector<std::array<size_t, 2>>(item.parts.empty() ? 0 : inputs.size())});
        types.push_back(item.type);
      } else if (types[at->second] != item.type) {
        result.notes.emplace_back("vdb.grid-left-out", Severity::kNote, of,
                                  "is left out: it holds " + item.type +
                                      " values, the one before of that name " + types[at->second]);
        continue;
      }
      GridSet& set = result.sets[at->second];
      set.index[k] = item.index;
      if (!set.parts.empty()) set.others[k] = item.others;
    }
  }
  return result;
}

GridSet shapeSet(const std::vector<LoadedObject>& inputs) {
  GridSet set;
  for (const LoadedObject& input : inputs) {
    const bool fog = input.file && input.fog;
    if (fog && set.name.empty()) set.name = input.gridName;
    set.index.push_back(fog && input.grid != LoadedObject::kNoGrid ? std::optional(input.grid)
                                                                   : std::nullopt);
  }
  return set;
}

std::vector<openvdb::GridBase::ConstPtr> readGrids(const GridSet& set,
                                                   const std::vector<LoadedObject>& inputs) {
  std::vector<openvdb::GridBase::ConstPtr> grids;
  for (size_t k = 0; k < inputs.size(); ++k) {
    if (!set.index[k]) {
      grids.push_back(nullptr);
      continue;
    }
    const VdbFile& file = *inputs[k].file;
    const openvdb::GridBase::Ptr grid = file.readDelayed(*set.index[k]);
    grids.push_back(placed(set.parts.empty() ? grid
                                             : joinParts({grid, file.readDelayed(set.others[k][0]),
                                                          file.readDelayed(set.others[k][1])},
                                                         set.name),
                           inputs[k].placing));
  }
  return grids;
}

}  // namespace slicemorph
