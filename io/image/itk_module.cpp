#include "io/image/itk_library.h"

const slicemorph::ItkReaders* slicemorphItkReaders() {
  using namespace slicemorph;
  static const ItkReaders readers{readNrrd,        readMetaImage,    openNrrd,
                                  openMetaImage,   scanDicomFolder,  chooseDicomSeries,
                                  readDicomSeries, segmentationFile, structureSetFile};
  return &readers;
}
