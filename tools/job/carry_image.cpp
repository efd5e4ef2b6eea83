#include "tools/job/carry_image.h"

#include "engine/rebuild/common_values.h"
#include "engine/volume/resample_image.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/image_file.h"
#include "tools/job/image_lattice.h"

namespace slicemorph {

namespace {

/// The frame in the type that holds the values of all inputs, so that all frames have one.
Image asInputs(Image frame, const FrameTask& task) {
  std::vector<const Image*> inputs;
  for (const LoadedObject& object : task.inputs) inputs.push_back(object.image.get());
  const ImageValues type = commonValues(inputs, 0);
  if (frame.values.index() != type.index()) frame.values = valuesAs(frame.values, type);
  return frame;
}

}  // namespace

ImagePlan planImages(const MorphSettings& settings, const std::vector<LoadedObject>& inputs) {
  const bool labels = inputs[0].labels;
  for (size_t k = 1; k < inputs.size(); ++k)
    if (inputs[k].labels != labels)
      throw InputError(settings.inputs[labels ? 0 : k] + " is a map of labels and " +
                       settings.inputs[labels ? k : 0] +
                       " holds grey values; --image grey or labels reads both alike");
  ImagePlan plan;
  plan.header = inputs[0].imageHeader;
  if (labels)
    for (const LoadedObject& input : inputs) plan.labels.emplace_back(*input.image);
  if (!settings.like.empty()) {
    const ImageVoxels like = voxelsLike(settings.like, settings.load.image);
    plan.lattice = like.lattice, plan.header.forms = like.forms;
  } else {
    LatticeChoice choice = latticeAround(inputs);
    plan.lattice = choice.lattice, plan.notes = std::move(choice.notes);
  }
  if (settings.plan.voxelSize > 0 || settings.load.resolution > 0)
    plan.lattice = cubicLattice(plan.lattice, settings.load);
  return plan;
}

Image imageBetween(const FrameTask& task) {
  const ImagePlan& plan = task.plan.images;
  const Pullback pullback = task.plan.method.pullback(task.job.weights);
  if (plan.labels.empty()) {
    std::vector<const Image*> images;
    std::vector<double> isos;
    for (const LoadedObject& input : task.inputs)
      images.push_back(input.image.get()), isos.push_back(input.iso);
    return asInputs(pullback.carry(images, plan.lattice, isos), task);
  }
  // At the weights of one input alone that input's labels are taken as they are.
  if (const std::optional<size_t> alone = aloneIn(task.job.weights))
    return asInputs(nearestTo(*task.inputs[*alone].image, plan.lattice), task);
  std::vector<const LabelField*> fields;
  for (const LabelField& field : plan.labels) fields.push_back(&field);
  return asInputs(pullback.carryLabels(fields, plan.lattice), task);
}

}  // namespace slicemorph
