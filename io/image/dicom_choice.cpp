#include "io/image/dicom_reader.h"
#include "io/image/dicom_segmentation.h"
#include "slicemorph/errors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <filesystem>

namespace slicemorph {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMostNamed = 5;  // files that one note names

std::vector<std::string> filesOfFolder(const std::string& folder) {
  std::error_code error;
  std::vector<std::string> files;
  std::error_code ignored;  // links to nowhere are no files
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (entry.is_regular_file(ignored) && entry.path().filename().string()[0] != '.' &&
        entry.path().filename() != "DICOMDIR")
      files.push_back(entry.path().string());
  if (error) throw IoError(folder, "cannot be read: " + error.message());
  std::sort(files.begin(), files.end());
  return files;
}

bool isEmpty(const std::string& path) {
  std::error_code ignored;
  return fs::file_size(path, ignored) == 0;
}

std::vector<DicomFile> readFiles(const std::vector<std::string>& paths) {
  std::vector<DicomFile> files(paths.size());
  tbb::parallel_for(size_t(0), paths.size(), [&](size_t i) {
    files[i].path = paths[i];
    try {
      files[i].isDicom = !isEmpty(paths[i]);
      if (files[i].isDicom) files[i] = readDicomFile(paths[i]);
    } catch (const IoError& error) {
      files[i].unreadable = error.note().text;  // beside a series it is left out
    }
  });
  return files;
}

/// Notes name files within their folder, which the program names before them.
std::string shortName(const std::string& path) { return fs::path(path).filename().string(); }

/// Tells of files that are left out: each by name, of many the first.
void noteLeftOut(Notes& notes, const std::vector<std::pair<std::string, std::string>>& files,
                 const char* code, Severity severity) {
  for (size_t i = 0; i < std::min(files.size(), kMostNamed); ++i)
    notes.emplace_back(code, severity, shortName(files[i].first), files[i].second + ": left out");
  if (files.size() > kMostNamed)
    notes.emplace_back(code, severity, "",
                       "and " + std::to_string(files.size() - kMostNamed) + " more files left out");
}

DicomFolder sorted(const std::string& path, std::vector<DicomFile> files, bool force) {
  DicomFolder found;
  std::vector<std::pair<std::string, std::string>> foreign, others;
  std::vector<DicomFile> images;
  for (DicomFile& file : files) {
    if (!file.unreadable.empty())
      found.damaged.emplace_back(
          "", Note("image.file-unreadable", Severity::kWarning, file.path, file.unreadable));
    else if (!file.isDicom)
      others.emplace_back(file.path, "is no DICOM file");
    else if (!file.damage.empty())
      found.damaged.emplace_back(file.seriesUid, Note("image.file-damaged", Severity::kWarning, file.path,
                                                      "is truncated or damaged: " + file.damage));
    else if (!file.foreign.empty())
      foreign.emplace_back(file.path, file.foreign);
    else if (file.frames.empty())
      foreign.emplace_back(
          file.path, "holds no image (" + (file.modality.empty() ? "no modality" : file.modality) + ")");
    else
      images.push_back(std::move(file));
  }
  if (images.empty()) {
    const Note* damage = found.damaged.empty() ? nullptr : &found.damaged[0].second;
    if (damage) throw IoError(damage->about, damage->text);
    if (!foreign.empty()) throw IoError(foreign[0].first, foreign[0].second);
    throw IoError(path, fs::is_directory(path) ? "no DICOM images in this folder" : "is no DICOM file");
  }
  noteLeftOut(found.notes, foreign, "image.file-passed-over", Severity::kNote);
  noteLeftOut(found.notes, others, "image.file-passed-over", Severity::kNote);
  found.series = seriesOfFiles(std::move(images), force);
  return found;
}

std::string countOf(size_t count, const char* what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

/// The lines that list what may be chosen of one series.
std::string listed(const std::string& path, const std::vector<DicomSeries>& all, size_t i) {
  const DicomSeries& s = all[i];
  const std::string name = path + ":" + std::to_string(i + 1);
  std::string text = "\n  " + name + "  " + s.modality + " '" + s.description + "', ";
  if (s.isSegmentation()) return text + "segments " + segmentsOf(s) + ", UID " + s.uid;
  text += countOf(s.slices(), "slice") + (s.localizer ? " (localizer)" : "") + ", UID " + s.uid;
  if (s.volumes.size() == 1) return text;
  constexpr size_t kMostListed = 20;
  if (s.volumes.size() > kMostListed)
    return text + "\n  " + name + "@1 to " + name + "@" + std::to_string(s.volumes.size()) +
           "  volumes, from '" + s.volumes[0].apart + "' to '" + s.volumes.back().apart +
           "'; info lists them";
  for (size_t v = 0; v < s.volumes.size(); ++v)
    text += "\n  " + name + "@" + std::to_string(v + 1) + "  " +
            countOf(s.volumes[v].slices.size(), "slice") + ", " + s.volumes[v].apart;
  return text;
}

std::string listed(const std::string& path, const std::vector<DicomSeries>& all) {
  std::string text;
  for (size_t i = 0; i < all.size(); ++i) text += listed(path, all, i);
  return text;
}

bool isSameFile(const std::string& a, const std::string& b) {
  return fs::path(a).filename() == fs::path(b).filename();
}

/// The series that a selection means.
std::vector<size_t> matching(const std::vector<DicomSeries>& all, const std::string& wanted) {
  std::vector<size_t> found;
  for (size_t i = 0; i < all.size(); ++i)
    if (wanted == std::to_string(i + 1)) return {i};
  for (size_t i = 0; i < all.size(); ++i)
    if (wanted == all[i].uid) found.push_back(i);
  return found;
}

/// The series that hold a named file, and which volume of each does.
std::vector<std::pair<size_t, size_t>> holding(const std::vector<DicomSeries>& all, const std::string& path) {
  std::vector<std::pair<size_t, size_t>> found;
  for (size_t i = 0; i < all.size(); ++i)
    for (size_t v = 0; v < all[i].volumes.size(); ++v)
      for (const DicomSliceRef& r : all[i].volumes[v].slices)
        if (isSameFile(all[i].files[r.file].path, path) && (found.empty() || found.back() != std::pair(i, v)))
          found.emplace_back(i, v);
  return found;
}

/// What would make one stack of series that differ in a small turn alone; empty: nothing would.
std::string joinedBy(const std::vector<DicomSeries>& all, const std::vector<size_t>& among) {
  for (size_t i = 0; i < among.size(); ++i)
    for (size_t j = 0; j < i; ++j)
      if (differInTurn(all[among[i]], all[among[j]]))
        return ", or --force takes those of one UID whose directions differ by less than " +
               std::to_string(int(kMostTurned)) + " degrees as one";
  return "";
}

/// The one series where none is named: of several the one that is no localizer.
size_t onlySeries(const std::string& path, const DicomFolder& found, Notes& notes) {
  const std::vector<DicomSeries>& all = found.series;
  if (all.size() == 1) return 0;
  std::vector<size_t> scans;
  for (size_t i = 0; i < all.size(); ++i)
    if (!all[i].localizer) scans.push_back(i);
  if (scans.size() != 1)
    throw InputError(path, "holds " + std::to_string(all.size()) + " series; choose one" +
                               joinedBy(all, scans) + ":" + listed(path, all));
  for (size_t i = 0; i < all.size(); ++i)
    if (all[i].localizer)
      notes.emplace_back(
          "image.localizer-left-out", Severity::kNote, shortName(all[i].files[0].path),
          (all[i].slices() == 1 ? "is a localizer: left out (" : "and others are localizers: left out (") +
              path + ":" + std::to_string(i + 1) + " takes it)");
  return scans[0];
}

/// Adds notes on damaged files. Throws IoError where one belongs to a series that was not named.
void checkDamage(const std::string& path, const DicomFolder& found, size_t series, bool named, Notes& notes) {
  for (const auto& [uid, note] : found.damaged) {
    const bool other = !uid.empty() && uid != found.series[series].uid;
    if (other && !fs::is_directory(path)) continue;  // a file was asked for, not its folder
    if (!named && uid == found.series[series].uid)
      throw IoError(note.about, note.text + "; " + path + ":" + std::to_string(series + 1) +
                                    " reads the rest of its series");
    notes.push_back(note);
    notes.back().about = shortName(note.about), notes.back().text += ": left out";
  }
}

size_t volumeOf(const std::string& path, const DicomFolder& found, size_t series, const std::string& wanted) {
  const DicomSeries& s = found.series[series];
  const std::string list = listed(path, found.series, series);
  if (s.isSegmentation()) {
    for (const DicomSegment& segment : s.files[0].segments)
      if (wanted == std::to_string(segment.number) || wanted == segment.name) return size_t(segment.number);
    throw InputError(path, "has no segment '" + wanted + "'; there are" + list);
  }
  for (size_t v = 0; v < s.volumes.size(); ++v)
    if (wanted == std::to_string(v + 1)) return v;
  throw InputError(path, "has no volume '" + wanted + "' in this series; there " +
                             (s.volumes.size() == 1 ? "is" : "are") + list);
}

}  // namespace

DicomFolder scanDicom(const std::string& path, bool force) {
  if (fs::is_directory(path)) return sorted(path, readFiles(filesOfFolder(path)), force);
  DicomFile file = readDicomFile(path);
  const bool alone = file.isWhole || !file.damage.empty() || !file.foreign.empty() || file.frames.empty();
  if (alone) {
    std::vector<DicomFile> one;
    one.push_back(std::move(file));
    return sorted(path, std::move(one), force);
  }
  const fs::path parent = fs::path(path).parent_path();
  DicomFolder found = sorted(path, readFiles(filesOfFolder(parent.empty() ? "." : parent.string())), force);
  found.notes.clear();  // what else is in the folder was not asked for
  return found;
}

bool holdsDicomVolumes(const std::string& path) { return readDicomFile(path).isWhole; }

DicomChoice chooseDicomVolume(const std::string& path, const std::string& selection, bool force,
                              Notes& notes) {
  DicomFolder found = scanDicom(path, force);
  const size_t at = selection.find('@');
  const std::string wanted = selection.substr(0, at),
                    volume = at == std::string::npos ? "" : selection.substr(at + 1);
  const bool folder = fs::is_directory(path);
  notes.insert(notes.end(), found.notes.begin(), found.notes.end());
  std::vector<size_t> candidates;
  std::vector<std::pair<size_t, size_t>> ofFile;
  if (!wanted.empty()) {
    candidates = matching(found.series, wanted);
    if (candidates.empty())
      throw InputError(path, "has no series '" + wanted + "'; there are" + listed(path, found.series));
    if (candidates.size() > 1)
      throw InputError(path, "has " + std::to_string(candidates.size()) +
                                 " stacks of that UID, with other directions or sizes; choose one" +
                                 joinedBy(found.series, candidates) + ":" + listed(path, found.series));
  } else if (!folder) {
    ofFile = holding(found.series, path);
    for (const auto& [series, v] : ofFile)
      if (candidates.empty() || candidates.back() != series) candidates.push_back(series);
    if (candidates.empty()) throw IoError(path, "holds no image");
    if (candidates.size() > 1)
      throw InputError(path, "holds stacks of several directions; choose one" +
                                 joinedBy(found.series, candidates) + ":" + listed(path, found.series));
  } else {
    candidates = {onlySeries(path, found, notes)};
  }
  const size_t series = candidates[0];
  checkDamage(path, found, series, !wanted.empty() || !folder, notes);
  DicomChoice choice;
  const DicomSeries& s = found.series[series];
  if (!volume.empty())
    choice.volume = volumeOf(path, found, series, volume);
  else if (!s.isSegmentation() && ofFile.size() == 1)
    choice.volume = ofFile[0].second;
  else if (!s.isSegmentation() && s.volumes.size() > 1)
    throw InputError(
        path, "holds " + std::to_string(s.volumes.size()) +
                  " volumes, which are never stacked; choose one:" + listed(path, found.series, series));
  choice.series = std::move(found.series[series]);
  return choice;
}

}  // namespace slicemorph
