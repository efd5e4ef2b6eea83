#include "tools/python/plan.h"

#include "slicemorph/errors.h"
#include "tools/job/job_file.h"
#include "tools/job/limit_threads.h"
#include "tools/job/morph_session.h"
#include "tools/job/option_values.h"
#include "tools/job/plan_file.h"
#include "tools/python/grid.h"
#include "tools/python/input.h"

#include <pybind11/stl.h>

#include <cmath>
#include <mutex>

namespace slicemorph {
namespace {

/// A plan as Python has it, shared with its frames.
struct PyPlan {
  OptionSet options;
  Notes notes;
  std::unique_ptr<MorphSession> session;
  std::mutex mutex;  ///< of the session, which serves one call at a time

  explicit PyPlan(OptionSet given) : options(std::move(given)) {}

  /// Runs an action on the session in a long call.
  template <typename Action>
  auto run(const py::object& progress, CallEvents& events, Action action) {
    return runCall(events, progress, [&] {
      const std::lock_guard<std::mutex> lock(mutex);
      const auto limit = limitThreads(options.values().threads);
      return action();
    });
  }
  template <typename Action>
  auto run(Action action) {
    CallEvents events;
    return run(py::none(), events, [&] { return action(events); });
  }
};
using PlanPtr = std::shared_ptr<PyPlan>;

struct PyFrame {
  PlanPtr plan;
  FrameJob job;
  MorphFrame frame;
  Notes notes;
  /// The frame with its shape, once that is asked for where the output needs none.
  mutable std::optional<MorphFrame> withShape = {};
};

PlanPtr makePlan(const std::vector<PyInput>& inputs, const GivenOptions& given, const py::object& progress) {
  auto plan = std::make_shared<PyPlan>(optionsOf(kMorph, "inputs", inputs, given));
  CallEvents events;
  Notes ofFile;
  plan->run(progress, events, [&] {
    ofFile = applyPlanFile(plan->options);
    if (!plan->options.values().config.empty()) applyJobFile(JobFile(plan->options.values()), plan->options);
    plan->session = std::make_unique<MorphSession>(plan->options, events);
  });
  plan->notes = std::move(ofFile);
  plan->notes.insert(plan->notes.end(), events.kept().begin(), events.kept().end());
  return plan;
}

PyFrame makeFrameOf(const PlanPtr& plan, FrameJob job, const py::object& progress) {
  PyFrame made{plan, std::move(job), {}, {}};
  CallEvents events;
  plan->run(progress, events, [&] { made.frame = plan->session->make(made.job, events); });
  made.notes = events.kept();
  return made;
}

/// Weights of a time, or checked weights.
Weights weightsOf(const MorphSession& session, const py::object& when) {
  if (py::isinstance<py::float_>(when) || py::isinstance<py::int_>(when))
    return session.weightsOf(when.cast<double>());
  return session.blendOf(when.cast<Weights>()).weights;
}

std::vector<openvdb::GridBase::ConstPtr> gridsOf(const MorphSession& session,
                                                 const std::vector<std::optional<PyGrid>>& given) {
  const size_t inputs = session.settings().inputs.size();
  if (given.size() != inputs)
    throw InputError("grids", "expected one for each of " + std::to_string(inputs) +
                                  " inputs, None where it has none, not " + std::to_string(given.size()));
  std::vector<openvdb::GridBase::ConstPtr> grids;
  for (const auto& grid : given) grids.push_back(grid ? grid->grid : nullptr);
  return grids;
}

PyGrid carry(const PlanPtr& plan, const std::vector<std::optional<PyGrid>>& given, const py::object& when,
             double voxelSize, bool conserve) {
  MorphSession& session = *plan->session;
  const Weights weights = weightsOf(session, when);
  const auto grids = gridsOf(session, given);
  if (session.settings().moving())
    throw InputError("of inputs that are sequences each frame has a map of its own; plan still ones");
  if (!session.method().pullback)
    throw InputError("--method " + session.settings().method + " carries no grids");
  return plan->run([&](CallEvents&) {
    Pullback pullback = session.method().pullback(weights);
    return PyGrid{pullback.carry(grids, {conserve, voxelSize})};
  });
}

py::array apply(const PlanPtr& plan, const Rows<double>& points, const py::object& from,
                const py::object& to) {
  MorphSession& session = *plan->session;
  const std::vector<Vec3d> given = vectorsOf<Vec3d>(points, "points");
  const Weights at = weightsOf(session, from), then = weightsOf(session, to);
  return rowsOf(plan->run([&](CallEvents&) { return session.plan().carryPoints(given, at, then); }));
}

void savePlan(const PlanPtr& plan, const std::string& path) {
  for (const auto& held : plan->options.values().held)
    if (held)
      throw InputError(path, "a plan on disk names its inputs' files, and '" + held->spec.text +
                                 "' is in memory; give the paths of files to plan()");
  if (plan->options.values().configText)
    throw InputError(path,
                     "a plan on disk names its job file; write features and regions into one, for config=");
  if (plan->session->settings().moving())
    throw InputError(path, "plans of sequences are written by `slicemorph plan`");
  plan->run([&](CallEvents&) {
    PlanFile file = planFileOf(plan->options);
    file.decisions = plan->session->plan().decisions();
    writePlanFile(path, file);
  });
}

/// The grid of the morph's velocities.
std::optional<PyGrid> velocityOf(const PyFrame& frame) {
  const std::string& name = frame.plan->session->settings().velocity.name;
  for (const std::string& known : {name + "_morph", name})
    for (const auto& grid : frame.frame.grids)
      if (grid->getName() == known) return PyGrid{grid};
  return std::nullopt;
}

/// The shape: made with the frame, or, where its output needs none, now.
const MorphFrame& shapeOf(const PyFrame& frame) {
  if (frame.frame.shape.surface) return frame.frame;
  if (!frame.withShape) {
    MorphFrame made =
        frame.plan->run([&](CallEvents& events) { return frame.plan->session->shapeOf(frame.job, events); });
    // Another thread may have been faster, and its shape is in use.
    if (!frame.withShape) frame.withShape = std::move(made);
  }
  return *frame.withShape;
}

py::tuple meshOfFrame(const PyFrame& frame) {
  const MorphFrame& shape = shapeOf(frame);
  return meshOf(*shape.shape.surface, shape.colors.get());
}

std::vector<PyGrid> gridsOfFrame(const PyFrame& frame) {
  std::vector<PyGrid> grids;
  for (const auto& grid : frame.frame.grids) grids.push_back({grid});
  return grids;
}

std::optional<PyInput> imageOfFrame(const PyFrame& frame) {
  if (!frame.frame.image) return std::nullopt;
  return inputOf("frame", *frame.frame.image, frame.plan->session->makesLabels());
}

void saveFrame(const PyFrame& frame, const std::string& path) {
  checkOutputPath(path);
  frame.plan->run(
      [&](CallEvents& events) { frame.plan->session->save(path, frame.job, frame.frame, events); });
}

void addFrame(py::module_& module) {
  py::class_<PyFrame>(module, "Frame")
      .def_property_readonly("number", [](const PyFrame& f) { return f.job.number; })
      .def_property_readonly("t", [](const PyFrame& f) { return f.job.t; })
      .def_property_readonly("weights", [](const PyFrame& f) { return f.job.weights; })
      .def_property_readonly("notes", [](const PyFrame& f) { return f.notes; })
      .def_property_readonly("fold_share", [](const PyFrame& f) { return shapeOf(f).shape.foldShare; })
      .def("_grids", gridsOfFrame)
      .def("_image", imageOfFrame)
      .def("_shape", [](const PyFrame& f) { return PyGrid{shapeOf(f).shape.surface}; })
      .def("_mesh", meshOfFrame)
      .def("_velocity", velocityOf)
      .def("_save", saveFrame);
}

}  // namespace

void addPlan(py::module_& module) {
  addFrame(module);
  py::class_<FrameJob>(module, "FrameJob");
  py::class_<PyPlan, PlanPtr>(module, "Plan")
      .def(py::init(&makePlan))
      .def("_frame", &makeFrameOf)
      .def("_at", [](const PlanPtr& p, double t) { return p->session->frameAt(t); })
      .def("_blend", [](const PlanPtr& p, const Weights& weights) { return p->session->blendOf(weights); })
      .def("_jobs", [](const PlanPtr& p, std::optional<int> count) { return p->session->frames(count); })
      .def("_carry", carry)
      .def("_apply", apply)
      .def("_save", savePlan)
      .def(
          "weights_at", [](const PlanPtr& p, double t) { return p->session->weightsOf(t); }, py::arg("t"))
      .def_property_readonly("notes", [](const PlanPtr& p) { return p->notes; })
      .def_property_readonly("inputs", [](const PlanPtr& p) { return p->session->settings().inputs; })
      .def_property_readonly("overlap", [](const PlanPtr& p) { return p->session->plan().overlap(); })
      .def_property_readonly("turns", [](const PlanPtr& p) {
        py::list turns;
        for (const TurnChoice& turn : p->session->plan().turnChoices())
          turns.append(py::make_tuple(turn.degrees, turn.margin));
        return turns;
      });
}

}  // namespace slicemorph
