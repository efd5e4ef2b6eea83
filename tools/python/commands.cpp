#include "tools/python/commands.h"

#include "engine/sections/section.h"
#include "slicemorph/errors.h"
#include "tools/job/compare_shapes.h"
#include "tools/job/cut_slices.h"
#include "tools/job/job_file.h"
#include "tools/job/limit_threads.h"
#include "tools/job/load_settings.h"
#include "tools/job/morph_checks.h"
#include "tools/job/morph_job.h"
#include "tools/job/option_table.h"
#include "tools/job/option_values.h"
#include "tools/job/plan_file.h"
#include "tools/job/reconstruct.h"
#include "tools/job/render_pictures.h"
#include "tools/job/run_morph.h"
#include "tools/job/write_structures.h"
#include "tools/python/grid.h"
#include "tools/python/input.h"

#include <pybind11/stl.h>

#include <algorithm>
#include <map>

namespace slicemorph {
namespace {

const std::map<std::string, Command>& commandNames() {
  static const std::map<std::string, Command> names = {{"morph", kMorph},     {"convert", kConvert},
                                                       {"compare", kCompare}, {"reconstruct", kReconstruct},
                                                       {"render", kRender},   {"slice", kSlice}};
  return names;
}

const char* nameOf(OptionType type) {
  switch (type) {
    case OptionType::kFlag:
      return "flag";
    case OptionType::kInteger:
      return "integer";
    case OptionType::kNumber:
      return "number";
    case OptionType::kText:
      return "text";
    case OptionType::kTexts:
      return "texts";
    case OptionType::kNumbers:
      return "numbers";
    case OptionType::kLandmarks:
      return "landmarks";
    case OptionType::kTables:
      return "tables";
  }
  return "text";
}

/// The table's rows of a command, but for its inputs.
py::list optionRows(const std::string& command) {
  const auto found = commandNames().find(command);
  if (found == commandNames().end()) throw InputError("command", "there is none named '" + command + "'");
  py::list rows;
  for (const OptionRow& row : optionTable()) {
    if (!row.isOf(found->second) || !row.positional.empty()) continue;
    const bool typed = row.field;  // not so tables that only job files have
    rows.append(py::dict(
        py::arg("name") = row.name, py::arg("type") = nameOf(row.type),
        py::arg("form") = typed ? formOf(row) : "",
        py::arg("choices") = row.braces ? std::vector<std::string>() : row.choices,
        py::arg("help") = typed ? helpOf(row) : "Tables [[" + row.name + "]] of job files, a dict each",
        py::arg("group") = titleOf(row.group)));
  }
  return rows;
}

struct Outcome {
  std::vector<std::string> files;
  Notes notes;
};

Outcome outcomeOf(const CallEvents& events) { return {events.files(), events.kept()}; }

Outcome morph(const std::vector<PyInput>& inputs, const GivenOptions& given, const py::object& progress) {
  OptionSet options = optionsOf(kMorph, "inputs", inputs, given);
  CallEvents events;
  const bool held =
      std::any_of(inputs.begin(), inputs.end(), [](const PyInput& input) { return bool(input.held); });
  if (held && options.values().resume)
    throw InputError("resume",
                     "inputs in memory cannot be told from those of an earlier run; give paths of files");
  runCall(events, progress, [&] {
    events.notes(applyPlanFile(options));
    if (!options.values().config.empty()) applyJobFile(JobFile(options.values()), options);
    const MorphJob job = morphJob(options);
    events.notes(job.notes);
    checkMorphFiles(job.settings, options);
    const auto limit = limitThreads(options.values().threads);
    runMorph(job.settings, events);
  });
  return outcomeOf(events);
}

py::tuple compare(const PyInput& a, const PyInput& b, const GivenOptions& given, const py::object& progress) {
  OptionSet options = optionsOf(kCompare, "a", {a}, given);
  options.set(options.row("b"), {b.name});
  options.checkExclusions();
  CompareJob job;
  job.inputs[0] = a.name, job.inputs[1] = b.name, job.held = {a.held, b.held};
  job.load = loadSettings(options);
  CallEvents events;
  const Comparison result = runCall(events, progress, [&] {
    const auto limit = limitThreads(options.values().threads);
    return compareShapes(job, events);
  });
  const std::string json =
      jsonOf(result).dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  return py::make_tuple(py::module_::import("json").attr("loads")(json), outcomeOf(events));
}

/// Pictures as arrays of rows, columns, and red, green, blue, alpha.
py::tuple render(const std::vector<PyInput>& inputs, const GivenOptions& given, const py::object& progress) {
  const OptionSet options = optionsOf(kRender, "inputs", inputs, given);
  if (inputs.empty()) throw InputError("render", "needs an input");
  RenderJob job = renderJob(options);
  checkRenderOutputs(job);
  std::vector<std::shared_ptr<Picture>> pictures;
  job.take = [&](const Picture& picture, int) { pictures.push_back(std::make_shared<Picture>(picture)); };
  CallEvents events;
  runCall(events, progress, [&] {
    const auto limit = limitThreads(options.values().threads);
    renderPictures(job, events);
  });
  py::list arrays;
  for (const auto& picture : pictures) {
    const py::ssize_t one = sizeof(float), row = one * 4 * picture->width;
    arrays.append(
        arrayOf(picture, picture->rgba.data(), {picture->height, picture->width, 4}, {row, 4 * one, one}));
  }
  return py::make_tuple(arrays, outcomeOf(events));
}

py::dict planeOf(const SectionPlane& plane) {
  const auto vector = [](const Vec3d& v) { return py::make_tuple(v[0], v[1], v[2]); };
  return py::dict(py::arg("origin") = vector(plane.origin), py::arg("x_axis") = vector(plane.xAxis),
                  py::arg("y_axis") = vector(plane.yAxis), py::arg("normal") = vector(plane.normal),
                  py::arg("pixel_size") = plane.pixelSize);
}

py::tuple slice(const PyInput& input, const GivenOptions& given, const py::object& progress) {
  const OptionSet options = optionsOf(kSlice, "input", {input}, given);
  const CutJob job = cutJob(options);
  CallEvents events;
  if (!job.output.empty()) {
    checkExtension(job.output, {".exr"});
    checkOutputPath(OutputName(job.output).path(1));
    runCall(events, progress, [&] {
      const auto limit = limitThreads(options.values().threads);
      cutSlices(job, events);
    });
    return py::make_tuple(py::none(), outcomeOf(events));
  }
  CutVolume volume;
  std::vector<std::vector<SectionValues>> sampled;
  runCall(events, progress, [&] {
    const auto limit = limitThreads(options.values().threads);
    volume = volumeToCut(job, events);
    for (const SliceGrid& grid : volume.input.grids) {
      events.throwIfCancelled();
      sampled.push_back(sampleSections(*grid.grid, volume.planes));
    }
  });
  py::list slices;
  for (size_t n = 0; n < volume.planes.size(); ++n) {
    const SectionPlane& plane = volume.planes[n];
    py::dict values;
    for (size_t g = 0; g < sampled.size(); ++g) {
      const auto owner = std::make_shared<SectionValues>(std::move(sampled[g][n]));
      const py::ssize_t one = sizeof(float), row = one * plane.width, component = row * plane.height;
      std::vector<py::ssize_t> shape{plane.height, plane.width}, strides{row, one};
      if (owner->components > 1) shape.push_back(owner->components), strides.push_back(component);
      values[py::str(volume.input.grids[g].name)] = arrayOf(owner, owner->values.data(), shape, strides);
    }
    slices.append(py::make_tuple(values, planeOf(plane)));
  }
  return py::make_tuple(slices, outcomeOf(events));
}

/// What is made: an image, surfaces by their names, or files.
py::tuple reconstructed(const PyInput& input, const GivenOptions& given, bool inMemory,
                        const py::object& progress) {
  const OptionSet options = optionsOf(kReconstruct, "input", {input}, given);
  ReconstructJob job = reconstructJob(options);
  std::optional<Image> image;
  std::vector<std::pair<std::string, Mesh>> surfaces;
  if (inMemory) {
    job.takeImage = [&](Image taken) { image = std::move(taken); };
    job.takeSurface = [&](const std::string& name, const Mesh& mesh) { surfaces.emplace_back(name, mesh); };
  } else {
    checkStudyOutput(job.output, job.source, job.names);
  }
  CallEvents events;
  runCall(events, progress, [&] {
    const auto limit = limitThreads(options.values().threads);
    reconstruct(job, events);
  });
  py::dict meshes;
  for (auto& [name, mesh] : surfaces) meshes[py::str(name)] = arraysOf(std::move(mesh));
  const py::object made =
      image ? py::cast(inputOf(input.name, std::move(*image), false)) : py::object(py::none());
  return py::make_tuple(made, meshes, outcomeOf(events));
}

}  // namespace

void addCommands(py::module_& module) {
  py::class_<Outcome>(module, "Outcome")
      .def_readonly("files", &Outcome::files)
      .def_readonly("notes", &Outcome::notes);
  module.def("_option_rows", optionRows);
  module.def("_morph", morph);
  module.def("_compare", compare);
  module.def("_render", render);
  module.def("_slice", slice);
  module.def("_reconstruct", reconstructed);
}

}  // namespace slicemorph
