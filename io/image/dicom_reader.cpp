#include "io/image/dicom_reader.h"

#include "io/image/dicom_elements.h"
#include "io/image/itk_values.h"
#include "io/image/straighten.h"
#include "io/whole_file.h"

#include <gdcmTrace.h>
#include <itkGDCMImageIO.h>
#include <itkMetaDataObject.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>

namespace slicemorph {
namespace {

namespace fs = std::filesystem;

struct DicomHeader {
  std::string uid, modality, description, shape;
  bool image = false;
};

/// A list of numbers rounded to four decimals, so that noise in the last digit does not split a series.
std::string rounded(const std::string& numbers) {
  std::string result;
  for (size_t at = 0; at <= numbers.size();) {
    const size_t end = std::min(numbers.find('\\', at), numbers.size());
    char digits[32];
    std::snprintf(digits, sizeof digits, "%.4f ", std::atof(numbers.substr(at, end - at).c_str()) + 0.0);
    result += digits;
    at = end + 1;
  }
  return result;
}

/// None where a file is no DICOM file. Throws IoError where it is a damaged one: every element's size is
/// checked, since GDCM aborts the program on files that were cut short.
std::optional<DicomHeader> readDicomHeader(const std::string& path) {
  constexpr DicomTag kModality = 0x00080060, kDescription = 0x0008103e, kSeries = 0x0020000e,
                     kOrientation = 0x00200037, kRows = 0x00280010, kColumns = 0x00280011,
                     kFrames = 0x00280008, kSpacing = 0x00280030, kBits = 0x00280100, kPixels = 0x7fe00010;
  const std::string bytes = readWholeFile(path);
  const bool marked = bytes.size() >= 132 && bytes.compare(128, 4, "DICM") == 0;
  DicomHeader header;
  try {
    const DicomElements data = DicomElements::ofFile(bytes);
    header.uid = data.text(kSeries), header.modality = data.text(kModality),
    header.description = data.text(kDescription);
    const int rows = data.number(kRows), columns = data.number(kColumns);
    header.image = rows > 0 && columns > 0;
    header.shape = std::to_string(rows) + " x " + std::to_string(columns) + " " +
                   rounded(data.text(kOrientation)) + rounded(data.text(kSpacing));
    if (!header.image && !marked && header.uid.empty()) return std::nullopt;
    const size_t frames = size_t(std::max(1, std::atoi(data.text(kFrames).c_str())));
    const size_t needed = size_t(std::max(rows, 0)) * size_t(std::max(columns, 0)) *
                          size_t(std::max(data.number(kBits), 1)) / 8 * frames;
    if (header.image && !data.has(kPixels)) throw DicomDamage("it has no pixels");
    if (header.image && data.plainPixels() && data.size(kPixels) < needed)
      throw DicomDamage("it has " + std::to_string(data.size(kPixels)) + " bytes of pixels, " +
                        std::to_string(needed) + " are needed");
  } catch (const DicomDamage& damage) {
    if (!marked) return std::nullopt;
    throw IoError(path, std::string("is truncated or damaged: ") + damage.what());
  }
  return header;
}

std::vector<std::string> filesOf(const std::string& folder) {
  std::error_code error;
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (entry.is_regular_file(error) && entry.path().filename().string()[0] != '.' &&
        entry.path().filename() != "DICOMDIR")
      files.push_back(entry.path().string());
  if (error) throw IoError(folder, "cannot be read: " + error.message());
  std::sort(files.begin(), files.end());
  return files;
}

/// One file: a slice, or a whole volume of several frames.
struct DicomSlice {
  std::string file;
  Vec3d position{0, 0, 0}, axis[2];
  Vec3d spacing{1, 1, 1};
  int size[3] = {1, 1, 1}, instance = 0;
  bool positioned = false;
  RawType type;
  ImageValues values;
};

std::string entry(const itk::ImageIOBase& io, const char* tag) {
  std::string value;
  itk::ExposeMetaData<std::string>(io.GetMetaDataDictionary(), tag, value);
  return value;
}

DicomSlice readSlice(const std::string& file) {
  const auto io = itk::GDCMImageIO::New();
  io->SetFileName(file);
  DicomSlice slice;
  slice.file = file;
  try {
    io->ReadImageInformation();
    if (io->GetNumberOfComponents() != 1)
      throw IoError(file, "its pixels have " + std::to_string(io->GetNumberOfComponents()) +
                              " components; only grey values can be read");
    const unsigned dimensions = io->GetNumberOfDimensions();
    itk::ImageIORegion region(dimensions);
    size_t count = 1;
    for (unsigned d = 0; d < std::min(dimensions, 3u); ++d) {
      slice.size[d] = int(io->GetDimensions(d));
      slice.spacing[int(d)] = io->GetSpacing(d);
      slice.position[int(d)] = io->GetOrigin(d);
      region.SetSize(d, io->GetDimensions(d));
      count *= io->GetDimensions(d);
    }
    for (unsigned d = 0; d < 2; ++d) {
      const std::vector<double> direction = io->GetDirection(d);
      slice.axis[d] = Vec3d(direction[0], direction[1], direction.size() > 2 ? direction[2] : 0);
    }
    slice.positioned = slice.size[2] > 1 || !entry(*io, "0020|0032").empty();
    slice.instance = std::atoi(entry(*io, "0020|0013").c_str());
    slice.type = rawTypeOf(file, io->GetComponentType());
    io->SetIORegion(region);
    slice.values = readValues(slice.type, count, [&](void* to) { io->Read(to); });
  } catch (const itk::ExceptionObject& error) {
    throw IoError(file, "is truncated or damaged: " + reasonOf(error));
  } catch (const IoError&) {
    throw;
  } catch (const std::exception& error) {
    throw IoError(file, std::string("is truncated or damaged: ") + error.what());
  }
  return slice;
}

std::string inMillimetres(double value) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.4g mm", value);
  return digits;
}

/// Sorts slices along their normal, or by instance number where positions are missing, and drops
/// duplicates: slices less than 0.001 mm apart with equal values. Throws InputError where the order is
/// unknown or such slices differ.
void order(const std::string& folder, std::vector<DicomSlice>& slices, ImageFile& file) {
  const Vec3d normal = slices[0].axis[0].cross(slices[0].axis[1]).unit();
  const bool positioned =
      std::all_of(slices.begin(), slices.end(), [](const DicomSlice& s) { return s.positioned; });
  if (!positioned) {
    std::sort(slices.begin(), slices.end(),
              [](const DicomSlice& a, const DicomSlice& b) { return a.instance < b.instance; });
    for (size_t i = 0; i < slices.size(); ++i) {
      if (i > 0 && slices[i].instance == slices[i - 1].instance)
        throw InputError(folder, "its slices have no positions, and " + slices[i - 1].file + " and " +
                                     slices[i].file +
                                     " have the same instance number: their order is not known");
      slices[i].position = slices[0].position + normal * (double(i) * slices[0].spacing[2]);
    }
    file.notes.emplace_back("image.positions-missing", Severity::kWarning, "",
                            "its slices have no positions: ordered by instance number, " +
                                inMillimetres(slices[0].spacing[2]) + " apart");
    return;
  }
  const auto along = [&](const DicomSlice& s) { return s.position.dot(normal); };
  std::stable_sort(slices.begin(), slices.end(),
                   [&](const DicomSlice& a, const DicomSlice& b) { return along(a) < along(b); });
  std::vector<DicomSlice> kept;
  size_t doubled = 0;
  for (DicomSlice& slice : slices) {
    const bool same = !kept.empty() && std::abs(along(slice) - along(kept.back())) < 1e-3;
    if (!same) {
      kept.push_back(std::move(slice));
    } else if (slice.values == kept.back().values) {
      if (++doubled <= 3)
        file.notes.emplace_back("image.slice-doubled", Severity::kNote, slice.file,
                                "is a double of " + kept.back().file + ": left out");
    } else {
      throw InputError(
          folder,
          kept.back().file + " and " + slice.file + " lie at the same place (" + inMillimetres(along(slice)) +
              " along the stack) but differ: two acquisitions are mixed; put each in a folder of its own");
    }
  }
  if (doubled > 3)
    file.notes.emplace_back("image.slice-doubled", Severity::kNote, "",
                            "and " + std::to_string(doubled - 3) + " more doubled slices");
  slices = std::move(kept);
}

ImageFile volumeOfSlice(DicomSlice slice) {
  ImageFile file;
  ImageLattice& lattice = file.image.lattice;
  lattice.size = openvdb::Coord(slice.size[0], slice.size[1], slice.size[2]);
  lattice.origin = slice.position;
  for (int d = 0; d < 2; ++d) lattice.step[d] = slice.axis[d] * slice.spacing[d];
  lattice.step[2] = slice.axis[0].cross(slice.axis[1]).unit() * slice.spacing[2];
  file.image.values = std::move(slice.values);
  return file;
}

/// Converts the values of all slices to float unless they are of one type already.
void unify(std::vector<DicomSlice>& slices) {
  const bool same = std::all_of(slices.begin(), slices.end(), [&](const DicomSlice& s) {
    return s.values.index() == slices[0].values.index();
  });
  if (same) return;
  for (DicomSlice& slice : slices)
    slice.values = std::visit(
        [](const auto& v) -> ImageValues { return std::vector<float>(v.begin(), v.end()); }, slice.values);
}

}  // namespace

DicomFolder scanDicomFolder(const std::string& folder) {
  gdcm::Trace::WarningOff(), gdcm::Trace::ErrorOff(), gdcm::Trace::DebugOff();
  itk::Object::GlobalWarningDisplayOff();
  DicomFolder found;
  std::map<std::string, DicomSeries> groups;
  size_t others = 0;
  const std::vector<std::string> files = filesOf(folder);
  std::vector<std::optional<DicomHeader>> headers(files.size());
  tbb::parallel_for(size_t(0), files.size(), [&](size_t i) {
    std::error_code ignored;
    if (fs::file_size(files[i], ignored) > 0) headers[i] = readDicomHeader(files[i]);
  });
  for (size_t i = 0; i < files.size(); ++i) {
    const std::optional<DicomHeader>& header = headers[i];
    if (!header) {
      ++others;
    } else if (!header->image) {
      found.notes.emplace_back("image.file-passed-over", Severity::kNote, files[i],
                               "holds no image (" +
                                   (header->modality.empty() ? "no modality" : header->modality) +
                                   "): passed over");
    } else {
      DicomSeries& series = groups[header->uid + " " + header->shape];
      series.uid = header->uid, series.modality = header->modality, series.description = header->description;
      series.files.push_back(files[i]);
    }
  }
  if (others > 0)
    found.notes.emplace_back("image.file-passed-over", Severity::kNote, "",
                             std::to_string(others) + " files of other kinds passed over");
  for (auto& [key, series] : groups) found.series.push_back(std::move(series));
  if (found.series.empty()) throw IoError(folder, "no DICOM images in this folder");
  return found;
}

DicomSeries chooseDicomSeries(const std::string& path, const std::string& wanted, Notes& notes) {
  const bool folder = fs::is_directory(path);
  DicomFolder found =
      scanDicomFolder(folder                             ? path
                      : fs::path(path).has_parent_path() ? fs::path(path).parent_path().string()
                                                         : ".");
  notes.insert(notes.end(), found.notes.begin(), found.notes.end());
  std::string list;
  for (size_t i = 0; i < found.series.size(); ++i) {
    DicomSeries& s = found.series[i];
    const bool named = !wanted.empty() && (wanted == std::to_string(i + 1) || wanted == s.uid);
    const bool holds = !folder && std::any_of(s.files.begin(), s.files.end(), [&](const std::string& f) {
      return fs::path(f).filename() == fs::path(path).filename();
    });
    if (named || holds) return std::move(s);
    list += "\n  " + path + ":" + std::to_string(i + 1) + "  " + s.modality + " '" + s.description + "', " +
            std::to_string(s.files.size()) + " slices, UID " + s.uid;
  }
  if (!folder) throw IoError(path, "holds no image");
  if (!wanted.empty()) throw InputError(path, "has no series '" + wanted + "'; there are" + list);
  if (found.series.size() > 1)
    throw InputError(path, "holds " + std::to_string(found.series.size()) + " series; choose one:" + list);
  return std::move(found.series[0]);
}

ImageFile readDicomSeries(const std::string& folder, const DicomSeries& series, const SizeCheck& check) {
  gdcm::Trace::WarningOff(), gdcm::Trace::ErrorOff(), gdcm::Trace::DebugOff();
  itk::Object::GlobalWarningDisplayOff();
  std::vector<DicomSlice> slices(series.files.size());
  slices[0] = readSlice(series.files[0]);
  const int* size = slices[0].size;
  check({size[0], size[1], size[2] > 1 ? size[2] : int(slices.size())},
        double(size[0]) * size[1] * size[2] * double(slices.size()) * slices[0].type.bytes);
  tbb::parallel_for(size_t(1), slices.size(), [&](size_t i) { slices[i] = readSlice(series.files[i]); });
  ImageFile file;
  if (slices.size() == 1) {
    file = volumeOfSlice(std::move(slices[0]));
    if (file.image.lattice.size[2] == 1)
      file.notes.emplace_back("image.one-slice", Severity::kWarning, "", "it holds one slice");
  } else {
    if (std::any_of(slices.begin(), slices.end(), [](const DicomSlice& s) { return s.size[2] > 1; }))
      throw InputError(folder, "holds several volumes in files of several frames; give one file");
    order(folder, slices, file);
    unify(slices);
    SliceStackInput stack;
    for (int d = 0; d < 2; ++d) stack.step[d] = slices[0].axis[d] * slices[0].spacing[d];
    stack.size[0] = slices[0].size[0], stack.size[1] = slices[0].size[1];
    for (DicomSlice& slice : slices) {
      stack.position.push_back(slice.position);
      stack.names.push_back(slice.file);
      stack.values.push_back(std::move(slice.values));
    }
    straighten(std::move(stack), file);
  }
  file.format = "DICOM series";
  file.about = series.modality + (series.description.empty() ? "" : " '" + series.description + "'");
  return file;
}

}  // namespace slicemorph
