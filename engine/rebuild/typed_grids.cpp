#include "engine/rebuild/typed_grids.h"

#include "slicemorph/errors.h"

#include <openvdb/tools/SignedFloodFill.h>
#include <tbb/parallel_for.h>

#include <type_traits>

namespace slicemorph {
namespace {

using openvdb::GridBase;

/// Adds leaves in index order, so that the tree is the same for any number of threads.
template <typename TreeType>
void addLeaves(TreeType& tree, std::vector<std::unique_ptr<typename TreeType::LeafNodeType>>& leaves) {
  for (auto& leaf : leaves)
    if (leaf) tree.addLeaf(leaf.release());
}

template <typename GridType>
class TypedNumbers
    : public NumberGrids<typename openvdb::VecTraits<typename GridType::ValueType>::ElementType> {
  using Value = typename GridType::ValueType;
  using Real = typename openvdb::VecTraits<Value>::ElementType;
  using Base = NumberGrids<Real>;
  using Channels = typename Base::Channels;
  using Leaf = typename GridType::TreeType::LeafNodeType;
  static constexpr int kChannels = openvdb::VecTraits<Value>::Size;

  class TypedReader : public Base::Reader {
   public:
    explicit TypedReader(const GridType& grid) : values_(grid.getConstAccessor()) {}
    void fill(LocalBlock<Real>& block, const openvdb::BBoxd& points) const override {
      block.template fill<GridType>(values_, points);
    }

   private:
    typename GridType::ConstAccessor values_;
  };

 public:
  explicit TypedNumbers(const std::vector<GridBase::ConstPtr>& grids) {
    for (const GridBase::ConstPtr& grid : grids) {
      grids_.push_back(openvdb::gridConstPtrCast<GridType>(grid));
      if (!grids_.back())
        throw InputError("grids of different types cannot be blended: " + grids[0]->type() + " and " +
                         grid->type());
    }
  }

  int channels() const override { return kChannels; }
  Channels background(size_t grid) const override { return channelsOf(grids_[grid]->background()); }
  ActiveBlocks activeBlocks(size_t grid) const override { return ActiveBlocks(grids_[grid]->tree()); }
  std::unique_ptr<typename Base::Reader> reader(size_t grid) const override {
    return std::make_unique<TypedReader>(*grids_[grid]);
  }

  void beginLeaves(size_t count, const Channels& background) override {
    background_ = valueOf(background.data(), 1);
    leaves_.resize(count);
  }

  void setLeaf(size_t n, const LeafValues<Real>& made) override {
    auto leaf = std::make_unique<Leaf>(made.origin, background_);
    for (openvdb::Index v = 0; v < Leaf::SIZE; ++v) {
      if (made.states[v] == LeafValues<Real>::kUntouched) continue;
      const Value value = valueOf(&made.values[v], Leaf::SIZE);
      made.states[v] == LeafValues<Real>::kOn ? leaf->setValueOn(v, value) : leaf->setValueOff(v, value);
    }
    if (!leaf->isEmpty()) leaves_[n] = std::move(leaf);
  }

  GridBase::Ptr endLeaves(bool band) override {
    auto result = GridType::create(background_);
    addLeaves(result->tree(), leaves_);
    if constexpr (std::is_same_v<GridType, FloatGrid>)
      if (band) openvdb::tools::signedFloodFill(result->tree());
    result->tree().prune();
    return result;
  }

 private:
  static Channels channelsOf(const Value& value) {
    if constexpr (kChannels == 1)
      return {value, Real(0), Real(0)};
    else
      return {value[0], value[1], value[2]};
  }
  static Value valueOf(const Real* channels, size_t step) {
    if constexpr (kChannels == 1)
      return *channels;
    else
      return Value(channels[0], channels[step], channels[2 * step]);
  }

  std::vector<typename GridType::ConstPtr> grids_;
  Value background_{};
  std::vector<std::unique_ptr<Leaf>> leaves_;
};

template <typename GridType>
GridBase::Ptr nearestOf(const GridType& grid, const std::vector<openvdb::Coord>& origins,
                        const LeafVisitor& visit) {
  using Leaf = typename GridType::TreeType::LeafNodeType;
  std::vector<std::unique_ptr<Leaf>> leaves(origins.size());
  tbb::parallel_for(
      tbb::blocked_range<size_t>(0, origins.size()), [&](const tbb::blocked_range<size_t>& range) {
        const auto values = grid.getConstAccessor();
        for (size_t n = range.begin(); n != range.end(); ++n) {
          auto leaf = std::make_unique<Leaf>(origins[n], grid.background());
          visit(origins[n], [&](const std::vector<Vec3d>& positions, const openvdb::Coord& first, int side) {
            for (size_t v = 0; v < positions.size(); ++v) {
              typename GridType::ValueType value{};
              if (!values.probeValue(openvdb::Coord::round(positions[v]), value)) continue;
              const int i = int(v);
              leaf->setValueOn(
                  Leaf::coordToOffset(first.offsetBy(i / (side * side), i / side % side, i % side)), value);
            }
          });
          if (!leaf->isEmpty()) leaves[n] = std::move(leaf);
        }
      });
  auto result = GridType::create(grid.background());
  addLeaves(result->tree(), leaves);
  result->tree().prune();
  return result;
}

}  // namespace

template <typename Real>
std::unique_ptr<NumberGrids<Real>> numberGrids(const std::vector<GridBase::ConstPtr>& grids) {
  std::unique_ptr<NumberGrids<Real>> result;
  grids.front()->apply<BlendedTypes>([&](const auto& grid) {
    using GridType = std::decay_t<decltype(grid)>;
    if constexpr (std::is_same_v<typename openvdb::VecTraits<typename GridType::ValueType>::ElementType,
                                 Real>)
      result = std::make_unique<TypedNumbers<GridType>>(grids);
  });
  return result;
}

template std::unique_ptr<NumberGrids<float>> numberGrids(const std::vector<GridBase::ConstPtr>&);
template std::unique_ptr<NumberGrids<double>> numberGrids(const std::vector<GridBase::ConstPtr>&);

GridBase::Ptr nearestValues(const GridBase& grid, const std::vector<openvdb::Coord>& leaves,
                            const LeafVisitor& visit) {
  GridBase::Ptr result;
  grid.apply<NearestTypes>([&](const auto& typed) { result = nearestOf(typed, leaves, visit); });
  return result;
}

std::unique_ptr<ActiveBlocks> nearestActiveBlocks(const GridBase& grid) {
  std::unique_ptr<ActiveBlocks> result;
  grid.apply<NearestTypes>([&](const auto& typed) { result = std::make_unique<ActiveBlocks>(typed.tree()); });
  return result;
}

}  // namespace slicemorph
