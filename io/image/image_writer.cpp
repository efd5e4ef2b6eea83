#include "slicemorph/io/image_writer.h"

#include "io/atomic_file.h"
#include "io/format.h"
#include "io/image/image_formats.h"
#include "io/image/raw_values.h"
#include "io/paths.h"
#include "slicemorph/errors.h"

#include <zlib.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <utility>

namespace slicemorph {
namespace {

/// zlib's level, 1 to 9. Measured: slower levels hardly compress CT noise better, and a label map takes twice
/// as long from level 4 on.
constexpr int kLevel = 3;

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "values are written as they lie in memory");

}  // namespace

/// Compresses parts into one stream.
class Packer {
 public:
  Packer(AtomicFile& file, Packing packing) : file_(file), out_(1 << 18) {
    const int window = packing == Packing::kGzip ? 31 : 15;
    if (deflateInit2(&stream_, kLevel, Z_DEFLATED, window, 9, Z_DEFAULT_STRATEGY) != Z_OK)
      throw std::bad_alloc();
  }
  ~Packer() { deflateEnd(&stream_); }

  void add(std::string_view bytes) { run(bytes, Z_NO_FLUSH); }
  void finish() { run({}, Z_FINISH); }
  /// Of all that was written, compressed.
  std::uint64_t bytes() const { return stream_.total_out; }

 private:
  void run(std::string_view bytes, int flush) {
    while (true) {
      const size_t part = std::min<size_t>(bytes.size(), 1u << 30);
      stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
      stream_.avail_in = uInt(part);
      do {
        stream_.next_out = reinterpret_cast<Bytef*>(out_.data());
        stream_.avail_out = uInt(out_.size());
        deflate(&stream_, flush);
        file_.write({out_.data(), out_.size() - stream_.avail_out});
      } while (stream_.avail_out == 0);
      bytes.remove_prefix(part);
      if (bytes.empty()) return;
    }
  }

  AtomicFile& file_;
  std::vector<char> out_;
  z_stream stream_ = {};
};

/// A head, followed by values.
class VoxelFile {
 public:
  VoxelFile(const std::string& path, const VoxelHead& head) : file_(path), sizeAt_(head.sizeAt) {
    if (head.packing != Packing::kNone && !head.packed) file_.write(head.bytes);
    if (head.packing != Packing::kNone) packer_.emplace(file_, head.packing);
    if (head.packing == Packing::kNone || head.packed) add(head.bytes);
  }
  void add(std::string_view bytes) { packer_ ? packer_->add(bytes) : file_.write(bytes); }
  void commit() {
    if (packer_) packer_->finish();
    if (sizeAt_) {
      std::string digits = std::to_string(packer_->bytes());
      digits.resize(VoxelHead::kSizeDigits, ' ');
      file_.overwrite(*sizeAt_, digits);
    }
    file_.commit();
  }

 private:
  AtomicFile file_;
  std::optional<Packer> packer_;
  std::optional<size_t> sizeAt_;
};

namespace {

std::string numberText(double value) {
  char digits[32];
  return {digits, std::to_chars(digits, digits + sizeof digits, value).ptr};
}

std::string numbersText(const Vec3d& v, const char* between) {
  return numberText(v[0]) + between + numberText(v[1]) + between + numberText(v[2]);
}

struct TypeNames {
  const char *nrrd, *meta;
};
TypeNames namesOf(size_t type) {
  constexpr TypeNames kNames[] = {{"uint8", "MET_UCHAR"}, {"int16", "MET_SHORT"}, {"uint16", "MET_USHORT"},
                                  {"int32", "MET_INT"},   {"float", "MET_FLOAT"}, {"double", "MET_DOUBLE"}};
  static_assert(std::size(kNames) == std::variant_size_v<ImageValues>);
  return kNames[type];
}

/// `numbers`: of a voxel; `kind`: what these are, with a blank behind it, nothing of one number.
std::string nrrdText(const Voxels& voxels, int numbers, const std::string& kind, const std::string& keys) {
  const ImageLattice& l = voxels.lattice;
  const bool vectors = numbers > 1, times = voxels.volumes > 1;
  std::string text = "NRRD0004\n# written by slicemorph\n";
  if (!voxels.meaning.empty()) text += "content: " + voxels.meaning + "\n";
  text +=
      "type: " + std::string(namesOf(voxels.type).nrrd) + "\ndimension: " + (vectors || times ? "4" : "3") +
      "\nspace: left-posterior-superior\nsizes: " + (vectors ? std::to_string(numbers) + " " : "") +
      std::to_string(l.size[0]) + " " + std::to_string(l.size[1]) + " " + std::to_string(l.size[2]) +
      (times ? " " + std::to_string(voxels.volumes) : "") + "\nspace directions:" + (vectors ? " none" : "");
  for (const Vec3d& s : l.step) text += " (" + numbersText(s, ",") + ")";
  text += times ? " none" : "";
  const double step = voxels.header.timeStep;
  if (times && step > 0) {
    text += "\nspacings: nan nan nan " + numberText(step);
    if (voxels.header.inSeconds) text += "\nunits: \"\" \"\" \"\" \"s\"";
  }
  return text + "\nkinds: " + kind + "domain domain domain" + (times ? " time" : "") +
         "\nendian: little\nencoding: gzip\nspace origin: (" + numbersText(l.origin, ",") + ")\n" + keys +
         "\n";
}

/// Without it ITK reads zeros.
constexpr const char* kPackedSize = "CompressedDataSize = ";

std::string metaImageText(const Voxels& voxels) {
  const ImageLattice& l = voxels.lattice;
  const Vec3d spacing = l.spacing();
  const bool times = voxels.volumes > 1;
  const double step = voxels.header.timeStep;
  const std::string zero = times ? " 0" : "";
  std::string text = std::string("ObjectType = Image\nNDims = ") + (times ? "4" : "3") + "\n";
  if (!voxels.meaning.empty()) text += "Comment = " + voxels.meaning + "\n";
  text += "BinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = True\n" +
          std::string(kPackedSize) + std::string(VoxelHead::kSizeDigits, ' ') + "\nTransformMatrix =";
  for (int d = 0; d < 3; ++d) text += " " + numbersText(l.step[d] / spacing[d], " ") + zero;
  return text + (times ? " 0 0 0 1" : "") + "\nOffset = " + numbersText(l.origin, " ") + zero +
         "\nCenterOfRotation = 0 0 0" + zero + "\nElementSpacing = " + numbersText(spacing, " ") +
         (times ? " " + numberText(step > 0 ? step : 1) : "") + "\nDimSize = " + std::to_string(l.size[0]) +
         " " + std::to_string(l.size[1]) + " " + std::to_string(l.size[2]) +
         (times ? " " + std::to_string(voxels.volumes) : "") +
         (voxels.vectors ? "\nElementNumberOfChannels = 3" : "") +
         "\nElementType = " + namesOf(voxels.type).meta + "\nElementDataFile = LOCAL\n";
}

Voxels voxelsOf(const ImageLattice& lattice, const ImageValues& like, int volumes = 1,
                const ImageHeader& header = {}) {
  return {lattice, like.index(), size_t(rawTypeOf(like).bytes), false, {}, volumes, header};
}

Voxels voxelsOf(const VectorImage& image) {
  return {
      image.lattice, ImageValues(std::vector<float>()).index(), sizeof(float), true, image.meaning, 1, {}};
}

/// All first components, then all second and third ones, as NIfTI has them; interleaved for the others.
std::vector<float> numbersOf(const VectorImage& image, bool interleaved) {
  const size_t n = image.vectors.size();
  std::vector<float> numbers(3 * n);
  for (size_t i = 0; i < n; ++i)
    for (size_t d = 0; d < 3; ++d) numbers[interleaved ? 3 * i + d : d * n + i] = image.vectors[i][int(d)];
  return numbers;
}

std::string_view bytesOf(const ImageValues& values) {
  return std::visit(
      [](const auto& v) {
        return std::string_view(reinterpret_cast<const char*>(v.data()), v.size() * sizeof(v[0]));
      },
      values);
}

VoxelHeader headerOf(const std::string& path) {
  const Format* format = formatToWrite(path);
  if (!format || !format->voxelHead)
    throw InputError(path, "cannot write an image of this extension; use " + writableList(Contents::kImage));
  return format->voxelHead;
}

}  // namespace

bool isImageOutput(const std::string& path) {
  const Format* format = formatToWrite(path);
  return format && format->contents == Contents::kImage;
}

VoxelHead nrrdHead(const std::string&, const Voxels& voxels) {
  return {nrrdText(voxels, voxels.vectors ? 3 : 1, voxels.vectors ? "vector " : "", ""), Packing::kGzip,
          false, true};
}

VoxelHead nrrdLabelsHead(const ImageLattice& lattice, int layers, bool wide, const std::string& keys) {
  const ImageValues like =
      wide ? ImageValues(std::vector<std::uint16_t>()) : ImageValues(std::vector<std::uint8_t>());
  return {nrrdText(voxelsOf(lattice, like), layers, layers > 1 ? "list " : "", keys), Packing::kGzip, false,
          true};
}

void writeVoxels(const std::string& path, const VoxelHead& head, std::string_view values) {
  VoxelFile file(path, head);
  file.add(values);
  file.commit();
}

VoxelHead metaImageHead(const std::string&, const Voxels& voxels) {
  VoxelHead head{metaImageText(voxels), Packing::kZlib, false, true};
  head.sizeAt = head.bytes.find(kPackedSize) + std::strlen(kPackedSize);
  return head;
}

ImageSliceWriter::ImageSliceWriter(const std::string& path, const ImageLattice& lattice,
                                   const ImageValues& like, int volumes, const ImageHeader& header) {
  file_ = std::make_unique<VoxelFile>(path, headerOf(path)(path, voxelsOf(lattice, like, volumes, header)));
  type_ = like.index(), left_ = lattice.count() * size_t(volumes);
}

ImageSliceWriter::~ImageSliceWriter() = default;

void ImageSliceWriter::add(const ImageValues& slices) {
  const size_t count = std::visit([](const auto& values) { return values.size(); }, slices);
  if (slices.index() != type_ || count > left_)
    throw std::logic_error("slices of another type, or more than the image has");
  left_ -= count;
  file_->add(bytesOf(slices));
}

void ImageSliceWriter::commit() {
  if (left_ > 0) throw std::logic_error("fewer slices than the image has");
  file_->commit();
}

void writeImage(const std::string& path, const Image& image, const ImageHeader& header) {
  ImageSliceWriter writer(path, image.lattice, image.values, 1, header);
  writer.add(image.values);
  writer.commit();
}

void writeVectors(const std::string& path, const VectorImage& image) {
  const VoxelHead head = headerOf(path)(path, voxelsOf(image));
  VoxelFile file(path, head);
  file.add(bytesOf(numbersOf(image, head.interleaved)));
  file.commit();
}

}  // namespace slicemorph
