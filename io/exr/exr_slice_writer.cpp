#include "io/exr/exr_slice_writer.h"

#include "engine/sections/section.h"
#include "io/exr/exr_slice_header.h"
#include "io/exr/exr_stream.h"
#include "slicemorph/errors.h"

#include <ImfChannelList.h>
#include <ImfDoubleAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIntAttribute.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <ImfStringVectorAttribute.h>
#include <ImfTileDescription.h>
#include <ImfTiledOutputPart.h>
#include <half.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_pipeline.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <type_traits>
#include <utility>

namespace slicemorph {
namespace {

const std::vector<std::pair<std::string, Imf::Compression>> kCompressions = {
    {"none", Imf::NO_COMPRESSION},  {"rle", Imf::RLE_COMPRESSION},   {"zips", Imf::ZIPS_COMPRESSION},
    {"zip", Imf::ZIP_COMPRESSION},  {"piz", Imf::PIZ_COMPRESSION},   {"pxr24", Imf::PXR24_COMPRESSION},
    {"b44", Imf::B44_COMPRESSION},  {"b44a", Imf::B44A_COMPRESSION}, {"dwaa", Imf::DWAA_COMPRESSION},
    {"dwab", Imf::DWAB_COMPRESSION}};

Imf::Compression compressionOf(const std::string& name) {
  for (const auto& [known, value] : kCompressions)
    if (known == name) return value;
  throw InputError("compression '" + name + "' is unknown");
}

/// Integers and flags must be read back exactly, so they are never stored as half floats.
bool isExact(const openvdb::GridBase& grid) {
  return grid.apply<openvdb::TypeList<openvdb::Int32Grid, openvdb::Int64Grid, openvdb::Vec3IGrid,
                                      openvdb::BoolGrid, openvdb::MaskGrid>>([](const auto&) {});
}

std::string numberedName(int number) {
  char name[32];
  std::snprintf(name, sizeof name, "slice.%04d", number);
  return name;
}

/// Makes a file with one part per header; `fill` writes their pixels. `threads`: of OpenEXR.
template <typename Fill>
void writeFile(const std::string& path, const std::vector<Imf::Header>& headers, int threads,
               const Fill& fill) {
  AtomicFile output(path);
  ExrStream stream(output, path);
  try {
    Imf::MultiPartOutputFile file(stream, headers.data(), int(headers.size()), false, threads);
    fill(file);
  } catch (const Iex::BaseExc& error) {
    throw IoError(path, std::string("the EXR cannot be written: ") + error.what());
  }
  stream.flush();
  output.commit();
}

/// Most slices that are sampled together: as many as a leaf is wide, so that most of them share its voxels;
/// and the bytes that they may take, a bound of memory per thread.
constexpr size_t kMostSlicesTogether = 8;
constexpr double kMostSliceBytes = 64 << 20;

/// Writes the slices of one set.
class SliceWriter {
 public:
  SliceWriter(const std::vector<SliceGrid>& grids, const std::vector<SectionPlane>& planes,
              const SliceExrOptions& options)
      : grids_(grids), planes_(planes), options_(options) {
    for (const SectionPlane& plane : planes) {
      size_.x = std::max(size_.x, plane.width);
      size_.y = std::max(size_.y, plane.height);
    }
    for (const SliceGrid& grid : grids) anyDistance_ = anyDistance_ || isDistance(*grid.grid);
  }

  Imf::Header header(size_t n) const {
    const SectionPlane& plane = planes_[n];
    const Imath::Box2i display({0, 0}, size_ - Imath::V2i(1)),
        data({0, 0}, {plane.width - 1, plane.height - 1});
    Imf::Header header(display, data);
    header.compression() = compressionOf(options_.compression);
    header.zipCompressionLevel() = kExrZipLevel;
    header.setType(options_.tile > 0 ? Imf::TILEDIMAGE : Imf::SCANLINEIMAGE);
    header.setName(numberedName(plane.index + 1));
    if (options_.tile > 0)
      header.setTileDescription(Imf::TileDescription(unsigned(options_.tile), unsigned(options_.tile)));
    placeSlice(header, plane);
    header.insert("software", Imf::StringAttribute("slicemorph"));
    header.insert("sliceUnits", Imf::StringAttribute(options_.units));
    if (options_.t) header.insert("sliceT", Imf::DoubleAttribute(*options_.t));
    if (options_.frame) header.insert("sliceFrame", Imf::IntAttribute(*options_.frame));
    if (options_.framesPerSecond) Imf::addFramesPerSecond(header, Imf::Rational(*options_.framesPerSecond));
    Imf::StringVector names;
    for (const SliceGrid& grid : grids_) {
      names.push_back(grid.name);
      describeGrid(header, grid);
      for (const std::string& channel : sliceChannels(grid.name, *grid.grid))
        header.channels().insert(channel, Imf::Channel(pixelType(*grid.grid)));
    }
    if (anyDistance_)
      header.channels().insert("coverage", Imf::Channel(options_.halfFloat ? Imf::HALF : Imf::FLOAT));
    header.insert("sliceGrids", Imf::StringVectorAttribute(names));
    return header;
  }

  /// Values of slices `first` to `last` - 1: for each slice one entry per grid, then the coverage if there
  /// are level sets.
  std::vector<std::vector<SectionValues>> sample(size_t first, size_t last) const {
    const std::vector<SectionPlane> planes(planes_.begin() + long(first), planes_.begin() + long(last));
    std::vector<std::vector<SectionValues>> slices(planes.size());
    for (const SliceGrid& grid : grids_) {
      std::vector<SectionValues> layer = sampleSections(*grid.grid, planes);
      for (size_t n = 0; n < planes.size(); ++n) slices[n].push_back(std::move(layer[n]));
    }
    for (size_t n = 0; n < planes.size() && anyDistance_; ++n)
      slices[n].push_back(coverage(planes[n], slices[n]));
    return slices;
  }

  /// How many consecutive slices are sampled together: at most kMostSlicesTogether and kMostSliceBytes
  /// (counted as four floats per pixel and grid), and so few that every thread gets two batches.
  size_t batch(size_t threads) const {
    const double bytes = 16.0 * double(size_.x) * double(size_.y) * double(grids_.size());
    const size_t even = (planes_.size() + 2 * threads - 1) / (2 * threads);
    return std::clamp(std::min(size_t(kMostSliceBytes / bytes), even), size_t(1), kMostSlicesTogether);
  }

  /// Writes one slice as a file of its own, without threads of OpenEXR: the caller writes one file per task.
  void writeOne(const std::string& path, size_t n, const std::vector<SectionValues>& layers) const {
    writeFile(path, {header(n)}, 0, [&](Imf::MultiPartOutputFile& file) { write(file, 0, n, layers); });
  }

  void write(Imf::MultiPartOutputFile& file, int part, size_t n,
             const std::vector<SectionValues>& layers) const {
    const SectionPlane& plane = planes_[n];
    const size_t count = size_t(plane.width) * size_t(plane.height);
    Imf::FrameBuffer buffer;
    std::vector<std::vector<half>> halves;
    for (size_t g = 0; g < layers.size(); ++g) {
      const bool own = g < grids_.size();
      const bool toHalf = own ? pixelType(*grids_[g].grid) == Imf::HALF : options_.halfFloat;
      const std::vector<std::string> names =
          own ? sliceChannels(grids_[g].name, *grids_[g].grid) : std::vector<std::string>{"coverage"};
      for (size_t c = 0; c < names.size(); ++c) {
        // OpenEXR's interface is not const, but writing only reads.
        float* floats = const_cast<float*>(layers[g].values.data()) + c * count;
        if (toHalf) {
          halves.push_back(toHalves(floats, count, names[c]));
          insert(buffer, names[c], halves.back().data(), plane.width);
        } else {
          insert(buffer, names[c], floats, plane.width);
        }
      }
    }
    if (options_.tile > 0) {
      Imf::TiledOutputPart out(file, part);
      out.setFrameBuffer(buffer);
      out.writeTiles(0, out.numXTiles() - 1, 0, out.numYTiles() - 1);
    } else {
      Imf::OutputPart out(file, part);
      out.setFrameBuffer(buffer);
      out.writePixels(plane.height);
    }
  }

 private:
  /// The share of every pixel that is inside any level set: 0.5 - distance / pixel size, which is exact for a
  /// flat surface parallel to a side of the pixel.
  SectionValues coverage(const SectionPlane& plane, const std::vector<SectionValues>& layers) const {
    SectionValues coverage{1, std::vector<float>(size_t(plane.width) * size_t(plane.height), 0.0f)};
    const float pixel = float(plane.pixelSize);
    for (size_t g = 0; g < grids_.size(); ++g) {
      if (!isDistance(*grids_[g].grid)) continue;
      for (size_t i = 0; i < coverage.values.size(); ++i)
        coverage.values[i] =
            std::max(coverage.values[i], std::clamp(0.5f - layers[g].values[i] / pixel, 0.0f, 1.0f));
    }
    return coverage;
  }

  Imf::PixelType pixelType(const openvdb::GridBase& grid) const {
    return options_.halfFloat && !isExact(grid) ? Imf::HALF : Imf::FLOAT;
  }

  template <typename T>
  static void insert(Imf::FrameBuffer& buffer, const std::string& name, T* first, int width) {
    const auto type = std::is_same_v<T, half> ? Imf::HALF : Imf::FLOAT;
    buffer.insert(name,
                  Imf::Slice(type, reinterpret_cast<char*>(first), sizeof(T), sizeof(T) * size_t(width)));
  }

  static std::vector<half> toHalves(const float* values, size_t count, const std::string& channel) {
    constexpr float kLargest = 65504;  // of IEEE 754 half floats
    std::vector<half> result(count);
    for (size_t i = 0; i < count; ++i) {
      if (std::abs(values[i]) > kLargest && std::isfinite(values[i]))
        throw InputError("channel '" + channel + "' holds " + std::to_string(values[i]) +
                         ", more than half floats can (65504): leave out --half");
      result[i] = half(values[i]);
    }
    return result;
  }

  const std::vector<SliceGrid>& grids_;
  const std::vector<SectionPlane>& planes_;
  const SliceExrOptions& options_;
  Imath::V2i size_{1, 1};
  bool anyDistance_ = false;
};

}  // namespace

const std::vector<std::string>& exrCompressions() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    list.reserve(kCompressions.size());
    for (const auto& compression : kCompressions) list.push_back(compression.first);
    return list;
  }();
  return names;
}

void writeSliceExr(const std::string& path, const std::vector<SliceGrid>& grids,
                   const std::vector<SectionPlane>& planes, size_t n, const SliceExrOptions& options) {
  const SliceWriter writer(grids, planes, options);
  writer.writeOne(path, n, writer.sample(n, n + 1)[0]);
}

void writeSliceFiles(const std::function<std::string(size_t)>& path, const std::vector<SliceGrid>& grids,
                     const std::vector<SectionPlane>& planes, const SliceExrOptions& options,
                     Progress& progress) {
  const SliceWriter writer(grids, planes, options);
  const size_t batch = writer.batch(size_t(threadCount()));
  std::atomic<size_t> done{0};
  tbb::parallel_for(
      tbb::blocked_range<size_t>(0, (planes.size() + batch - 1) / batch, 1),
      [&](const auto& range) {
        for (size_t b = range.begin(); b < range.end(); ++b) {
          const size_t first = b * batch, last = std::min(first + batch, planes.size());
          const std::vector<std::vector<SectionValues>> slices = writer.sample(first, last);
          for (size_t n = first; n < last; ++n) {
            if (progress.cancelled()) throw Cancelled();
            writer.writeOne(path(n), n, slices[n - first]);
            progress.report("slicing", double(++done) / double(planes.size()));
          }
        }
      },
      tbb::simple_partitioner());
}

void writeSlicesExr(const std::string& path, const std::vector<SliceGrid>& grids,
                    const std::vector<SectionPlane>& planes, const SliceExrOptions& options,
                    Progress& progress) {
  const SliceWriter writer(grids, planes, options);
  std::vector<Imf::Header> headers;
  for (size_t n = 0; n < planes.size(); ++n) headers.push_back(writer.header(n));
  const int threads = exrThreads();
  const size_t batch = writer.batch(size_t(threads));
  writeFile(path, headers, threads, [&](Imf::MultiPartOutputFile& file) {
    // Some slices are sampled while others are written, in order.
    using Slices = std::vector<std::vector<SectionValues>>;
    size_t next = 0, written = 0;
    tbb::parallel_pipeline(
        size_t(threads) + 1,
        tbb::make_filter<void, size_t>(tbb::filter_mode::serial_in_order, [&](tbb::flow_control& flow) {
          if (next >= planes.size()) flow.stop();
          return std::exchange(next, next + batch);
        }) & tbb::make_filter<size_t, Slices>(tbb::filter_mode::parallel, [&](size_t first) {
          return writer.sample(first, std::min(first + batch, planes.size()));
        }) & tbb::make_filter<Slices, void>(tbb::filter_mode::serial_in_order, [&](const Slices& slices) {
          if (progress.cancelled()) throw Cancelled();
          progress.report("slicing", double(written) / double(planes.size()));
          for (const std::vector<SectionValues>& layers : slices) {
            writer.write(file, int(written), written, layers);
            ++written;
          }
        }));
  });
}

}  // namespace slicemorph
