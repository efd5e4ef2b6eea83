#include "engine/rebuild/still_images.h"

#include "engine/rebuild/common_values.h"
#include "engine/volume/resample_image.h"
#include "engine/volume/same_image.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace slicemorph {

bool allSame(const std::vector<CarriedImage>& images) {
  return std::all_of(images.begin(), images.end(), [&](const CarriedImage& c) {
    return c.iso && c.iso == images[0].iso && isSame(*images[0].image, *c.image);
  });
}

Image blendStill(const std::vector<CarriedImage>& images, const ImageLattice& on) {
  std::vector<const Image*> all;
  std::vector<ResampledRows> rows;
  for (const CarriedImage& c : images) all.push_back(c.image), rows.emplace_back(*c.image, on);
  Image result{on, commonValues(all, on.count())};
  tbb::parallel_for(tbb::blocked_range<int>(0, on.size[2]), [&](const tbb::blocked_range<int>& slices) {
    std::vector<double> first(size_t(on.size[0])), other = first, blend = first;
    for (int k = slices.begin(); k < slices.end(); ++k)
      for (int j = 0; j < on.size[1]; ++j) {
        rows[0].read(j, k, first.data());
        blend = first;
        for (size_t c = 1; c < rows.size(); ++c) {
          rows[c].read(j, k, other.data());
          for (size_t i = 0; i < blend.size(); ++i)
            if (other[i] != first[i]) blend[i] += images[c].weight * (other[i] - first[i]);
        }
        storeRow(blend, on.index(0, j, k), result.values);
      }
  });
  return result;
}

}  // namespace slicemorph
