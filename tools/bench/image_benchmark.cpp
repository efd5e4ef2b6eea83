/// Reading a DICOM series and making an in-between of two grey images, against ITK's reader and ITK's
/// trilinear resampling in the same run. Usage: slicemorph_image_benchmark DICOM_FOLDER [ISO]
#include "slicemorph/io/image_file.h"
#include "slicemorph/io/input.h"
#include "slicemorph/slicemorph.h"

#include <itkAffineTransform.h>
#include <itkGDCMImageIO.h>
#include <itkGDCMSeriesFileNames.h>
#include <itkImage.h>
#include <itkImageSeriesReader.h>
#include <itkLinearInterpolateImageFunction.h>
#include <itkResampleImageFilter.h>

#include <sys/resource.h>

#include <chrono>
#include <cstdio>
#include <functional>

namespace {

using namespace slicemorph;
using ItkImage = itk::Image<short, 3>;

double seconds(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double peakMiB() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  return double(usage.ru_maxrss) / 1024;
}

ItkImage::Pointer readWithItk(const std::string& folder) {
  const auto names = itk::GDCMSeriesFileNames::New();
  names->SetUseSeriesDetails(false);
  names->SetDirectory(folder);
  const auto reader = itk::ImageSeriesReader<ItkImage>::New();
  reader->SetImageIO(itk::GDCMImageIO::New());
  reader->SetFileNames(names->GetFileNames(names->GetSeriesUIDs().at(0)));
  reader->Update();
  return reader->GetOutput();
}

ItkImage::Pointer resampleWithItk(const ItkImage* image) {
  const auto transform = itk::AffineTransform<double, 3>::New();
  itk::Vector<double, 3> shift;
  shift.Fill(0.37);
  transform->Translate(shift);
  const auto filter = itk::ResampleImageFilter<ItkImage, ItkImage>::New();
  filter->SetInput(image);
  filter->SetTransform(transform);
  filter->SetInterpolator(itk::LinearInterpolateImageFunction<ItkImage>::New());
  filter->SetOutputParametersFromImage(image);
  filter->Update();
  return filter->GetOutput();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: slicemorph_image_benchmark DICOM_FOLDER [ISO]\n");
    return 2;
  }
  openvdb::initialize();
  const std::string folder = argv[1];
  LoadOptions options;
  options.iso = argc > 2 ? std::atof(argv[2]) : 300;
  ImageFile file;
  // The better of two runs each: from the first reading on the files are in the system's cache.
  double own = 1e30, itks = 1e30;
  ItkImage::Pointer theirs;
  for (int i = 0; i < 2; ++i) {
    itks = std::min(itks, seconds([&] { theirs = readWithItk(folder); }));
    file = ImageFile();
    own = std::min(own, seconds([&] { file = readImage(folder); }));
  }
  const openvdb::Coord n = file.image.lattice.size;
  std::printf("read %d x %d x %d: slicemorph %.2f s, ITK %.2f s, ratio %.2f (limit 1.5)\n", n[0], n[1], n[2],
              own, itks, own / itks);
  const double resample = seconds([&] { resampleWithItk(theirs); });
  theirs = nullptr;
  file = ImageFile();

  LoadedObject a = loadObject(folder, options);
  // The second image is the first one moved, with slices further apart.
  auto moved = std::make_shared<Image>(*a.image);
  moved->lattice.origin += Vec3d(3, -2, 5);
  moved->lattice.step[2] *= 1.03;
  LoadedObject b = a;
  b.image = moved;
  const FloatGrid::Ptr shape = a.object.levelSet->deepCopy();
  shape->transform().postTranslate(Vec3d(3, -2, 5));
  b.object.levelSet = shape;
  MorphOptions planOptions;
  planOptions.align = Align::kNone;
  const double planned = seconds([&] { MorphPlan plan({a.object, b.object}, planOptions); });
  const MorphPlan plan({a.object, b.object}, planOptions);
  Image frame;
  const double made = seconds([&] {
    frame = plan.pullback({0.5, 0.5})
                .carry(std::vector<const Image*>{a.image.get(), b.image.get()}, a.image->lattice);
  });
  std::printf("grey frame: %.2f s, one trilinear resample by ITK %.2f s, ratio %.2f (limit 2); plan %.1f s\n",
              made, resample, made / resample, planned);
  const double copy = double(frame.lattice.count()) * 2 / 1024 / 1024;
  std::printf("peak memory %.0f MiB: %.1f copies of the volume as int16 (%.0f MiB)\n", peakMiB(),
              peakMiB() / copy, copy);
  return 0;
}
