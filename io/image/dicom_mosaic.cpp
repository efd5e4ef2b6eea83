#include "io/image/dicom_file.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <map>

namespace slicemorph {
namespace {

constexpr DicomTag kTileCount = 0x0019100a;
constexpr int kMostTiles = 4096;

/// Siemens' private header "CSA": names with texts. Read by its layout as nibabel documents it (nibabel.nicom.csareader);
/// empty where the bytes are none.
std::map<std::string, std::vector<std::string>> csaHeaderOf(std::string_view raw) {
  std::map<std::string, std::vector<std::string>> header;
  const bool second = raw.substr(0, 4) == "SV10";
  size_t at = second ? 8 : 0;
  bool cut = false;
  const auto number = [&]() -> std::uint32_t {
    if (raw.size() < 4 || at > raw.size() - 4) return cut = true, 0;
    std::uint32_t value = 0;
    for (size_t i = 0; i < 4; ++i) value |= std::uint32_t(static_cast<unsigned char>(raw[at + i])) << (8 * i);
    at += 4;
    return value;
  };
  const std::uint32_t tags = number();
  number();
  if (tags < 1 || tags > 1024) return header;
  std::uint32_t firstCount = 0;
  for (std::uint32_t t = 0; t < tags && !cut; ++t) {
    if (at + 64 > raw.size()) break;
    std::string name(raw.substr(at, 64));
    name.resize(std::min(name.find('\0'), name.size()));
    at += 64;
    number(), number(), number();  // multiplicity, type, number of the type
    const std::uint32_t items = number();
    number();
    if (t == 0) firstCount = items;
    for (std::uint32_t i = 0; i < items && !cut; ++i) {
      const std::uint32_t a = number(), b = number();
      number(), number();
      const std::uint32_t length = second ? b : a - firstCount;
      if (cut || length > raw.size() - at) {
        cut = true;
        break;
      }
      std::string value(raw.substr(at, length));
      value.resize(std::min(value.find('\0'), value.size()));
      at += (length + 3) / 4 * 4;
      header[name].push_back(value);
    }
  }
  return header;
}

/// What the private headers say of a mosaic.
struct MosaicHeader {
  int counts[3] = {0, 0, 0};  ///< by the image's header, by a single element, by the protocol; 0: not said
  std::optional<Vec3d> normal;
  std::vector<Vec3d> places;  ///< of the slices' centres, by the protocol

  int count() const {
    int found = 0;
    for (int c : counts) {
      if (c > 0 && found > 0 && c != found) return -1;
      if (c > 0) found = c;
    }
    return found;
  }
};

/// The lines `key = value` of the protocol.
std::map<std::string, std::string> protocolOf(const std::string& text) {
  std::map<std::string, std::string> lines;
  size_t at = text.find("### ASCCONV BEGIN");
  const size_t end = std::min(text.find("### ASCCONV END"), text.size());
  while (at < end) {
    const size_t stop = std::min(text.find('\n', at), end);
    const std::string line = text.substr(at, stop - at);
    const size_t equals = line.find('=');
    if (equals != std::string::npos) {
      const std::string key = line.substr(0, line.find_last_not_of(" \t", equals - 1) + 1);
      lines[key] = line.substr(std::min(line.find_first_not_of(" \t", equals + 1), line.size()));
    }
    at = stop + 1;
  }
  return lines;
}

void readProtocol(const std::string& text, MosaicHeader& header) {
  const std::map<std::string, std::string> lines = protocolOf(text);
  const auto found = lines.find("sSliceArray.lSize");
  if (found == lines.end()) return;
  const int count = std::atoi(found->second.c_str());
  if (count < 1 || count > kMostTiles) return;
  header.counts[2] = count;
  for (int k = 0; k < count; ++k) {
    const std::string slice = "sSliceArray.asSlice[" + std::to_string(k) + "].";
    if (!lines.count(slice + "dThickness")) {
      header.places.clear();
      return;
    }
    Vec3d place(0.0);  // coordinates that are 0 are not written
    for (int d = 0; d < 3; ++d) {
      constexpr const char* kAxes[] = {"dSag", "dCor", "dTra"};
      const auto value = lines.find(slice + "sPosition." + kAxes[d]);
      if (value != lines.end()) place[d] = std::strtod(value->second.c_str(), nullptr);
    }
    header.places.push_back(place);
  }
}

MosaicHeader mosaicHeaderOf(const DicomElements& data) {
  MosaicHeader header;
  header.counts[1] = std::max(0, int(data.first(kTileCount, "US")));
  for (DicomTag tag : data.tags()) {
    // The private header stands in a block of any number, mostly 10.
    if (tag >> 16 != 0x0029 || (tag & 0xff) % 0x10 != 0 || (tag & 0xffff) < 0x1000) continue;
    auto csa = csaHeaderOf(data.bytes(tag));
    const auto& count = csa["NumberOfImagesInMosaic"];
    if (!count.empty()) header.counts[0] = std::max(0, std::atoi(count[0].c_str()));
    const auto& normal = csa["SliceNormalVector"];
    if (normal.size() >= 3 && !normal[0].empty())
      header.normal =
          Vec3d(std::atof(normal[0].c_str()), std::atof(normal[1].c_str()), std::atof(normal[2].c_str()));
    for (const char* name : {"MrPhoenixProtocol", "MrProtocol"})
      if (header.counts[2] == 0 && !csa[name].empty()) readProtocol(csa[name][0], header);
  }
  return header;
}

/// Where the tiles lie along the normal, from the first; none where that is not certain, which `why` then says.
std::vector<double> offsetsOfTiles(const MosaicHeader& header, int count, const DicomFrame& frame,
                                   const Vec3d& normal, const Vec3d& firstCentre, std::string& why) {
  if (count == 1) return {0.0};
  const double stated = std::abs(frame.between);
  int way = 0;
  if (header.normal) {
    const double along = header.normal->dot(normal);
    if (std::abs(along) > 0.99) way = along > 0 ? 1 : -1;
  }
  std::vector<double> offsets;
  if (header.places.size() == size_t(count)) {
    // The first tile is the first or the last slice of the protocol.
    const double first = header.places.front().dot(normal), last = header.places.back().dot(normal),
                 here = firstCentre.dot(normal), gap = std::abs(last - first) / (count - 1);
    const bool isFirst = std::abs(here - first) < gap / 4, isLast = std::abs(here - last) < gap / 4;
    if (isFirst != isLast) {
      for (int k = 0; k < count; ++k)
        offsets.push_back(isFirst ? header.places[size_t(k)].dot(normal) - first
                                  : header.places[size_t(count - 1 - k)].dot(normal) - last);
      const int found = offsets.back() > 0 ? 1 : -1;
      if (way != 0 && found != way)
        return why = "its header names both directions for its slices", std::vector<double>();
      if (stated > 0 && std::abs(gap - stated) > 0.01 * stated)
        return why = "its header has two distances between slices", std::vector<double>();
      return offsets;
    }
  }
  if (way == 0)
    return why = "its private header does not tell in which direction its slices follow each other",
           std::vector<double>();
  if (stated == 0)
    return why = "it states no distance between slices (SpacingBetweenSlices)", std::vector<double>();
  for (int k = 0; k < count; ++k) offsets.push_back(way * k * stated);
  return offsets;
}

/// Whether all pixels of the tiles behind the last slice are equal, as they must be. Not known of compressed ones.
bool isBlankBehind(const DicomElements& data, const DicomFile& file, int count, int across) {
  const DicomPixels& p = file.pixels;
  if (!data.plainPixels() || count == across * across) return true;
  const std::string_view pixels = data.bytes(p.tag);
  const size_t bytes = size_t(p.bits) / 8, columns = size_t(p.columns / across),
               rows = size_t(p.rows / across);
  if (pixels.size() < size_t(p.columns) * size_t(p.rows) * bytes) return false;
  const auto at = [&](int tile, size_t row, size_t column) {
    const size_t i =
        (size_t(tile / across) * rows + row) * size_t(p.columns) + size_t(tile % across) * columns + column;
    return pixels.substr(i * bytes, bytes);
  };
  const std::string_view blank = at(count, 0, 0);
  for (int tile = count; tile < across * across; ++tile)
    for (size_t j = 0; j < rows; ++j)
      for (size_t i = 0; i < columns; ++i)
        if (at(tile, j, i) != blank) return false;
  return true;
}

}  // namespace

bool isMosaic(const DicomElements& data) {
  std::string maker = data.text(kManufacturerTag);
  for (char& c : maker) c = char(std::toupper(static_cast<unsigned char>(c)));
  return data.text(kImageTypeTag).find("MOSAIC") != std::string::npos ||
         (maker.find("SIEMENS") != std::string::npos && data.first(kTileCount, "US") > 1);
}

void splitMosaic(const DicomElements& data, DicomFile& file) {
  file.notSplit = true;
  const MosaicHeader header = mosaicHeaderOf(data);
  const int count = header.count();
  const std::string what = "it is a mosaic of Siemens, whose tiles are slices, and ";
  if (file.frames.size() != 1 || count == 0) {
    file.uncertain = what + "how many is not in its private header";
    return;
  }
  if (count < 0) {
    file.uncertain = what + "its private header has several numbers for how many";
    return;
  }
  if (file.pixels.bits < 8) {
    file.uncertain = what + "its pixels are single bits";
    return;
  }
  const int across = int(std::ceil(std::sqrt(double(count)) - 1e-9));
  if (count > kMostTiles || file.columns % across != 0 || file.rows % across != 0) {
    file.uncertain = what + std::to_string(count) + " do not fit in " + std::to_string(file.columns) + " x " +
                     std::to_string(file.rows) + " pixels";
    return;
  }
  if (!isBlankBehind(data, file, count, across)) {
    file.uncertain = what + "there is something behind the last of " + std::to_string(count) + " tiles";
    return;
  }
  const DicomFrame whole = file.frames[0];
  if (!whole.position || !whole.axes || !whole.pixel) {
    file.uncertain = what + "its position, direction or pixel size is missing";
    return;
  }
  const Vec3d x = (*whole.axes)[0], y = (*whole.axes)[1], normal = x.cross(y).unit();
  const int columns = file.columns / across, rows = file.rows / across;
  const double dx = (*whole.pixel)[0], dy = (*whole.pixel)[1];
  // The stated position is that of a picture as large as the mosaic around the slice's centre.
  const Vec3d first =
      *whole.position + (file.columns - columns) / 2.0 * dx * x + (file.rows - rows) / 2.0 * dy * y;
  std::string why;
  const std::vector<double> offsets = offsetsOfTiles(header, count, whole, normal, first, why);
  if (offsets.empty()) {
    file.uncertain = what + why;
    return;
  }
  file.notSplit = false;
  file.columns = columns, file.rows = rows;
  file.frames.assign(size_t(count), whole);
  for (int k = 0; k < count; ++k) {
    DicomFrame& tile = file.frames[size_t(k)];
    tile.tile[0] = k % across * columns, tile.tile[1] = k / across * rows;
    tile.position = first + offsets[size_t(k)] * normal;
  }
}

}  // namespace slicemorph
