#include "io/image/itk_library.h"

#include "io/image/load_library.h"

namespace slicemorph {

const ItkReaders& itkReaders() {
  static const ItkReaders& readers = *reinterpret_cast<decltype(&slicemorphItkReaders)>(
      functionOfPlugin("libslicemorph_itk.so", "slicemorphItkReaders", "this image"))();
  return readers;
}

}  // namespace slicemorph
