#include "io/exr/exr_slice_reader.h"

#include "engine/sections/object_boxes.h"
#include "io/exr/exr_check.h"
#include "io/exr/exr_slice.h"
#include "io/paths.h"
#include "io/sequence.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/vdb_reader.h"

#include <ImfChannelList.h>
#include <ImfDoubleAttribute.h>
#include <ImfFloatAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfIntAttribute.h>
#include <ImfMultiPartInputFile.h>
#include <ImfStringAttribute.h>
#include <ImfStringVectorAttribute.h>
#include <ImfVecAttribute.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace slicemorph {
namespace {

using openvdb::GridBase;

/// Runs `action`; what OpenEXR throws becomes an IoError about the file.
template <typename Action>
auto guarded(const std::string& path, const Action& action) {
  try {
    return action();
  } catch (const Iex::BaseExc& error) {
    throw IoError(path, std::string("cannot be read: ") + error.what());
  } catch (const std::bad_alloc&) {
    throw IoError(path, "cannot be read: it is damaged, or larger than the memory");
  }
}

/// A part of a file and its header. Attributes that are missing or wrong throw IoError.
class Part {
 public:
  Part(const std::string& path, int number, const Imf::Header& header)
      : path_(path), number_(number), header_(header) {}

  const Imf::Header& header() const { return header_; }
  std::string name() const { return path_ + (number_ > 0 ? " part " + std::to_string(number_ + 1) : ""); }

  [[noreturn]] void lacks(const std::string& attribute) const {
    throw IoError(name(),
                  "is no slice: the attribute '" + attribute +
                      "' is missing or wrong; `slicemorph slice` writes the attributes that place it");
  }

  Vec3d vector(const std::string& attribute) const {
    Vec3d v(NAN);
    if (const auto* d = header_.findTypedAttribute<Imf::V3dAttribute>(attribute))
      v = Vec3d(d->value().x, d->value().y, d->value().z);
    else if (const auto* f = header_.findTypedAttribute<Imf::V3fAttribute>(attribute))
      v = Vec3d(f->value().x, f->value().y, f->value().z);
    if (!std::isfinite(v.lengthSqr())) lacks(attribute);
    return v;
  }

  double number(const std::string& attribute) const {
    double v = NAN;
    if (const auto* d = header_.findTypedAttribute<Imf::DoubleAttribute>(attribute)) v = d->value();
    if (const auto* f = header_.findTypedAttribute<Imf::FloatAttribute>(attribute)) v = double(f->value());
    if (const auto* i = header_.findTypedAttribute<Imf::IntAttribute>(attribute)) v = i->value();
    if (!std::isfinite(v)) lacks(attribute);
    return v;
  }

  std::string text(const std::string& attribute) const {
    const auto* found = header_.findTypedAttribute<Imf::StringAttribute>(attribute);
    if (!found) lacks(attribute);
    return found->value();
  }

  Imf::StringVector grids() const {
    const auto* found = header_.findTypedAttribute<Imf::StringVectorAttribute>("sliceGrids");
    if (!found || found->value().empty()) lacks("sliceGrids");
    return found->value();
  }

  SectionPlane plane() const {
    SectionPlane plane;
    plane.origin = vector("sliceOrigin");
    plane.xAxis = vector("sliceAxisX");
    plane.yAxis = vector("sliceAxisY");
    plane.pixelSize = number("slicePixelSize");
    plane.index = int(number("sliceIndex"));
    plane.count = int(number("sliceCount"));
    plane.u = number("sliceU");
    constexpr double kSlack = 1e-4;  // other programs may write axes as floats or with few digits
    const bool unit =
        std::abs(plane.xAxis.length() - 1) < kSlack && std::abs(plane.yAxis.length() - 1) < kSlack;
    if (!unit) lacks("sliceAxisX");
    if (std::abs(plane.xAxis.dot(plane.yAxis)) > kSlack) lacks("sliceAxisY");
    if (!(plane.pixelSize > 0)) lacks("slicePixelSize");
    plane.normal = plane.xAxis.cross(plane.yAxis);
    // A cropped image keeps its pixels' coordinates: the plane's origin moves to the corner of
    // its data window.
    const Imath::Box2i window = header_.dataWindow();
    plane.width = window.max.x - window.min.x + 1;
    plane.height = window.max.y - window.min.y + 1;
    plane.origin = plane.toWorld(window.min.x, window.min.y);
    if (double(plane.width) * plane.height > double(1 << 28))
      throw IoError(name(), "has more than 2^28 pixels");
    return plane;
  }

  /// An empty grid of the type, background, class and name that the attributes state.
  GridBase::Ptr prototype(const std::string& grid) const {
    const std::string type = text(grid + ".type");
    const GridBase::Ptr result = GridBase::isRegistered(type) ? GridBase::createGrid(type) : nullptr;
    if (!result || !isSliceable(*result)) lacks(grid + ".type");
    const Vec3d background = vector(grid + ".background");
    result->apply<SliceableTypes>([&](auto& typed) {
      using Value = typename std::decay_t<decltype(typed)>::ValueType;
      if constexpr (openvdb::VecTraits<Value>::IsVec)
        typed.tree().root().setBackground(Value(background), false);
      else
        typed.tree().root().setBackground(Value(background[0]), false);
    });
    result->setGridClass(GridBase::stringToGridClass(text(grid + ".class")));
    result->setVectorType(GridBase::stringToVecType(text(grid + ".vectorType")));
    result->setSaveFloatAsHalf(number(grid + ".halfFloat") != 0);
    if (result->getGridClass() == openvdb::GRID_LEVEL_SET && !(background[0] > 0))
      lacks(grid + ".background");
    // The grid's own name is the part before the number that tells grids of one name apart (`density[1]`).
    const size_t bracket = grid.rfind('[');
    result->setName(bracket == std::string::npos || bracket == 0 ? grid : grid.substr(0, bracket));
    return result;
  }

 private:
  std::string path_;
  int number_;
  const Imf::Header& header_;
};

/// The grids to read: their names and an empty grid of the type of each.
struct Chosen {
  std::vector<std::string> names;
  std::vector<GridBase::ConstPtr> prototypes;
};

Chosen chosenGrids(const Part& part, const std::vector<std::string>& wanted) {
  const Imf::StringVector there = part.grids();
  std::string list;
  for (const std::string& name : there) list += (list.empty() ? "" : ", ") + name;
  for (const std::string& name : wanted)
    if (std::find(there.begin(), there.end(), name) == there.end())
      throw InputError(part.name(), "has no grid '" + name + "'; there are " + list);
  Chosen chosen;
  for (const std::string& name : there) {
    if (!wanted.empty() && std::find(wanted.begin(), wanted.end(), name) == wanted.end()) continue;
    chosen.names.push_back(name);
    chosen.prototypes.push_back(part.prototype(name));
  }
  return chosen;
}

std::vector<SectionValues> readPixels(Imf::MultiPartInputFile& file, int number, const Part& part,
                                      const SectionPlane& plane, const Chosen& chosen) {
  const Imath::Box2i window = part.header().dataWindow();
  const size_t count = size_t(plane.width) * size_t(plane.height);
  std::vector<SectionValues> layers;
  Imf::FrameBuffer buffer;
  for (size_t g = 0; g < chosen.names.size(); ++g) {
    const std::vector<std::string> channels = sliceChannels(chosen.names[g], *chosen.prototypes[g]);
    layers.push_back({int(channels.size()), std::vector<float>(channels.size() * count)});
    for (size_t c = 0; c < channels.size(); ++c) {
      if (!part.header().channels().findChannel(channels[c]))
        throw IoError(part.name(),
                      "has no channel '" + channels[c] + "', which its attribute 'sliceGrids' names");
      buffer.insert(channels[c], Imf::Slice::Make(Imf::FLOAT, layers[g].values.data() + c * count, window));
    }
  }
  Imf::InputPart input(file, number);
  input.setFrameBuffer(buffer);
  input.readPixels(window.min.y, window.max.y);
  return layers;
}

/// All slices of one file.
struct FileSlices {
  std::vector<SectionPlane> planes;
  std::vector<std::vector<SectionValues>> layers;
};

FileSlices readFile(const std::string& path, const Chosen& chosen) {
  sizeOfInput(path);
  return guarded(path, [&] {
    Imf::MultiPartInputFile file(path.c_str(), 0);
    FileSlices slices;
    slices.planes.resize(size_t(file.parts()));
    slices.layers.resize(size_t(file.parts()));
    for (int n = 0; n < file.parts(); ++n) {
      const Part part(path, n, file.header(n));
      slices.planes[size_t(n)] = part.plane();
      const Imf::StringVector there = part.grids();
      for (size_t g = 0; g < chosen.names.size(); ++g)
        if (std::find(there.begin(), there.end(), chosen.names[g]) == there.end() ||
            part.text(chosen.names[g] + ".type") != chosen.prototypes[g]->type())
          throw IoError(part.name(), "is of another set of slices: it has no grid '" + chosen.names[g] +
                                         "' of the type " + chosen.prototypes[g]->type());
      slices.layers[size_t(n)] = readPixels(file, n, part, slices.planes[size_t(n)], chosen);
    }
    return slices;
  });
}

/// Bytes of the pixels of a file's slices, by its header.
double bytesOfSlices(const std::string& path, const Chosen& chosen) {
  return guarded(path, [&] {
    Imf::MultiPartInputFile file(path.c_str(), 0);
    double channels = 0, pixels = 0;
    for (size_t g = 0; g < chosen.names.size(); ++g)
      channels += double(sliceChannels(chosen.names[g], *chosen.prototypes[g]).size());
    for (int n = 0; n < file.parts(); ++n) {
      const SectionPlane plane = Part(path, n, file.header(n)).plane();
      pixels += double(plane.width) * plane.height;
    }
    return pixels * channels * sizeof(float);
  });
}

std::vector<std::string> pathsOf(const InputSpec& input) {
  if (!input.isSequence) return {input.path};
  std::vector<std::string> paths;
  for (const SequenceFile& file : findSequence(input.path, input.range)) paths.push_back(file.path);
  return paths;
}

}  // namespace

ExrSlices readSliceExrs(const InputSpec& input, const std::vector<std::string>& wanted,
                        const MemoryLimit& memory) {
  initialiseVdb();
  const std::vector<std::string> paths = pathsOf(input);
  sizeOfInput(paths[0]);
  for (const std::string& path : paths) checkExrHeader(path);
  const Chosen chosen = guarded(paths[0], [&] {
    Imf::MultiPartInputFile file(paths[0].c_str(), 0);
    const Part part(paths[0], 0, file.header(0));
    part.plane();
    return chosenGrids(part, wanted);
  });
  double bytes = 0;
  for (const std::string& path : paths) bytes += bytesOfSlices(path, chosen);
  memory.require(bytes, input.text, "its slices",
                 "take fewer or smaller ones, or only some grids by --grids");
  std::vector<FileSlices> files(paths.size());
  tbb::parallel_for(size_t(0), paths.size(), [&](size_t n) { files[n] = readFile(paths[n], chosen); });

  ExrSlices result;
  std::vector<SectionPlane> planes;
  std::vector<std::vector<SectionValues>*> layers;
  for (FileSlices& file : files)
    for (size_t n = 0; n < file.planes.size(); ++n)
      planes.push_back(file.planes[n]), layers.push_back(&file.layers[n]);
  std::set<int> seen;
  for (const SectionPlane& plane : planes)
    if (!seen.insert(plane.index).second)
      throw IoError(input.text,
                    "slice " + std::to_string(plane.index + 1) +
                        " is there twice: these are slices of several volumes or frames; name the "
                        "file or files of one");
  if (int(planes.size()) < planes[0].count)
    result.notes.emplace_back("slices.missing", Severity::kWarning, "",
                              "there are " + std::to_string(planes.size()) + " slices of " +
                                  std::to_string(planes[0].count) + "; gaps are bridged");
  for (const auto& prototype : chosen.prototypes) result.grids.push_back({prototype, {}});
  for (size_t n : orderOfSections(planes)) {
    result.planes.push_back(planes[n]);
    for (size_t g = 0; g < result.grids.size(); ++g)
      result.grids[g].slices.push_back(std::move((*layers[n])[g]));
  }
  return result;
}

}  // namespace slicemorph
