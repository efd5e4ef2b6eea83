#include "slicemorph/io/image_slices.h"
#include "io/scratch_folder.h"
#include "io/whole_file.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/image_writer.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>

namespace slicemorph {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kExtensions{".nii", ".nii.gz", ".nrrd", ".mha"};

class Slices : public ::testing::Test {
 protected:
  std::string at(const std::string& name) const { return folder_.file(name); }
  std::string write(const std::string& name, const std::string& bytes) const {
    std::ofstream(at(name), std::ios::binary) << bytes;
    return at(name);
  }

  ScratchFolder folder_;
};

/// An oblique image of runs of numbers, larger than the window of its compression.
template <typename T>
Image runs() {
  Image image;
  image.lattice.size = openvdb::Coord(97, 61, 23);
  image.lattice.origin = {-12.5, 40, 7};
  image.lattice.step[0] = {0.6, 0.8, 0}, image.lattice.step[1] = {-1.6, 1.2, 0};
  image.lattice.step[2] = {0, 0, 3};
  std::mt19937 random(5);
  std::vector<T> values;
  while (values.size() < image.lattice.count())
    values.insert(values.end(), std::min<size_t>(1 + random() % 30, image.lattice.count() - values.size()),
                  T(random() % 200));
  image.values = std::move(values);
  return image;
}

/// The slices of an image, each with its values.
template <typename T>
std::vector<ImageValues> slicesOf(const Image& image) {
  const auto& values = std::get<std::vector<T>>(image.values);
  const size_t each = size_t(image.lattice.size[0] * image.lattice.size[1]);
  std::vector<ImageValues> slices;
  for (size_t from = 0; from < values.size(); from += each)
    slices.emplace_back(
        std::vector<T>(values.begin() + std::ptrdiff_t(from), values.begin() + std::ptrdiff_t(from + each)));
  return slices;
}

template <typename T>
void checkBothWays(const std::string& whole, const std::string& sliced) {
  const Image image = runs<T>();
  writeImage(whole, image);
  ImageSliceWriter writer(sliced, image.lattice, image.values);
  for (const ImageValues& slice : slicesOf<T>(image)) writer.add(slice);
  EXPECT_FALSE(fs::exists(sliced));
  writer.commit();
  EXPECT_EQ(readWholeFile(whole), readWholeFile(sliced)) << whole;
  const ImageFile read = readImage(whole);
  std::optional<ImageSlices> slices = openImageSlices(whole);
  ASSERT_TRUE(slices) << whole;
  const ImageLattice &a = slices->file.image.lattice, &b = read.image.lattice;
  EXPECT_EQ(a.size, b.size);
  EXPECT_EQ(a.origin, b.origin);
  for (int d = 0; d < 3; ++d) EXPECT_EQ(a.step[d], b.step[d]);
  EXPECT_EQ(slices->file.format, read.format);
  for (const ImageValues& slice : slicesOf<T>(image)) EXPECT_EQ(slices->next(), slice) << whole;
  fs::remove(sliced);
}

TEST_F(Slices, AreThoseOfTheWhole) {
  for (const std::string& extension : kExtensions) {
    const std::string whole = at("whole" + extension), sliced = at("sliced" + extension);
    checkBothWays<std::uint8_t>(whole, sliced);
    checkBothWays<std::int16_t>(whole, sliced);
    checkBothWays<std::uint16_t>(whole, sliced);
    checkBothWays<std::int32_t>(whole, sliced);
    checkBothWays<float>(whole, sliced);
    checkBothWays<double>(whole, sliced);
  }
}

/// 2 x 3 x 4 numbers of 16 bits, each its index, the high byte first or last.
std::string counted(bool highFirst) {
  std::string bytes;
  for (char i = 0; i < 24; ++i) bytes += highFirst ? std::string{'\0', i} : std::string{i, '\0'};
  return bytes;
}

void expectCounted(const std::string& path) {
  std::optional<ImageSlices> slices = openImageSlices(path);
  ASSERT_TRUE(slices) << path;
  for (int k = 0; k < 4; ++k) {
    std::vector<std::uint16_t> expected;
    for (int i = 0; i < 6; ++i) expected.push_back(std::uint16_t(6 * k + i));
    EXPECT_EQ(slices->next(), ImageValues(expected)) << path << " " << k;
  }
}

TEST_F(Slices, PlainDataOfEitherByteOrder) {
  for (bool big : {false, true}) {
    const std::string data = counted(big), order = big ? "True" : "False";
    const std::string meta =
        "NDims = 3\nDimSize = 2 3 4\nElementType = MET_USHORT\nBinaryData = True\n"
        "ElementByteOrderMSB = " +
        order + "\nElementDataFile = ";
    expectCounted(write("own.mha", "ObjectType = Image\n" + meta + "LOCAL\n" + data));
    write("numbers.raw", data);
    expectCounted(write("apart.mhd", "ObjectType = Image\n" + meta + "numbers.raw\n"));
    expectCounted(write("plain.nrrd", "NRRD0004\ntype: uint16\ndimension: 3\nsizes: 2 3 4\nendian: " +
                                          std::string(big ? "big" : "little") + "\nencoding: raw\n\n" +
                                          data));
  }
}

TEST_F(Slices, WhatIsCutShortIsToldWhenReached) {
  for (const std::string& extension : kExtensions) {
    const std::string path = at("cut" + extension);
    writeImage(path, runs<std::uint8_t>());
    fs::resize_file(path, fs::file_size(path) / 2);
    const auto readAll = [&] {
      std::optional<ImageSlices> slices = openImageSlices(path);
      for (int k = 0; slices && k < 23; ++k) slices->next();
    };
    EXPECT_THROW(readAll(), IoError) << path;
  }
}

TEST_F(Slices, OfDataApartAndOfOneVolumeOfSeveral) {
  write("numbers.raw", counted(false));
  const std::string head = "NRRD0004\ntype: uint16\n", data = counted(false);
  expectCounted(
      write("apart.nhdr",
            head + "dimension: 3\nsizes: 2 3 4\nendian: little\nencoding: raw\ndata file: numbers.raw\n"));
  const std::string times =
      write("times.nrrd", head + "dimension: 4\nsizes: 2 3 2 2\nendian: little\nencoding: raw\n\n" + data);
  std::optional<ImageSlices> second = openImageSlices(times + ":1");
  ASSERT_TRUE(second);
  EXPECT_EQ(second->next(), ImageValues(std::vector<std::uint16_t>{12, 13, 14, 15, 16, 17}));
  const std::string pairs =
      write("pairs.nrrd", head +
                              "dimension: 4\nsizes: 2 3 2 2\nkinds: list domain domain domain\nendian: "
                              "little\nencoding: raw\n\n" +
                              data);
  std::optional<ImageSlices> odd = openImageSlices(pairs + ":1");
  ASSERT_TRUE(odd);
  EXPECT_EQ(odd->next(), ImageValues(std::vector<std::uint16_t>{1, 3, 5, 7, 9, 11}));
  EXPECT_EQ(odd->next(), ImageValues(std::vector<std::uint16_t>{13, 15, 17, 19, 21, 23}));
}

TEST_F(Slices, OthersAreReadAsAWhole) {
  const std::string head = "NRRD0004\n";
  EXPECT_FALSE(openImageSlices(
      write("text.nrrd", head + "type: uint16\ndimension: 1\nsizes: 2\nencoding: text\n\n1 2\n")));
  EXPECT_FALSE(
      openImageSlices(write("colours.nrrd", head + "type: uint8\ndimension: 3\nsizes: 3 2 1\nkinds: "
                                                   "RGB-color domain domain\nencoding: raw\n\nabcdef")));
}

/// What a whole reads as double, since it needs more than 32 bits, slices refuse.
TEST_F(Slices, BeyondThirtyTwoBitsAreRefused) {
  const std::string head =
      "NRRD0004\ntype: uint32\ndimension: 3\nsizes: 1 1 2\nendian: little\nencoding: raw\n\n";
  const std::string path = write("wide.nrrd", head + std::string("\x01\0\0\0\xff\xff\xff\xff", 8));
  EXPECT_EQ(readImage(path).image.values, ImageValues(std::vector<double>{1, 4294967295.0}));
  std::optional<ImageSlices> slices = openImageSlices(path);
  ASSERT_TRUE(slices);
  EXPECT_EQ(slices->next(), ImageValues(std::vector<std::int32_t>{1}));
  EXPECT_THROW(slices->next(), IoError);
}

}  // namespace
}  // namespace slicemorph
