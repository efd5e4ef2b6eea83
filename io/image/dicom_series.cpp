#include "io/image/dicom_volumes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace slicemorph {
namespace {

constexpr double kSameAxes = 1e-4;  // of unit directions and of millimetres: noise in the last digits

bool isNear(double a, double b) { return std::abs(a - b) <= kSameAxes; }

bool sharePixels(const DicomFrame& a, const DicomFrame& b) {
  if (a.position.has_value() != b.position.has_value() || a.axes.has_value() != b.axes.has_value() ||
      a.pixel.has_value() != b.pixel.has_value())
    return false;
  return !a.pixel || (isNear((*a.pixel)[0], (*b.pixel)[0]) && isNear((*a.pixel)[1], (*b.pixel)[1]));
}

/// Whether directions are the same; what has none is told apart by sharePixels() where that matters.
bool shareAxes(const DicomFrame& a, const DicomFrame& b) {
  if (!a.axes || !b.axes) return true;
  for (size_t d = 0; d < 2; ++d)
    for (int c = 0; c < 3; ++c)
      if (!isNear((*a.axes)[d][c], (*b.axes)[d][c])) return false;
  return true;
}

/// Degrees between the directions of two frames, the larger of those of rows and columns; 0 where one has none.
double turnOf(const DicomFrame& a, const DicomFrame& b) {
  if (!a.axes || !b.axes) return 0;
  double most = 0;
  for (size_t d = 0; d < 2; ++d) {
    const Vec3d x = (*a.axes)[d].unit(), y = (*b.axes)[d].unit();
    most = std::max(most, std::atan2(x.cross(y).length(), x.dot(y)) * 180 / M_PI);
  }
  return most;
}

/// Whether frames of two files may be one stack, but for their directions.
bool mayJoin(const DicomFile& a, const DicomFile& b) {
  const auto isAlone = [](const DicomFile& f) {
    return f.kind == DicomFile::kSegmentation || (f.isWhole && !f.uncertain.empty());
  };
  if (a.seriesUid != b.seriesUid || a.frameOfReference != b.frameOfReference || a.columns != b.columns ||
      a.rows != b.rows)
    return false;
  return a.path == b.path || !(isAlone(a) || isAlone(b));
}

bool belongsTo(const DicomSeries& series, const DicomFile& file, const DicomFrame& frame, bool force) {
  const DicomFile& first = series.files[0];
  if (!mayJoin(first, file)) return false;
  if (file.kind == DicomFile::kSegmentation || (file.isWhole && !file.uncertain.empty())) return true;
  return sharePixels(first.frames[0], frame) &&
         (shareAxes(first.frames[0], frame) || (force && turnOf(first.frames[0], frame) <= kMostTurned));
}

/// Makes the frames of reference of a series one where every file has its own: anonymised archives replace each.
void joinFrames(std::vector<DicomFile>& files) {
  std::map<std::string, std::vector<DicomFile*>> series;
  for (DicomFile& file : files) series[file.seriesUid].push_back(&file);
  for (auto& [uid, members] : series) {
    std::set<std::string> frames;
    for (const DicomFile* file : members) frames.insert(file->frameOfReference);
    if (members.size() < 2 || frames.size() < members.size()) continue;
    for (DicomFile* file : members) {
      file->frameOfReference.clear();
      file->assumed +=
          (file->assumed.empty() ? "" : "; ") +
          std::string("every file of it names a frame of reference of its own: they are taken as one");
    }
  }
}

}  // namespace

bool differInTurn(const DicomSeries& a, const DicomSeries& b) {
  const DicomFrame &first = a.files[0].frames[0], &other = b.files[0].frames[0];
  return !a.isSegmentation() && mayJoin(a.files[0], b.files[0]) && sharePixels(first, other) && first.axes &&
         turnOf(first, other) <= kMostTurned;
}

std::vector<DicomSeries> seriesOfFiles(std::vector<DicomFile> files, bool force) {
  joinFrames(files);
  std::vector<DicomSeries> all;
  for (DicomFile& file : files) {
    std::vector<DicomFrame> frames = std::move(file.frames);
    file.frames.clear();
    for (DicomFrame& frame : frames) {
      auto home = std::find_if(all.begin(), all.end(),
                               [&](const DicomSeries& s) { return belongsTo(s, file, frame, force); });
      if (home == all.end()) {
        DicomSeries series;
        series.uid = file.seriesUid, series.modality = file.modality, series.description = file.description;
        series.localizer = true;
        home = all.insert(all.end(), std::move(series));
      }
      if (home->files.empty() || home->files.back().path != file.path) {
        home->files.push_back(file);
        home->localizer = home->localizer && file.localizer;
      }
      const DicomFrame& first = home->files[0].frames.empty() ? frame : home->files[0].frames[0];
      if (!shareAxes(first, frame)) home->turned = std::max(home->turned, turnOf(first, frame));
      home->files.back().frames.push_back(std::move(frame));
    }
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const DicomSeries& a, const DicomSeries& b) { return a.uid < b.uid; });
  for (DicomSeries& series : all) series.volumes = splitIntoVolumes(series);
  return all;
}

}  // namespace slicemorph
