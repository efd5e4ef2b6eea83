#include "io/exr/exr_writer.h"

#include "io/exr/exr_stream.h"
#include "slicemorph/errors.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <half.h>

namespace slicemorph {
namespace {

/// Channels whose values are interleaved, pixel by pixel.
struct Channels {
  std::vector<std::string> names;
  const std::vector<float>& values;
  Imf::PixelType type;
};

Imath::M44f toImath(const openvdb::Mat4d& matrix) {
  Imath::M44f result;
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) result[row][column] = float(matrix(row, column));
  return result;
}

void writeChannels(const std::string& path, Imf::Header header, const std::vector<Channels>& groups) {
  const size_t width = size_t(header.dataWindow().max.x) + 1;
  header.compression() = Imf::ZIP_COMPRESSION;
  header.zipCompressionLevel() = kExrZipLevel;
  header.insert("software", Imf::StringAttribute("slicemorph"));
  Imf::FrameBuffer buffer;
  std::vector<std::vector<half>> halves;
  for (const Channels& group : groups) {
    size_t bytes = sizeof(float);
    // OpenEXR's interface is not const, but writing only reads.
    char* first = reinterpret_cast<char*>(const_cast<float*>(group.values.data()));
    if (group.type == Imf::HALF) {
      halves.emplace_back(group.values.begin(), group.values.end());
      bytes = sizeof(half), first = reinterpret_cast<char*>(halves.back().data());
    }
    const size_t pixel = bytes * group.names.size();
    for (size_t c = 0; c < group.names.size(); ++c) {
      header.channels().insert(group.names[c], Imf::Channel(group.type));
      buffer.insert(group.names[c], Imf::Slice(group.type, first + c * bytes, pixel, pixel * width));
    }
  }
  AtomicFile output(path);
  ExrStream stream(output, path);
  try {
    Imf::OutputFile file(stream, header, exrThreads());
    file.setFrameBuffer(buffer);
    file.writePixels(header.dataWindow().max.y + 1);
  } catch (const Iex::BaseExc& error) {
    throw IoError(path, std::string("the EXR cannot be written: ") + error.what());
  }
  stream.flush();
  output.commit();
}

}  // namespace

void writePictureExr(const std::string& path, const Picture& image) {
  std::vector<Channels> groups{{{"R", "G", "B", "A"}, image.rgba, Imf::HALF}};
  if (!image.mask.empty()) groups.push_back({{"mask"}, image.mask, Imf::HALF});
  if (!image.depth.empty()) groups.push_back({{"Z"}, image.depth, Imf::FLOAT});
  if (!image.normal.empty()) groups.push_back({{"N.X", "N.Y", "N.Z"}, image.normal, Imf::HALF});
  Imf::Header header(image.width, image.height);
  if (image.view) {
    Imf::addWorldToCamera(header, toImath(image.view->worldToCamera));
    Imf::addWorldToNDC(header, toImath(image.view->worldToScreen));
  }
  writeChannels(path, std::move(header), groups);
}

}  // namespace slicemorph
