#include "tools/job/reconstruct_grey.h"

#include "engine/reconstruct/grey_slices.h"
#include "engine/volume/resample_image.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/image_writer.h"
#include "slicemorph/io/output.h"
#include "tools/job/given_slices.h"
#include "tools/job/image_lattice.h"

#include <algorithm>
#include <utility>

namespace slicemorph {
namespace {

GivenSlices holding(const std::vector<char>& found, int axis) {
  GivenSlices given{axis, {}, {}};
  for (int at = 0; at < int(found.size()); ++at)
    if (found[size_t(at)]) given.at.push_back(at);
  return given;
}

/// The slices that hold more than one value, along the axis with the most that do not between them.
GivenSlices foundIn(const ReconstructJob& job, const Image& image) {
  GivenSlices best;
  int most = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (job.axis >= 0 && axis != job.axis) continue;
    GivenSlices given = holding(slicesWithValues(image, axis), axis);
    if (given.at.size() < 2) continue;
    const int empty = given.at.back() - given.at.front() + 1 - int(given.at.size());
    // A dense image may have a few flat slices, too: a sparse one has at least every second.
    if (empty + 1 < int(given.at.size())) continue;
    if (empty > most) most = empty, best = std::move(given);
  }
  if (most == 0)
    throw InputError(
        job.input +
        " is a grey image, and hardly any slice is empty (of one value) between others; --between N puts N "
        "slices between every two of a stack, --given K,K,... names those that count, --image labels "
        "takes the values as labels");
  return best;
}

GivenSlices givenOf(const ReconstructJob& job, const Image& image) {
  const Vec3d spacing = image.lattice.spacing();
  const int axis = job.axis >= 0 ? job.axis : int(openvdb::math::MaxIndex(spacing));
  const int size = image.lattice.size[axis];
  GivenSlices given{axis, job.given, {}};
  const int step = job.between > 0 ? job.between + 1 : job.every;
  for (int at = 0, count = job.between > 0 ? (size - 1) * step + 1 : size; step > 0 && at < count; at += step)
    given.at.push_back(at);
  if (given.at.empty()) return foundIn(job, image);
  if (given.at.size() < 2 || (job.between == 0 && given.at.back() >= size))
    throw InputError(job.input + " has " + std::to_string(size) + " slices along axis " + "ijk"[axis] +
                     ", too few for the given ones; --axis says along which they lie");
  return given;
}

}  // namespace

void reconstructGrey(const ReconstructJob& job, ImageFile file, JobEvents& events) {
  if (!isImageOutput(job.output))
    throw InputError(
        "-o " + job.output + ": " + job.input +
        " is a grey image, whose slices make an image; --image labels takes its values as labels");
  if (OutputName(job.output).isSequence() || !job.reports.empty())
    throw InputError((job.reports.empty() ? "-o " + job.output : "--report " + job.reports[0]) +
                     " is for labels; " + job.input + " is a grey image, or say --image labels");
  const GivenSlices given = givenOf(job, file.image);
  Notes notes = std::move(file.notes);
  notes.emplace_back("reconstruct.grey", Severity::kNote, "",
                     "taken as grey values (--image labels takes them as labels): " + described(given));
  events.notes(about(job.input, notes));
  Image image = job.between > 0 ? expandedStack(file.image, given.axis, job.between) : std::move(file.image);
  image = interpolateGrey(std::move(image), given);
  if (!job.like.empty()) {
    const ImageVoxels like = voxelsLike(job.like, job.image);
    image = resampledTo(image, like.lattice), file.header.forms = like.forms;
  }
  if (job.takeImage) return job.takeImage(std::move(image));
  writeImage(job.output, image, file.header);
  events.fileWritten(job.output, false);
}

}  // namespace slicemorph
