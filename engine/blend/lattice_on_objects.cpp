#include "engine/blend/lattice_on_objects.h"

#include <tbb/parallel_for.h>

namespace slicemorph {

LatticeOnObjects latticeOnObjects(const Displacements& map, const Fields& fields,
                                  const std::vector<Chart>& charts) {
  const Lattice& lattice = map.lattice;
  LatticeOnObjects on{lattice, charts, map.of, {}, map.of, std::vector<std::vector<float>>(fields.size())};
  for (size_t k = 0; k < fields.size(); ++k) {
    on.anchor.push_back(fields[k]->anchor());
    on.distance[k].resize(lattice.count());
    const double unit = 1 / charts[k].meanScale();
    tbb::parallel_for(0, int(lattice.size[2]), [&](int z) {
      for (int y = 0; y < lattice.size[1]; ++y)
        for (int x = 0; x < lattice.size[0]; ++x) {
          const size_t i = lattice.index(x, y, z);
          on.chart[k][i] += openvdb::Vec3s(lattice.position(x, y, z));
          const Vec3d world = charts[k].toWorld(Vec3d(on.chart[k][i]));
          on.position[k][i] = fields[k]->relative(world);
          const bool crossed = charts[k].spread(Vec3d(on.chart[k][i])) <= 0;
          on.distance[k][i] = crossed ? kNothingThere : float(unit * fields[k]->coarse(world));
        }
    });
  }
  return on;
}

std::vector<const VectorField*> positionFields(const LatticeOnObjects& on) {
  std::vector<const VectorField*> fields;
  for (const VectorField& field : on.position) fields.push_back(&field);
  return fields;
}

}  // namespace slicemorph
