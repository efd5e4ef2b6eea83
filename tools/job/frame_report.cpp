#include "tools/job/frame_report.h"

#include "tools/job/describe_job.h"
#include "tools/job/option_values.h"
#include "tools/job/pick_job.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slicemorph {
namespace {

using Json = nlohmann::ordered_json;

/// Measures of inputs that are cached: enough for the inputs of a frame, so that inputs that do not change
/// are measured once; a bound where they do.
constexpr size_t kMostKeptMeasures = 8;

/// Name of the job file that the page of a report makes.
constexpr const char* kPickedJob = "pairs.toml";

GridFigures figuresOf(const openvdb::GridBase& grid) {
  GridFigures figures{grid.getName(), grid.activeVoxelCount(), {}, {}};
  grid.apply<openvdb::TypeList<FloatGrid, openvdb::DoubleGrid>>([&](const auto& scalars) {
    double total = 0, peak = -std::numeric_limits<double>::infinity();
    for (auto value = scalars.cbeginValueOn(); value; ++value) {
      total += double(*value) * double(value.getVoxelCount());
      peak = std::max(peak, double(*value));
    }
    figures.total = total * std::abs(grid.transform().voxelVolume());
    if (std::isfinite(peak)) figures.peak = peak;
  });
  return figures;
}

std::vector<LabelMeasures> labelsOf(const FrameTask& task, const MorphFrame& frame) {
  if (task.plan.content.labelFigures) return frame.labels;
  if (!frame.image) return {};
  return {measureAbove(*frame.image, isoOf(task))};
}

bool asksForPage(const MorphSettings& settings) {
  return std::any_of(settings.reports.begin(), settings.reports.end(),
                     [](const std::string& path) { return OutputName(path).extension() == ".html"; });
}

PageJob pageJobOf(const MorphSettings& settings) {
  return {settings.inputs, asksForPage(settings) ? settings.wantedFrames().size() : 0, settings.glb};
}

}  // namespace

FrameReport::FrameReport(const MorphSettings& settings) : settings_(settings), page_(pageJobOf(settings)) {}

bool FrameReport::hasPage() const { return asksForPage(settings_); }

FrameFigures FrameReport::measure(const FrameTask& task, const MorphFrame& frame) {
  FrameFigures figures;
  figures.number = task.job.number, figures.t = task.job.t;
  figures.weights = task.job.weights, figures.file = task.job.path;
  if (!wanted()) return figures;
  for (const openvdb::GridBase::ConstPtr& grid : frame.grids) figures.grids.push_back(figuresOf(*grid));
  figures.labels = labelsOf(task, frame);
  figures.voxelSize = frame.grids.empty() ? 0 : frame.grids[0]->voxelSize()[0];
  const FloatGrid::ConstPtr surface = frame.shape.surface;
  if (!surface) return figures;
  figures.voxelSize = surface->voxelSize()[0];
  figures.foldShare = frame.shape.foldShare;
  figures.shape = measureShape(*surface);
  if (const MorphPlan* plan = task.plan.method.slices.get()) figures.strain = plan->strain(task.job.weights);
  if (previous_ && previousNumber_ + 1 == task.job.number)
    figures.symmetricDifference = overlap(*previous_, *surface).symmetricDifference;
  previous_ = surface, previousNumber_ = task.job.number;
  return figures;
}

void FrameReport::compareWith(const FrameTask& task) {
  if (!wanted()) return;
  previous_ = task.plan.method.shape(task.job).surface, previousNumber_ = task.job.number;
}

Json FrameReport::addRow(const FrameFigures& figures, const std::vector<LoadedObject>& inputs) {
  if (!wanted()) return Json();
  std::vector<ShapeMeasures> measures;
  measures.reserve(inputs.size());
  for (const LoadedObject& input : inputs)
    measures.push_back(input.nothing ? ShapeMeasures() : measuresOf(input.object.levelSet));
  rows_.push_back(describeFrame(figures, measures));
  return rows_.back();
}

void FrameReport::addKept(const FrameTask& task, const Json& row) {
  if (page_.has(rows_.size())) addToPage(task, coloredShape(task));
  if (wanted()) rows_.push_back(row);
}

void FrameReport::addToPage(const FrameTask& task, const MorphFrame& frame) {
  const size_t index = rows_.size();
  if (!page_.has(index)) return;
  const FrameJob& job = task.job;
  page_.add({index, job.weights, job.t ? "t=" + formatNumber(*job.t, 2) : std::to_string(job.number),
             frame.shape.surface, frame.colors});
}

void FrameReport::write(const FrameMaker& maker, const Notes& notes, Progress& progress) const {
  if (!wanted()) return;
  ReportParts report;
  report.settings = describeJob(settings_);
  if (maker.options().align == Align::kDirections) report.settings["align"] = "directions";
  report.settings["start"] = settings_.frames.front().number;
  if (!settings_.options.range.empty()) report.settings["range"] = settings_.options.range;
  report.inputNames = settings_.inputs;
  report.frames = rows_;
  for (const LoadedObject& input : maker.inputs())
    report.inputs.push_back(measureShape(*input.object.levelSet)), report.placings.push_back(input.placing);
  report.notes = notes;
  if (hasPage()) {
    report.page = page_.finish(maker.commonPlan(), progress);
    if (maker.commonPlan())
      report.page.pick = pickPartOf(settings_, maker.inputs(), maker.commonPlan(), kPickedJob, {}, progress);
  }
  report.loadSeconds = maker.seconds().load, report.planSeconds = maker.seconds().plan;
  report.restDistance = maker.plan().restDistance;
  if (const MorphPlan* plan = maker.plan().slices.get()) {
    report.overlap = plan->overlap(), report.turns = plan->turnChoices();
    if (!settings_.landmarks.empty()) report.landmarks = landmarkErrors(settings_.landmarks, *plan);
    if (!settings_.checkLandmarks.empty())
      report.checkLandmarks = landmarkErrors(settings_.checkLandmarks, *plan);
  }
  writeReports(settings_.reports, report);
}

ShapeMeasures FrameReport::measuresOf(const FloatGrid::ConstPtr& levelSet) {
  if (measures_.size() > kMostKeptMeasures) measures_.clear();
  const auto [at, fresh] = measures_.try_emplace(levelSet);
  if (fresh) at->second = measureShape(*levelSet);
  return at->second;
}

}  // namespace slicemorph
