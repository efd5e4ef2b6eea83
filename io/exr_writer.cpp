#include "io/exr_writer.h"

#include "engine/errors.h"
#include "io/exr_stream.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <ImfStringAttribute.h>

namespace slicemorph {
namespace {

struct Channel {
  std::string name;
  const float* first;  ///< of the first pixel
  size_t stride;       ///< floats from pixel to pixel
};

void writeFloats(const std::string& path, Imf::Header header, const std::vector<Channel>& channels) {
  const int width = header.dataWindow().max.x + 1;
  header.compression() = Imf::ZIP_COMPRESSION;
  header.insert("software", Imf::StringAttribute("slicemorph"));
  Imf::FrameBuffer buffer;
  for (const Channel& channel : channels) {
    header.channels().insert(channel.name, Imf::Channel(Imf::FLOAT));
    // OpenEXR's interface is not const, but writing only reads.
    char* base = reinterpret_cast<char*>(const_cast<float*>(channel.first));
    const size_t pixel = channel.stride * sizeof(float);
    buffer.insert(channel.name, Imf::Slice(Imf::FLOAT, base, pixel, pixel * size_t(width)));
  }
  AtomicFile output(path);
  ExrStream stream(output, path);
  try {
    Imf::OutputFile file(stream, header, 0);
    file.setFrameBuffer(buffer);
    file.writePixels(header.dataWindow().max.y + 1);
  } catch (const Iex::BaseExc& error) {
    throw IoError(path + ": the EXR cannot be written: " + error.what());
  }
  stream.flush();
  output.commit();
}

}  // namespace

void writePictureExr(const std::string& path, const Picture& image) {
  std::vector<Channel> channels;
  for (size_t c = 0; c < 4; ++c) channels.push_back({std::string(1, "RGBA"[c]), image.rgba.data() + c, 4});
  if (!image.mask.empty()) channels.push_back({"mask", image.mask.data(), 1});
  if (!image.depth.empty()) channels.push_back({"Z", image.depth.data(), 1});
  for (size_t c = 0; c < 3 && !image.normal.empty(); ++c)
    channels.push_back({std::string("N.") + "XYZ"[c], image.normal.data() + c, 3});
  writeFloats(path, Imf::Header(image.width, image.height), channels);
}

}  // namespace slicemorph
