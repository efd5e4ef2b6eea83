#include "io/vdb/vector_parts.h"

#include "io/paths.h"
#include "io/vdb/grid_choice.h"

#include <map>
#include <optional>
#include <set>

namespace slicemorph {
namespace {

/// Stems whose components are told by a last letter alone; any other stem needs a mark before it.
const std::set<std::string> kBareStems{"vel", "v", "velocity"};

openvdb::Vec3SGrid::Ptr asFloatVectors(const openvdb::GridBase::Ptr& grid) {
  if (const auto vectors = openvdb::GridBase::grid<openvdb::Vec3SGrid>(grid)) return vectors;
  const auto doubles = openvdb::GridBase::grid<openvdb::Vec3DGrid>(grid);
  if (!doubles) return nullptr;
  const auto vectors = std::make_shared<openvdb::Vec3SGrid>(*doubles);
  vectors->setTransform(doubles->transformPtr());
  vectors->setGridClass(doubles->getGridClass());
  return vectors;
}

/// The name without its component: `vel` of `vel.x`, with the mark between them, and which component it is.
struct Component {
  std::string stem, mark;
  int axis = 0;
};

std::optional<Component> componentOf(const std::string& name) {
  if (name.size() < 2) return std::nullopt;
  const std::string lower = lowered(name);
  const int axis = int(std::string("xyz").find(lower.back()));
  if (axis < 0 || axis > 2) return std::nullopt;
  const char before = name[name.size() - 2];
  if (before == '.' || before == '_') {
    if (name.size() < 3) return std::nullopt;
    return Component{name.substr(0, name.size() - 2), std::string(1, before), axis};
  }
  const std::string stem = name.substr(0, name.size() - 1);
  if (!kBareStems.count(lowered(stem))) return std::nullopt;
  return Component{stem, "", axis};
}

bool fitTogether(const openvdb::GridBase& a, const openvdb::GridBase& b) {
  return a.type() == b.type() && a.transform() == b.transform();
}

template <typename Vectors, typename Numbers>
openvdb::GridBase::Ptr vectorsOf(const std::array<openvdb::GridBase::ConstPtr, 3>& parts) {
  typename Numbers::ConstPtr numbers[3];
  for (size_t a = 0; a < 3; ++a) numbers[a] = openvdb::GridBase::grid<Numbers>(parts[a]);
  using Vector = typename Vectors::ValueType;
  const Vector background(numbers[0]->background(), numbers[1]->background(), numbers[2]->background());
  auto tree =
      std::make_shared<typename Vectors::TreeType>(numbers[0]->tree(), background, openvdb::TopologyCopy());
  tree->topologyUnion(numbers[1]->tree());
  tree->topologyUnion(numbers[2]->tree());
  tree->voxelizeActiveTiles();
  const auto x = numbers[0]->getConstAccessor(), y = numbers[1]->getConstAccessor(),
             z = numbers[2]->getConstAccessor();
  for (auto value = tree->beginValueOn(); value; ++value) {
    const openvdb::Coord at = value.getCoord();
    value.setValue(Vector(x.getValue(at), y.getValue(at), z.getValue(at)));
  }
  return Vectors::create(tree);
}

template <typename Numbers, typename Vectors>
openvdb::GridBase::Ptr component(const Vectors& vectors, int axis) {
  auto tree = std::make_shared<typename Numbers::TreeType>(vectors.tree(), vectors.background()[axis],
                                                           openvdb::TopologyCopy());
  const auto from = vectors.getConstAccessor();
  tree->voxelizeActiveTiles();
  for (auto value = tree->beginValueOn(); value; ++value)
    value.setValue(from.getValue(value.getCoord())[axis]);
  return Numbers::create(tree);
}

}  // namespace

bool isVelocityName(const std::string& name) { return kBareStems.count(name) > 0; }

std::vector<std::vector<size_t>> findVelocities(const VdbFile& file, const std::string& ownName) {
  const auto named = [&](const std::string& name) { return isVelocityName(name) || name == ownName; };
  std::vector<std::vector<size_t>> found;
  for (size_t i = 0; i < file.entries().size(); ++i) {
    const std::string& name = file.entries()[i].name;
    if (!named(name.substr(0, name.find('[')))) continue;
    const openvdb::GridBase::Ptr header = file.readHeader(i);
    if (header && (header->isType<openvdb::Vec3SGrid>() || header->isType<openvdb::Vec3DGrid>()))
      found.push_back({i});
  }
  for (const VectorParts& parts : findVectorParts(file))
    if (named(parts.name)) found.emplace_back(parts.index.begin(), parts.index.end());
  return found;
}

openvdb::Vec3SGrid::Ptr readVelocity(const VdbFile& file) {
  const std::vector<std::vector<size_t>> found = findVelocities(file);
  if (found.empty()) return nullptr;
  const std::vector<size_t>& at = found.front();
  return asFloatVectors(at.size() == 1
                            ? file.read(at[0])
                            : joinParts({file.read(at[0]), file.read(at[1]), file.read(at[2])}, "velocity"));
}

std::vector<VectorParts> findVectorParts(const VdbFile& file) {
  std::map<std::pair<std::string, std::string>, std::array<std::vector<size_t>, 3>> found;
  std::vector<std::pair<std::string, std::string>> order;
  for (size_t i = 0; i < file.entries().size(); ++i) {
    const std::optional<Component> part = componentOf(file.entries()[i].name);
    if (!part) continue;
    const std::pair<std::string, std::string> key{part->stem, part->mark};
    if (!found.count(key)) order.push_back(key);
    found[key][size_t(part->axis)].push_back(i);
  }
  std::vector<VectorParts> result;
  for (const auto& key : order) {
    const auto& axes = found[key];
    if (axes[0].size() != 1 || axes[1].size() != 1 || axes[2].size() != 1) continue;
    const openvdb::GridBase::ConstPtr x = file.readHeader(axes[0][0]), y = file.readHeader(axes[1][0]),
                                      z = file.readHeader(axes[2][0]);
    if (!x || !y || !z || !isScalar(*x) || !fitTogether(*x, *y) || !fitTogether(*x, *z)) continue;
    result.push_back({key.first, {axes[0][0], axes[1][0], axes[2][0]}});
  }
  return result;
}

openvdb::GridBase::Ptr joinParts(const std::array<openvdb::GridBase::ConstPtr, 3>& parts,
                                 const std::string& name) {
  const openvdb::GridBase::Ptr grid = parts[0]->isType<openvdb::DoubleGrid>()
                                          ? vectorsOf<openvdb::Vec3DGrid, openvdb::DoubleGrid>(parts)
                                          : vectorsOf<openvdb::Vec3SGrid, FloatGrid>(parts);
  grid->insertMeta(*parts[0]);
  grid->setTransform(parts[0]->transform().copy());
  grid->setSaveFloatAsHalf(parts[0]->saveFloatAsHalf());
  grid->setName(name);
  grid->setVectorType(openvdb::VEC_CONTRAVARIANT_RELATIVE);
  return grid;
}

openvdb::GridPtrVec splitParts(const openvdb::GridBase& vectors, const std::vector<std::string>& names) {
  openvdb::GridPtrVec parts;
  for (int axis = 0; axis < 3; ++axis) {
    openvdb::GridBase::Ptr part;
    vectors.apply<openvdb::TypeList<openvdb::Vec3SGrid>>(
        [&](const openvdb::Vec3SGrid& grid) { part = component<FloatGrid>(grid, axis); });
    vectors.apply<openvdb::TypeList<openvdb::Vec3DGrid>>(
        [&](const openvdb::Vec3DGrid& grid) { part = component<openvdb::DoubleGrid>(grid, axis); });
    part->insertMeta(vectors);
    part->removeMeta(openvdb::GridBase::META_VECTOR_TYPE);
    part->setTransform(vectors.transform().copy());
    part->setSaveFloatAsHalf(vectors.saveFloatAsHalf());
    part->setName(names[size_t(axis)]);
    parts.push_back(part);
  }
  return parts;
}

}  // namespace slicemorph
