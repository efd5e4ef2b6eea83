#include "io/image/itk_library.h"

#include "io/image/load_library.h"

namespace slicemorph {

const ItkReaders& itkReaders() {
  static const ItkReaders& readers = *reinterpret_cast<decltype(&slicemorphItkReaders)>(
      functionOf("libslicemorph_itk.so", "SLICEMORPH_ITK", "slicemorphItkReaders", "this image"))();
  return readers;
}

}  // namespace slicemorph
