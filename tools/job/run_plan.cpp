#include "tools/job/run_plan.h"

#include "slicemorph/errors.h"
#include "tools/job/frame_maker.h"

#include <set>

namespace slicemorph {

void runPlan(const MorphSettings& settings, PlanFile like, const std::string& output, JobEvents& events) {
  const OutputName name(output);
  if (settings.moving() != name.isSequence())
    throw InputError("-o " + output +
                     (settings.moving()
                          ? ": of inputs that are sequences each frame has a plan; put #### where its "
                            "number belongs (name.####.plan)"
                          : ": one plan serves all frames; leave out the ####"));
  FrameMaker maker(settings, events);
  const size_t count = settings.moving() ? settings.frames.size() : 1;
  std::set<size_t> written;  // frames of the inputs, which several frames of the job may show
  for (size_t i = 0; i < count; ++i) {
    maker.moveTo(i, double(i) / double(count), double(i + 1) / double(count));
    events.throwIfCancelled();
    const FrameJob& job = settings.frames[i];
    if (settings.moving() && (!job.wanted || !written.insert(job.inputFrame).second)) continue;
    like.decisions = maker.plan().slices->decisions(), like.frame = job.inputFrame;
    const std::string path =
        settings.moving() ? name.path(settings.options.start + int(job.inputFrame)) : output;
    writePlanFile(path, like);
    events.fileWritten(path, false);
  }
}

}  // namespace slicemorph
