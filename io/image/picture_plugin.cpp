#include "io/image/picture_plugin.h"

#include <OpenImageIO/imageio.h>

#include <cstdlib>
#include <string>

const char* slicemorphReadPicture(const char* path, int page, int values, SlicemorphPicture* picture) {
  thread_local std::string problem;
  using namespace OIIO;
  const auto fail = [&](const std::string& what) {
    problem = what;
    return problem.c_str();
  };
  const auto input = ImageInput::open(path);
  if (!input) return fail(geterror());
  int pages = 1;
  while (input->seek_subimage(pages, 0)) ++pages;
  input->geterror();
  if (!input->seek_subimage(page, 0)) return fail("it has " + std::to_string(pages) + " pages");
  const ImageSpec& spec = input->spec();
  TypeDesc type = spec.format;
  const bool isFloat = type.is_floating_point();
  if (isFloat || type.basesize() > 2) type = TypeDesc::FLOAT;
  if (spec.width < 1 || spec.height < 1 || spec.nchannels < 1) return fail("it has no pixels");
  *picture = {spec.width,
              spec.height,
              spec.nchannels,
              int(type.basesize()),
              isFloat || type == TypeDesc::FLOAT ? 2 : int(type.is_signed()),
              pages,
              nullptr};
  if (!values) return nullptr;
  const size_t bytes = size_t(spec.width) * size_t(spec.height) * size_t(spec.nchannels) * type.basesize();
  picture->values = std::malloc(bytes);
  if (!picture->values) return fail("out of memory");
  if (!input->read_image(page, 0, 0, spec.nchannels, type, picture->values)) {
    std::free(picture->values);
    picture->values = nullptr;
    return fail(input->geterror());
  }
  return nullptr;
}
