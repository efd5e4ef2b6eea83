#pragma once

#include "io/image/dicom_reader.h"
#include "io/image/itk_reader.h"

namespace slicemorph {

/// The readers that need ITK and GDCM, as `libslicemorph_itk.so` offers them: these two cost a program's
/// start as much as all other libraries together, so only that library links them.
struct ItkReaders {
  decltype(&readNrrd) nrrd;
  decltype(&readMetaImage) metaImage;
  decltype(&scanDicomFolder) dicomFolder;
  decltype(&chooseDicomSeries) chooseSeries;
  decltype(&readDicomSeries) dicomSeries;
};

/// Loads the library, once. Throws IoError where it is not there.
const ItkReaders& itkReaders();

}  // namespace slicemorph

/// What the library exports.
extern "C" const slicemorph::ItkReaders* slicemorphItkReaders();
