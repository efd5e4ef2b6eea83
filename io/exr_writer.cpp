#include "io/exr_writer.h"

#include "engine/errors.h"
#include "io/atomic_file.h"

#include <ImathMatrix.h>
#include <ImfChannelList.h>
#include <ImfFloatAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfIntAttribute.h>
#include <ImfMatrixAttribute.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <ImfVecAttribute.h>

#include <algorithm>
#include <cstring>

namespace slicemorph {
namespace {

/// A file in memory, so that it can reach the disk in one piece.
class MemoryStream : public Imf::OStream {
 public:
  explicit MemoryStream(const std::string& name) : Imf::OStream(name.c_str()) {}

  void write(const char bytes[], int count) override {
    if (bytes_.size() < position_ + size_t(count)) bytes_.resize(position_ + size_t(count));
    std::memcpy(&bytes_[position_], bytes, size_t(count));
    position_ += size_t(count);
  }
  uint64_t tellp() override { return position_; }
  void seekp(uint64_t position) override { position_ = position; }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
  size_t position_ = 0;
};

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
  MemoryStream stream(path);
  try {
    // No threads of OpenEXR's own: the caller writes one file a task.
    Imf::OutputFile file(stream, header, 0);
    file.setFrameBuffer(buffer);
    file.writePixels(header.dataWindow().max.y + 1);
  } catch (const std::exception& error) {
    throw IoError(path + ": the EXR cannot be written: " + error.what());
  }
  AtomicFile output(path);
  output.write(stream.bytes());
  output.commit();
}

Imath::V3f toImath(const Vec3d& v) { return {float(v.x()), float(v.y()), float(v.z())}; }

/// Rows of a matrix that multiplies row vectors.
Imath::M44f matrixOf(const Vec3d& x, const Vec3d& y, const Vec3d& z, const Vec3d& origin) {
  Imath::M44f matrix;
  const Vec3d* rows[4] = {&x, &y, &z, &origin};
  for (int r = 0; r < 4; ++r) {
    for (int c = 0; c < 3; ++c) matrix[r][c] = float((*rows[r])[c]);
  }
  return matrix;
}

/// x right, y up, z along the normal, origin in the image's centre, world units.
Imath::M44f worldToCamera(const SectionPlane& plane) {
  const Vec3d centre = plane.origin + plane.xAxis * (plane.pixelSize * (plane.width - 1) / 2) +
                       plane.yAxis * (plane.pixelSize * (plane.height - 1) / 2);
  // The axes are orthonormal, so the inverse of camera-to-world is its transpose.
  const Vec3d axes[3] = {plane.xAxis, -plane.yAxis, plane.normal};
  Imath::M44f matrix;
  for (int c = 0; c < 3; ++c) {
    for (int r = 0; r < 3; ++r) matrix[r][c] = float(axes[c][r]);
    matrix[3][c] = float(-centre.dot(axes[c]));
  }
  return matrix;
}

void place(Imf::Header& header, const SectionPlane& plane) {
  header.insert("sliceOrigin", Imf::V3fAttribute(toImath(plane.origin)));
  header.insert("sliceAxisX", Imf::V3fAttribute(toImath(plane.xAxis)));
  header.insert("sliceAxisY", Imf::V3fAttribute(toImath(plane.yAxis)));
  header.insert("sliceNormal", Imf::V3fAttribute(toImath(plane.normal)));
  header.insert("slicePixelSize", Imf::FloatAttribute(float(plane.pixelSize)));
  header.insert("sliceIndex", Imf::IntAttribute(plane.index));
  header.insert("sliceCount", Imf::IntAttribute(plane.count));
  header.insert("sliceU", Imf::FloatAttribute(float(plane.u)));
  header.insert("pixelToWorld",
                Imf::M44fAttribute(matrixOf(plane.xAxis * plane.pixelSize, plane.yAxis * plane.pixelSize,
                                            plane.normal * plane.pixelSize, plane.origin)));
  Imf::addWorldToCamera(header, worldToCamera(plane));
}

/// Share of a pixel inside, for a surface that crosses it straight.
std::vector<float> coverageOf(const Section& section) {
  std::vector<float> coverage(section.values.size());
  const float pixel = float(section.plane.pixelSize);
  std::transform(section.values.begin(), section.values.end(), coverage.begin(),
                 [pixel](float distance) { return std::clamp(0.5f - distance / pixel, 0.0f, 1.0f); });
  return coverage;
}

}  // namespace

void writeSliceExr(const std::string& path, const Section& section, const SliceExrOptions& options) {
  Imf::Header header(section.plane.width, section.plane.height);
  place(header, section.plane);
  if (!options.levelSet) {
    writeFloats(path, header,
                {{options.gridName.empty() ? "value" : options.gridName, section.values.data(), 1}});
    return;
  }
  const std::vector<float> coverage = coverageOf(section);
  writeFloats(path, header, {{"surface.sdf", section.values.data(), 1}, {"coverage", coverage.data(), 1}});
}

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
