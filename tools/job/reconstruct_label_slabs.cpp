#include "tools/job/reconstruct_label_slabs.h"

#include "engine/reconstruct/fill_gaps.h"
#include "engine/reconstruct/grey_slices.h"
#include "engine/volume/image_shape.h"
#include "io/image/label_values.h"
#include "slicemorph/io/image_slices.h"
#include "slicemorph/io/image_writer.h"
#include "tools/job/given_slices.h"

#include <map>
#include <memory>
#include <optional>
#include <utility>

namespace slicemorph {
namespace {

/// What must be known of all slices before gaps are filled.
struct LabelSurvey {
  ImageLattice lattice;  ///< of the dense map
  GivenSlices given;     ///< of the dense map
  std::vector<double> ranked;
  Notes notes;       ///< about them
  ImageValues like;  ///< none, of the type of the values
};

ImageValues valuesLike(const ImageValues& like, size_t count) {
  return std::visit([&](const auto& values) { return ImageValues(std::decay_t<decltype(values)>(count)); },
                    like);
}

/// Bytes that the whole map takes: the file's, the dense one where it is another, and the planes around the gaps that
/// are filled at once.
double neededInMemory(const ReconstructJob& job, const ImageSlices& slices) {
  constexpr double kPlanes = 12,
                   kPerPixel = 32;  // measured: three to six labels overlap at a pixel, of 4 bytes each
  const ImageLattice& lattice = slices.file.image.lattice;
  const double pixels = double(lattice.size[0]) * lattice.size[1];
  const double bytes = double(slices.bytes);
  const double copies = job.between > 0 ? job.between + 2 : 1;
  return pixels * (bytes * lattice.size[2] * copies + kPlanes * kPerPixel);
}

/// The slices with labels that are stored as floating point rounded, each of which `notes` tells.
ImageSlices roundedSlices(ImageSlices slices, const std::shared_ptr<Notes>& notes) {
  slices.next = [lattice = slices.file.image.lattice, next = std::move(slices.next), notes] {
    Image slice{lattice, next()};
    takeLabels(slice, /*asked=*/true, *notes);
    return std::move(slice.values);
  };
  return slices;
}

LabelSurvey surveyed(const ReconstructJob& job, ImageSlices slices, JobEvents& events) {
  const ImageLattice& lattice = slices.file.image.lattice;
  const SliceLayout layout = layoutOf(lattice, 2);
  LabelledSlices labelled(lattice.size);
  std::vector<LabelCount> counts;
  DrawnSlices drawn;
  ValuesSeen seen;
  LabelSurvey survey;
  for (int k = 0; k < lattice.size[2]; ++k) {
    events.throwIfCancelled();
    const Image slice{lattice, slices.next()};
    if (job.between > 0) labelsOf(slice);
    seen.add(slice.values, {lattice.size[0], lattice.size[1], 1});
    labelled.add(slice.values);
    counts.push_back(countLabels({slice.values, layout, 0}));
    if (areFound(job) && labelled.along(2)[size_t(k)]) drawn.add({slice.values, layout, 0}, k);
  }
  if (job.imageKind == ImageKind::kAuto && !seen.looksDrawn())
    throw MemoryError(
        job.input +
        ": its values look grey, and grey images are only filled in with the whole in memory; allow "
        "more --memory, or say --image labels");
  survey.like = slices.file.image.values;
  survey.given = givenSlices(job, labelled, lattice);
  if (survey.given.axis != 2)
    throw MemoryError(job.input + ": its slices follow each other along axis " +
                      std::string(1, "ijk"[survey.given.axis]) +
                      ", and only such along k are filled in without the whole map in memory; allow more "
                      "--memory, or turn the map's axes");
  if (areFound(job)) survey.given = whatWasDrawn(std::move(survey.given), labelled, drawn);
  if (!survey.given.own.empty())
    throw MemoryError(
        job.input + ": label " + std::to_string(survey.given.own[0].label) +
        " was drawn on slices of its own, and such are only filled in with the whole map in memory; "
        "allow more --memory, or say with --given that all labels are on the same slices");
  survey.notes = job.between > 0
                     ? Notes{{"reconstruct.given-slices", Severity::kNote, "", described(survey.given)}}
                     : notesOf(survey.given, labelled.along(2));
  survey.lattice = expandedLattice(lattice, 2, job.between);
  std::vector<LabelCount> ofGiven;
  for (const int at : survey.given.at) ofGiven.push_back(std::move(counts[size_t(at / (job.between + 1))]));
  survey.ranked = rankLabels(ofGiven);
  return survey;
}

void writeDense(const ReconstructJob& job, ImageSlices slices, const LabelSurvey& survey, JobEvents& events) {
  const std::vector<int>& given = survey.given.at;
  const SliceLayout layout = layoutOf(survey.lattice, 2);
  ImageSliceWriter writer(job.output, survey.lattice, survey.like, 1, slices.file.header);
  std::map<size_t, ImageValues> waiting;  // given slices by their number, until they are written
  int read = 0;                           // slices of the file
  const auto readGiven = [&](size_t count) {
    for (size_t n = waiting.empty() ? 0 : waiting.rbegin()->first + 1; n < count;) {
      ImageValues slice = slices.next();
      const int at = (job.between + 1) * read++;
      if (at == given[n])
        waiting.emplace(n++, std::move(slice));
      else if (n == 0)
        writer.add(slice);
    }
  };
  GapFiller filler(survey.lattice, survey.given, survey.ranked);
  while (!filler.done()) {
    events.throwIfCancelled();
    const GapRange gaps = filler.next();
    readGiven(filler.slicesNeeded());
    std::vector<ImageValues> filled(gaps.end - gaps.first);
    filler.fill(
        [&](size_t n) {
          return LabelSlice{waiting.at(n), layout, 0};
        },
        [&](const FilledGap& gap) {
          ImageValues& to = filled[gap.gap - gaps.first];
          to = valuesLike(survey.like, size_t(gap.slices) * layout.slice);
          paintGap(gap, survey.ranked, layout, 0, to);
        });
    for (size_t g = gaps.first; g < gaps.end; ++g) {
      writer.add(waiting.at(g)), writer.add(filled[g - gaps.first]);
      waiting.erase(g);
    }
  }
  writer.add(waiting.at(given.size() - 1));
  for (int at = given.back() + 1; at < survey.lattice.size[2]; ++at) writer.add(slices.next());
  writer.commit();
}

}  // namespace

bool reconstructLabelSlabs(const ReconstructJob& job, JobEvents& events) {
  if (!isImageOutput(job.output) || !job.like.empty() || !job.reports.empty()) return false;
  std::optional<ImageSlices> slices = openImageSlices(job.input, job.image);
  if (!slices || neededInMemory(job, *slices) <= job.memory.left()) return false;
  Notes notes = slices->file.notes;
  const auto rounded = std::make_shared<Notes>();
  const LabelSurvey survey = surveyed(job, roundedSlices(std::move(*slices), rounded), events);
  if (!rounded->empty())
    notes.emplace_back("image.labels-rounded", Severity::kNote, "",
                       "its labels are whole numbers but for 0.001 at most: rounded");
  notes.insert(notes.end(), survey.notes.begin(), survey.notes.end());
  notes.emplace_back("reconstruct.slice-by-slice", Severity::kNote, "",
                     "the whole map would not fit the memory: filled in slice by slice");
  events.notes(about(job.input, notes));
  writeDense(job, roundedSlices(std::move(*openImageSlices(job.input, job.image)), rounded), survey, events);
  events.fileWritten(job.output, false);
  return true;
}

}  // namespace slicemorph
