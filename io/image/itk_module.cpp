#include "io/image/itk_library.h"

const slicemorph::ItkReaders* slicemorphItkReaders() {
  using namespace slicemorph;
  static const ItkReaders readers{readNrrd,      readMetaImage,     openNrrd,          openMetaImage,
                                  scanDicom,     holdsDicomVolumes, chooseDicomVolume, readDicomVolume,
                                  readDicomHead, segmentationFile,  structureSetFile};
  return &readers;
}
