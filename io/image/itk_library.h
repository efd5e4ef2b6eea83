#pragma once

#include "io/image/dicom_reader.h"
#include "io/image/metaimage_reader.h"
#include "io/image/nrrd_reader.h"
#include "io/structures/structure_data.h"

namespace slicemorph {

/// The readers, and writers, that need ITK and GDCM. Loading these two takes as long as all other libraries together when a
/// program starts, so only the plug-in `libslicemorph_itk.so` links them.
struct ItkReaders {
  decltype(&readNrrd) nrrd;
  decltype(&readMetaImage) metaImage;
  decltype(&openNrrd) nrrdSlices;
  decltype(&openMetaImage) metaImageSlices;
  decltype(&scanDicom) dicomFolder;
  decltype(&holdsDicomVolumes) dicomHoldsVolumes;
  decltype(&chooseDicomVolume) chooseVolume;
  decltype(&readDicomVolume) dicomVolume;
  decltype(&readDicomHead) dicomHead;
  decltype(&segmentationFile) segmentation;
  decltype(&structureSetFile) structureSet;
};

/// Loads the plug-in, once. Throws IoError where it is missing.
const ItkReaders& itkReaders();

}  // namespace slicemorph

/// The function that the plug-in exports.
extern "C" const slicemorph::ItkReaders* slicemorphItkReaders();
