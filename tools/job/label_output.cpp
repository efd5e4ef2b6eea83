#include "tools/job/label_output.h"

#include "engine/measure/label_measures.h"
#include "engine/volume/image_shape.h"
#include "engine/volume/resample_image.h"
#include "slicemorph/io/image_writer.h"
#include "slicemorph/io/output.h"
#include "tools/job/image_lattice.h"
#include "tools/job/write_structures.h"
#include "tools/report/structure_report.h"

#include <memory>
#include <utility>

namespace slicemorph {
namespace {

/// 1 where a map has a label, else 0.
Image maskOf(const Image& labels, std::int64_t label) {
  Image mask{labels.lattice, {}};
  std::visit(
      [&](const auto& values) {
        std::vector<std::uint8_t> on(values.size());
        for (size_t n = 0; n < values.size(); ++n) on[n] = std::int64_t(values[n]) == label;
        mask.values = std::move(on);
      },
      labels.values);
  return mask;
}

}  // namespace

void writeLabelImage(const ReconstructJob& job, Image dense, ImageHeader header, const Notes& notes,
                     JobEvents& events) {
  const OutputName name(job.output);
  const bool structures = isStructureOutput(job.output);
  if (!job.like.empty()) {
    const ImageVoxels like = voxelsLike(job.like, job.image);
    dense = nearestTo(dense, like.lattice), header.forms = like.forms;
  }
  if (job.takeImage) return job.takeImage(std::move(dense));
  const auto labels = std::make_shared<const Image>(std::move(dense));
  if (structures) {
    events.notes(writeLabelStructures(
        {job.input, job.output, job.source, job.like, job.names, job.image, header.labels}, labels));
    events.fileWritten(job.output, false);
  } else if (name.isSequence()) {
    for (const std::int64_t label : labelsOf(*labels)) {
      const std::string path = name.path(int(label));
      writeImage(path, maskOf(*labels, label), header);
      events.fileWritten(path, false);
    }
  } else {
    writeImage(job.output, *labels, header);
    events.fileWritten(job.output, false);
  }
  if (job.reports.empty()) return;
  std::vector<StructureRow> rows;
  for (const LabelMeasures& m : measureLabels(*labels))
    rows.push_back(rowOf(m, name.isSequence() ? name.path(int(m.label)) : job.output));
  writeStructureReports(job.reports, job.input, rows, notes);
}

}  // namespace slicemorph
