#include "io/image/nrrd_header.h"

#include "io/image/chosen_volume.h"
#include "io/image/nrrd_place.h"
#include "io/paths.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <sstream>

namespace slicemorph {
namespace {

struct FreeNrrd {
  void operator()(Nrrd* nrrd) const { nrrdNuke(nrrd); }
  void operator()(NrrdIoState* state) const { nrrdIoStateNix(state); }
};
using NrrdPointer = std::unique_ptr<Nrrd, FreeNrrd>;

/// The library's last word on what went wrong, without the names of its functions.
std::string reasonOfNrrd() {
  const std::unique_ptr<char, decltype(&std::free)> text(biffGetDone("nrrd"), &std::free);
  std::string last;
  std::istringstream lines(text ? text.get() : "");
  for (std::string line; std::getline(lines, line);)
    if (line.find_first_not_of(" \t") != std::string::npos) last = line;
  const size_t mark = last.find(": ");
  if (last.compare(0, 1, "[") == 0 && mark != std::string::npos) last.erase(0, mark + 2);
  return last;
}

NrrdPointer parsed(const std::string& path, const NrrdText& text) {
  NrrdPointer nrrd(nrrdNew());
  const std::unique_ptr<NrrdIoState, FreeNrrd> state(nrrdIoStateNew());
  state->skipData = 1;
  if (nrrdStringRead(nrrd.get(), text.rest.c_str(), state.get()))
    throw IoError(path, "its NRRD header cannot be read: " + reasonOfNrrd());
  return nrrd;
}

RawType rawTypeOfNrrd(const std::string& path, const Nrrd& nrrd) {
  switch (nrrd.type) {
    case nrrdTypeChar:
      return {1, RawType::kSigned};
    case nrrdTypeUChar:
      return {1, RawType::kUnsigned};
    case nrrdTypeShort:
      return {2, RawType::kSigned};
    case nrrdTypeUShort:
      return {2, RawType::kUnsigned};
    case nrrdTypeInt:
      return {4, RawType::kSigned};
    case nrrdTypeUInt:
      return {4, RawType::kUnsigned};
    case nrrdTypeLLong:
      return {8, RawType::kSigned};
    case nrrdTypeULLong:
      return {8, RawType::kUnsigned};
    case nrrdTypeFloat:
      return {4, RawType::kFloat};
    case nrrdTypeDouble:
      return {8, RawType::kFloat};
    default:
      throw IoError(path, "its voxels are blocks of bytes; only numbers can be read");
  }
}

/// The step of an axis of time. From the text, as the library gets no spacings beside directions.
void readTimeStep(const NrrdText& text, unsigned axis, ImageHeader& header) {
  std::istringstream spacings(text.field("spacings"));
  std::string word;
  for (unsigned a = 0; a <= axis; ++a)
    if (!(spacings >> word)) return;
  const double step = std::strtod(word.c_str(), nullptr);
  if (!(step > 0) || !std::isfinite(step)) return;
  const std::vector<std::string> units = quotedWords(text.field("units"));
  const std::string unit = axis < units.size() ? lowered(units[axis]) : "";
  const double seconds = unit == "ms" || unit == "msec" ? 1e-3 : unit == "us" || unit == "usec" ? 1e-6 : 1;
  header.timeStep = step * seconds;
  header.inSeconds = seconds != 1 || unit == "s" || unit == "sec" || unit == "seconds";
}

void describeVolumes(const std::string& path, const NrrdText& text, const Nrrd& nrrd, NrrdHeader& header) {
  ImageFile& file = header.file;
  const double most = double(std::int64_t(1) << 40);
  double all = 1, volumes = 1;
  size_t found = 0;
  for (unsigned a = 0; a < nrrd.dim; ++a) {
    const NrrdAxisInfo& axis = nrrd.axis[a];
    all *= double(axis.size);
    if (!(all <= most) || axis.size > size_t(1) << 30)
      throw IoError(path, "its size along axis " + std::to_string(a) + ", " + std::to_string(axis.size) +
                              ", makes no sense");
    if (header.axes[a].domain) {
      file.image.lattice.size[int(found++)] = int(axis.size);
      continue;
    }
    volumes *= double(axis.size);
    if (axis.size == 1) continue;
    if (axis.kind == nrrdKindTime) readTimeStep(text, a, file.header);
    const std::string label = axis.label ? axis.label : "";
    header.volumeKinds.push_back(axis.kind != nrrdKindUnknown ? airEnumStr(nrrdKind, axis.kind)
                                 : label.empty()              ? "values"
                                                              : label);
    if ((axis.kind == nrrdKindRGBColor && axis.size == 3) ||
        (axis.kind == nrrdKindRGBAColor && axis.size == 4))
      header.colours = int(a);
  }
  // Where volumes are components, too, no one step leads from each to the next.
  if (header.volumeKinds.size() > 1) file.header.timeStep = 0;
  file.volumes = int(std::min(volumes, double(1 << 30)));
}

DataFiles dataOfNrrd(const std::string& path, const NrrdText& text) {
  DataFiles data;
  const std::string encoding = lowered(text.field("encoding"));
  const std::pair<const char*, DataFiles::Encoding> names[] = {
      {"raw", DataFiles::kRaw},    {"text", DataFiles::kText},   {"txt", DataFiles::kText},
      {"ascii", DataFiles::kText}, {"hex", DataFiles::kHex},     {"gzip", DataFiles::kGzip},
      {"gz", DataFiles::kGzip},    {"bzip2", DataFiles::kBzip2}, {"bz2", DataFiles::kBzip2},
  };
  const auto* known = std::find_if(std::begin(names), std::end(names),
                                   [&](const auto& row) { return encoding == row.first; });
  if (known == std::end(names))
    throw IoError(path,
                  "its encoding '" + encoding + "' is not known; there are raw, text, hex, gzip and bzip2");
  data.encoding = known->second;
  const std::string given = text.field("data file");
  data.files = given.empty() ? std::vector<std::string>{path} : namedDataFiles(path, given, text.dataFiles);
  if (given.empty()) data.from = text.end;
  data.bigEndian = lowered(text.field("endian")) == "big";
  const auto number = [&](const char* name) {
    const std::string value = text.field(name);
    if (value.empty()) return 0L;
    char* end = nullptr;
    const long skipped = std::strtol(value.c_str(), &end, 10);
    if (*end || skipped < -1)
      throw IoError(path, "its " + std::string(name) + " '" + value + "' makes no sense");
    return skipped;
  };
  data.byteSkip = number("byte skip");
  data.lineSkip = std::uint64_t(std::max(0L, number("line skip")));
  if (data.byteSkip < 0 && data.encoding != DataFiles::kRaw)
    throw IoError(path, "its byte skip -1 needs the encoding raw, not " + encoding);
  return data;
}

}  // namespace

NrrdHeader readNrrdHeader(const std::string& path, bool force) {
  const NrrdText text = readNrrdText(path);
  const NrrdPointer nrrd = parsed(path, text);
  NrrdHeader header;
  header.file.format = "NRRD";
  if (nrrd->content) header.file.about = nrrd->content;
  header.type = rawTypeOfNrrd(path, *nrrd);
  header.keys = text.keys;
  placeNrrd(path, text, *nrrd, header);
  if (!text.dropped.empty())
    header.file.notes.emplace_back(
        "image.header-repaired", Severity::kNote, "",
        "its header has " + text.dropped +
            " for axes that have 'space directions', which the format forbids: not used for these");
  describeVolumes(path, text, *nrrd, header);
  checkPlace(path, force, header.file);
  header.data = dataOfNrrd(path, text);
  return header;
}

}  // namespace slicemorph
