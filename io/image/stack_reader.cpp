#include "io/image/stack_reader.h"

#include "io/exr/exr_check.h"
#include "io/image/load_library.h"
#include "io/image/picture_plugin.h"
#include "io/image/raw_values.h"
#include "io/paths.h"
#include "io/sequence.h"
#include "slicemorph/errors.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <cstdlib>
#include <memory>
#include <optional>
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

std::vector<Page> pagesOf(const InputSpec& input, const std::vector<SequenceFile>& files,
                          SlicemorphReadPicture read) {
  std::vector<Page> pages;
  if (input.isSequence) {
    for (const SequenceFile& file : files) pages.push_back({file.path, 0});
  } else {
    sizeOfInput(input.path);
    const int count = readPage(read, {input.path, 0}, false).about.pages;
    for (int i = 0; i < count; ++i) pages.push_back({input.path, i});
  }
  return pages;
}

/// ITU-R BT.709 weights; pictures of one or two channels are grey (and alpha).
template <typename T>
double luminance(const T* pixel, int channels) {
  return channels < 3 ? double(pixel[0]) : 0.2126 * pixel[0] + 0.7152 * pixel[1] + 0.0722 * pixel[2];
}

/// Writes a page's values. Throws IoError where it is not of the size and type of `first`, the first page.
template <typename T>
void readValuesOf(const Page& page, SlicemorphReadPicture read, const Page& firstPage,
                  const SlicemorphPicture& first, T* to) {
  const StackPicture picture = readPage(read, page, true);
  const SlicemorphPicture& p = picture.about;
  if (p.width != first.width || p.height != first.height || p.bytes != first.bytes || p.kind != first.kind ||
      p.channels != first.channels)
    throw IoError(page.file, "is " + std::to_string(p.width) + " x " + std::to_string(p.height) +
                                 " pixels of " + std::to_string(p.channels) + " x " +
                                 std::to_string(8 * p.bytes) + " bits; " + firstPage.file + " is " +
                                 std::to_string(first.width) + " x " + std::to_string(first.height) + " of " +
                                 std::to_string(first.channels) + " x " + std::to_string(8 * first.bytes));
  const T* from = static_cast<const T*>(p.values);
  for (size_t i = 0; i < size_t(first.width) * size_t(first.height); ++i) {
    const double v = luminance(from + i * size_t(p.channels), p.channels);
    to[i] = std::is_integral_v<T> ? T(std::lrint(v)) : T(v);
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

/// `count` values of the type that pages are stored in.
ImageValues emptyValues(const SlicemorphPicture& first, size_t count) {
  if (first.kind == 2) return std::vector<float>(count);
  if (first.bytes == 1) return std::vector<std::uint8_t>(count);
  if (first.kind == 1) return std::vector<std::int16_t>(count);
  return std::vector<std::uint16_t>(count);
}

/// The values of pages `begin` to `end` - 1.
ImageValues valuesOf(const std::vector<Page>& pages, size_t begin, size_t end, SlicemorphReadPicture read,
                     const SlicemorphPicture& first) {
  const size_t each = size_t(first.width) * size_t(first.height);
  ImageValues values = emptyValues(first, each * (end - begin));
  std::visit(
      [&](auto& to) {
        tbb::parallel_for(begin, end, [&](size_t k) {
          readValuesOf(pages[k], read, pages[0], first, &to[(k - begin) * each]);
        });
      },
      values);
  return values;
}

/// A stack of which the first page's header was read.
struct OpenStack {
  ImageFile file;
  std::vector<Page> pages;
  SlicemorphPicture first;
};

OpenStack openedStack(const InputSpec& input, const ImageOptions& options, bool values,
                      SlicemorphReadPicture read) {
  if (!input.selection.empty())
    throw InputError(input.text, "a stack of pictures is one volume; nothing can be chosen of it");
  const std::vector<SequenceFile> files =
      input.isSequence ? findSequence(input.path, input.range) : std::vector<SequenceFile>();
  checkNumbers(input.path, files);
  for (const SequenceFile& file : files)
    if (extensionOf(file.path) == ".exr") checkExrHeader(file.path);
  OpenStack stack;
  stack.pages = pagesOf(input, files, read);
  const Vec3d& s = options.spacing;
  if (values && !(s[0] > 0 && s[1] > 0 && s[2] > 0))
    throw InputError(input.path,
                     "pictures hold no spacing; give --spacing X,Y,Z in millimetres (pixel width, pixel "
                     "height, gap between pictures)");
  const SlicemorphPicture& first = stack.first = readPage(read, stack.pages[0], false).about;
  stack.file.format = "image stack";
  ImageLattice& lattice = stack.file.image.lattice;
  lattice.size = openvdb::Coord(first.width, first.height, int(stack.pages.size()));
  for (int d = 0; d < 3; ++d) {
    lattice.step[d] = Vec3d(0.0);
    lattice.step[d][d] = s[d] > 0 ? s[d] : 1;
  }
  if (first.channels > 2)
    stack.file.notes.emplace_back("image.colours-as-luminance", Severity::kNote, "",
                                  "colours are taken as luminance");
  return stack;
}

}  // namespace

ImageFile readStack(const InputSpec& input, const ImageOptions& options, bool values) {
  const SlicemorphReadPicture read = loadPlugin();
  OpenStack stack = openedStack(input, options, values, read);
  if (!values) return std::move(stack.file);
  // One page more for each thread that reads.
  const SlicemorphPicture& first = stack.first;
  const double count = double(stack.pages.size()), page = double(first.width) * first.height * first.bytes,
               all = page * (count + double(first.channels) * std::min(count, double(kReadAtOnce)));
  options.memory.require(all, input.text,
                         std::to_string(stack.pages.size()) + " pictures of " + std::to_string(first.width) +
                             " x " + std::to_string(first.height),
                         "take fewer or smaller ones");
  stack.file.image.values = valuesOf(stack.pages, 0, stack.pages.size(), read, first);
  return std::move(stack.file);
}

std::optional<ImageSlices> openStack(const InputSpec& input, const ImageOptions& options) {
  const SlicemorphReadPicture read = loadPlugin();
  auto stack = std::make_shared<OpenStack>(openedStack(input, options, true, read));
  ImageFile file = stack->file;
  file.image.values = emptyValues(stack->first, 0);
  return ImageSlices{std::move(file), size_t(stack->first.bytes), [stack, read, next = size_t(0)]() mutable {
                       ++next;
                       return valuesOf(stack->pages, next - 1, next, read, stack->first);
                     }};
}

}  // namespace slicemorph
