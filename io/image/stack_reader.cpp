#include "io/image/stack_reader.h"

#include "io/exr/exr_check.h"
#include "io/image/chosen_volume.h"
#include "io/image/image_formats.h"
#include "io/image/length_unit.h"
#include "io/image/load_library.h"
#include "io/image/picture_plugin.h"
#include "io/image/raw_values.h"
#include "io/paths.h"
#include "io/sequence.h"
#include "slicemorph/errors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <optional>
#include <sstream>
#include <utility>

namespace slicemorph {
namespace {

SlicemorphReadPicture loadPlugin() {
  static const auto function = reinterpret_cast<SlicemorphReadPicture>(
      functionOfPlugin("libslicemorph_pictures.so", "slicemorphReadPicture", "pictures"));
  return function;
}

/// Pages that are in memory at once, beside the stack, at most: one a thread; of the usual number of these.
constexpr int kReadAtOnce = 8;

struct FreeValues {
  void operator()(void* values) const { std::free(values); }
};

struct Page {
  std::string file;
  int page = 0;
};

struct StackPicture {
  SlicemorphPicture about;
  std::unique_ptr<void, FreeValues> values;
};

StackPicture readPage(SlicemorphReadPicture read, const Page& page, bool values) {
  StackPicture picture{};
  if (const char* problem = read(page.file.c_str(), page.page, values, &picture.about))
    throw IoError(page.file, std::string("cannot be read: ") + problem);
  picture.values.reset(picture.about.values);
  return picture;
}

/// ITU-R BT.709 weights.
template <typename T>
double luminance(const T* pixel) {
  return 0.2126 * double(pixel[0]) + 0.7152 * double(pixel[1]) + 0.0722 * double(pixel[2]);
}

std::string describePage(const SlicemorphPicture& p) {
  const char* const kinds[] = {"whole number", "signed whole number", "floating point"};
  return std::to_string(p.width) + " x " + std::to_string(p.height) + " pixels of " +
         std::to_string(p.channels) + " x " + std::to_string(p.kind == 2 ? 8 * p.bytes : p.bits) + " bits (" +
         kinds[p.kind] + ")";
}

/// Writes a page's values. Throws IoError where it is not of the size and type of `first`, the first page.
template <typename T>
void readValuesOf(const Page& page, SlicemorphReadPicture read, const Page& firstPage,
                  const SlicemorphPicture& first, T* to) {
  const StackPicture picture = readPage(read, page, true);
  const SlicemorphPicture& p = picture.about;
  if (p.width != first.width || p.height != first.height || p.bytes != first.bytes || p.kind != first.kind ||
      p.bits != first.bits || p.channels != first.channels || p.whiteIsZero != first.whiteIsZero)
    throw IoError(page.file, "is " + describePage(p) + "; " + firstPage.file + " is " + describePage(first));
  const T* from = static_cast<const T*>(p.values);
  for (size_t i = 0; i < size_t(first.width) * size_t(first.height); ++i) {
    const T* pixel = from + i * size_t(p.channels);
    if (p.channels < 3)  // grey, and alpha
      to[i] = pixel[0];
    else if constexpr (std::is_integral_v<T>)
      to[i] = T(std::llrint(luminance(pixel)));
    else
      to[i] = T(luminance(pixel));
  }
}

void checkNumbers(const std::string& path, const std::vector<SequenceFile>& files) {
  int missing = 0;
  std::string first;
  for (size_t i = 1; i < files.size(); ++i)
    if (const int gap = files[i].number - files[i - 1].number - 1; gap > 0) {
      if (missing == 0) first = std::to_string(files[i - 1].number + 1);
      missing += gap;
    }
  if (missing > 0)
    throw IoError(path, std::to_string(missing) + " pictures are missing (the first is number " + first +
                            "); without them the spacing would be wrong");
}

RawType typeOfPages(const SlicemorphPicture& first) {
  return {first.bytes, first.kind == 2   ? RawType::kFloat
                       : first.kind == 1 ? RawType::kSigned
                                         : RawType::kUnsigned};
}

/// The values of pages `begin` to `end` - 1.
ImageValues valuesOf(const std::vector<Page>& pages, size_t begin, size_t end, SlicemorphReadPicture read,
                     const SlicemorphPicture& first) {
  const size_t each = size_t(first.width) * size_t(first.height);
  const auto readAs = [&](auto* to) {
    tbb::parallel_for(begin, end, [&](size_t k) {
      readValuesOf(pages[k], read, pages[0], first, to + (k - begin) * each);
    });
  };
  const RawType type = typeOfPages(first);
  return readValues(type, each * (end - begin), [&](void* to) {
    const bool negative = type.kind == RawType::kSigned;
    if (type.kind == RawType::kFloat)
      return type.bytes == 8 ? readAs(static_cast<double*>(to)) : readAs(static_cast<float*>(to));
    switch (type.bytes) {
      case 1:
        return negative ? readAs(static_cast<std::int8_t*>(to)) : readAs(static_cast<std::uint8_t*>(to));
      case 2:
        return negative ? readAs(static_cast<std::int16_t*>(to)) : readAs(static_cast<std::uint16_t*>(to));
      default:
        return negative ? readAs(static_cast<std::int32_t*>(to)) : readAs(static_cast<std::uint32_t*>(to));
    }
  });
}

/// A stack of which the first page's header was read.
struct OpenStack {
  ImageFile file;
  std::vector<Page> pages;
  SlicemorphPicture first;
  bool placed = false;  ///< its spacing is known
};

void noteStack(OpenStack& stack, const char* code, const std::string& text,
               Severity severity = Severity::kNote) {
  stack.file.notes.emplace_back(code, severity, "", text);
}

/// The pages of a file of several, of one volume where its description tells of channels and times.
void choosePages(const InputSpec& input, int volume, OpenStack& stack) {
  const SlicemorphPages& layout = stack.first.layout;
  const bool told = layout.slices > 0;  // and no more pages than can be numbered
  const int slices = told ? layout.slices : stack.first.pages;
  const int channels = told ? layout.channels : 1, times = told ? layout.times : 1;
  stack.file.volumes = channels * times;
  checkVolume(input.path, volume, stack.file.volumes);
  if (volume == kNoVolume)
    noteFirstVolume(input.path,
                    std::string(channels > 1 ? "channel" : "") + (channels > 1 && times > 1 ? ", " : "") +
                        (times > 1 ? "time" : ""),
                    stack.file);
  const int chosen = std::max(volume, 0), channel = chosen % channels, time = chosen / channels;
  const int stride = told ? std::max(1, layout.sliceStride) : 1,
            from = told ? channel * layout.channelStride + time * layout.timeStride : 0;
  for (int z = 0; z < slices; ++z) stack.pages.push_back({input.path, from + z * stride});
}

/// Sets spacing and origin: those that are given, else those that a file of several pages tells.
void placeStack(const InputSpec& input, const ImageOptions& options, OpenStack& stack) {
  const SlicemorphPages& layout = stack.first.layout;
  ImageLattice& lattice = stack.file.image.lattice;
  Vec3d spacing = options.spacing;
  const auto known = [&] { return spacing[0] > 0 && spacing[1] > 0 && spacing[2] > 0; };
  const std::optional<double> unit = millimetresOf(layout.unit);
  if (!known() && !input.isSequence && layout.unit[0] && unit) {
    spacing = Vec3d(layout.spacing[0], layout.spacing[1], layout.spacing[2]) * *unit;
    if (known()) {
      std::ostringstream text;
      text << "its spacing is " << spacing[0] << " x " << spacing[1] << " x " << spacing[2]
           << " mm, as its description (" << layout.program << ", in " << layout.unit
           << ") says (--spacing sets another)";
      noteStack(stack, "image.spacing-found", text.str());
    }
  }
  if (!known() && options.force) {
    spacing = Vec3d(1.0);
    noteStack(stack, kGeometryForced,
              "--force: pictures hold no spacing: it is taken as 1 x 1 x 1 mm, so that no length is right",
              Severity::kWarning);
  }
  stack.placed = known();
  for (int d = 0; d < 3; ++d) {
    lattice.step[d] = Vec3d(0.0);
    lattice.step[d][d] = spacing[d] > 0 ? spacing[d] : 1;
    lattice.origin[d] = input.isSequence ? 0.0 : layout.origin[d] * lattice.step[d][d] + 0.0;
  }
}

void noteWhatPagesAre(OpenStack& stack) {
  const SlicemorphPicture& first = stack.first;
  if (first.channels > 2) noteStack(stack, "image.colours-as-luminance", "colours are taken as luminance");
  if (first.whiteIsZero)
    noteStack(stack, "image.white-is-zero", "it says that 0 is shown white: values are taken as stored");
  if (first.cut)
    noteStack(stack, "image.pixels-outside", "pixels outside the display window were left out",
              Severity::kWarning);
}

OpenStack openedStack(const InputSpec& input, const ImageOptions& options, SlicemorphReadPicture read) {
  const int volume = volumeOf(input);
  const std::vector<SequenceFile> files =
      input.isSequence ? findSequence(input.path, input.range) : std::vector<SequenceFile>();
  if (input.isSequence && volume != kNoVolume)
    throw InputError(input.text, "a stack of pictures is one volume; nothing can be chosen of it");
  checkNumbers(input.path, files);
  for (const SequenceFile& file : files)
    if (extensionOf(file.path) == ".exr") checkExrHeader(file.path);
  OpenStack stack;
  for (const SequenceFile& file : files) stack.pages.push_back({file.path, 0});
  if (files.empty()) sizeOfInput(input.path);
  stack.first = readPage(read, files.empty() ? Page{input.path, 0} : stack.pages[0], false).about;
  stack.file.format = "image stack";
  if (files.empty())
    choosePages(input, volume, stack);
  else if (stack.first.pages > 1)
    noteStack(stack, "image.first-page",
              "has " + std::to_string(stack.first.pages) + " pages: of each file the first is taken",
              Severity::kWarning);
  stack.file.image.lattice.size =
      openvdb::Coord(stack.first.width, stack.first.height, int(stack.pages.size()));
  placeStack(input, options, stack);
  checkPlace(input.path, options.force, stack.file);
  noteWhatPagesAre(stack);
  return stack;
}

void requirePlace(const InputSpec& input, const OpenStack& stack) {
  if (!stack.placed)
    throw InputError(input.path,
                     "pictures hold no spacing; give --spacing X,Y,Z in millimetres (pixel width, pixel "
                     "height, gap between pictures), or --force to take 1 mm for each");
}

}  // namespace

ImageFile readStack(const InputSpec& input, const ImageOptions& options, bool placed) {
  const SlicemorphReadPicture read = loadPlugin();
  OpenStack stack = openedStack(input, options, read);
  if (!stack.placed && !placed) {
    stack.file.image.values = noValues(typeOfPages(stack.first));
    return std::move(stack.file);
  }
  requirePlace(input, stack);
  // One page more for each thread that reads.
  const SlicemorphPicture& first = stack.first;
  const double count = double(stack.pages.size()), pixels = double(first.width) * first.height,
               all = pixels * (count * double(bytesWhileRead(typeOfPages(first))) +
                               first.bytes * double(first.channels) * std::min(count, double(kReadAtOnce)));
  options.memory.require(all, input.text,
                         std::to_string(stack.pages.size()) + " pictures of " + std::to_string(first.width) +
                             " x " + std::to_string(first.height),
                         "take fewer or smaller ones");
  stack.file.image.values = valuesOf(stack.pages, 0, stack.pages.size(), read, first);
  return std::move(stack.file);
}

std::optional<ImageSlices> openStack(const InputSpec& input, const ImageOptions& options) {
  const SlicemorphReadPicture read = loadPlugin();
  auto stack = std::make_shared<OpenStack>(openedStack(input, options, read));
  if (!stack->placed) return std::nullopt;
  ImageFile file = stack->file;
  const RawType type = typeOfPages(stack->first);
  file.image.values = noValues(type);
  const size_t kind = file.image.values.index();
  return ImageSlices{std::move(file), bytesWhileRead(type), [=, next = size_t(0)]() mutable {
                       ++next;
                       ImageValues values = valuesOf(stack->pages, next - 1, next, read, stack->first);
                       if (values.index() != kind) refuseWideSlices(stack->pages[next - 1].file);
                       return values;
                     }};
}

}  // namespace slicemorph
