#include "slicemorph/io/formats.h"

#include "io/scratch_folder.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/input.h"

#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>

namespace slicemorph {
namespace {

namespace fs = std::filesystem;

class Formats : public ::testing::Test {
 protected:
  std::string file(const std::string& name) const { return folder_.file(name); }
  std::string write(const std::string& name, const std::string& bytes = "x") const {
    std::ofstream(file(name), std::ios::binary) << bytes;
    return file(name);
  }

  ScratchFolder folder_;
};

// ---------------------------------------------------------------- inputs

TEST_F(Formats, InputsAreTakenApart) {
  struct Case {
    const char *text, *path, *selection;
    Contents contents;
    bool sequence;
  };
  for (const Case& c : std::vector<Case>{
           {"a.vdb", "a.vdb", "", Contents::kGrids, false},
           {"a.VDB:density", "a.VDB", "density", Contents::kGrids, false},
           {"a.vdb:z:w", "a.vdb", "z:w", Contents::kGrids, false},
           {"s.####.vdb:fog", "s.####.vdb", "fog", Contents::kGrids, true},
           {"C:/a.obj", "C:/a.obj", "", Contents::kMesh, false},
           {"m.##.Obj", "m.##.Obj", "", Contents::kMesh, true},
           {"a.nii.gz:3", "a.nii.gz", "3", Contents::kImage, false},
           {"a.nrrd", "a.nrrd", "", Contents::kImage, false},
           {"t.tif", "t.tif", "", Contents::kImage, false},
           {"t.####.png", "t.####.png", "", Contents::kImage, true},
           {"t.png", "t.png", "", Contents::kUnknown, false},
           {"t.####.exr", "t.####.exr", "", Contents::kImage, true},
           {"t.exr", "t.exr", "", Contents::kSlices, false},
           {"a.dcm", "a.dcm", "", Contents::kImage, false},
           {"c.csl:2", "c.csl", "2", Contents::kContours, false},
           {"a.gz", "a.gz", "", Contents::kUnknown, false},
           {"a.doc:x", "a.doc:x", "", Contents::kUnknown, false},
           {"", "", "", Contents::kUnknown, false},
       }) {
    const InputSpec spec = parseInput(c.text);
    EXPECT_EQ(spec.text, c.text);
    EXPECT_EQ(spec.path, c.path) << c.text;
    EXPECT_EQ(spec.selection, c.selection) << c.text;
    EXPECT_EQ(spec.contents, c.contents) << c.text;
    EXPECT_EQ(spec.isSequence, c.sequence) << c.text;
    EXPECT_EQ(spec.isMoving(), c.sequence && c.contents != Contents::kImage) << c.text;
    EXPECT_EQ(spec.format == nullptr, c.contents == Contents::kUnknown) << c.text;
  }
  EXPECT_THROW(parseInput("a.vdb:"), InputError);
  EXPECT_THROW(parseInput("a.nii:"), InputError);
}

/// A file that exists is taken by its whole name, whatever colons and # are in it.
TEST_F(Formats, WhatIsThereIsTakenAsItIs) {
  const std::string odd = write("x.vdb:y.vdb");
  EXPECT_EQ(parseInput(odd).path, odd);
  EXPECT_EQ(parseInput(odd + ":z:w").path, odd);
  EXPECT_EQ(parseInput(odd + ":z:w").selection, "z:w");
  const std::string hashes = write("a#b.vdb");
  EXPECT_FALSE(parseInput(hashes).isSequence);
  EXPECT_TRUE(parseInput(file("other#b.vdb")).isSequence);
  const std::string volume = write("v.nii:3");
  EXPECT_EQ(parseInput(volume).path, volume);
}

TEST_F(Formats, FoldersAreSeriesUnlessTheyAreCalledAShape) {
  fs::create_directory(file("series"));
  fs::create_directory(file("shape.obj"));
  EXPECT_EQ(parseInput(file("series")).contents, Contents::kImage);
  EXPECT_EQ(parseInput(file("series") + ":2").path, file("series"));
  EXPECT_EQ(parseInput(file("series") + ":2").selection, "2");
  EXPECT_EQ(parseInput(file("shape.obj")).contents, Contents::kMesh);
}

TEST_F(Formats, FramesOfASequenceKeepTheSelection) {
  for (const char* number : {"0003", "0001", "0012"}) write(std::string("s.") + number + ".vdb");
  write("s.12.vdb");  // not padded: of another sequence
  const std::vector<InputFrame> frames = framesOf(parseInput(file("s.####.vdb:fog")));
  ASSERT_EQ(frames.size(), 3u);
  EXPECT_EQ(frames[0].number, 1);
  EXPECT_EQ(frames[2].number, 12);
  EXPECT_EQ(frames[1].input.path, file("s.0003.vdb"));
  EXPECT_EQ(frames[1].input.text, file("s.0003.vdb:fog"));
  EXPECT_EQ(frames[1].input.selection, "fog");
  EXPECT_TRUE(frames[1].input.isGrids());
  EXPECT_FALSE(frames[1].input.isMoving());
  EXPECT_THROW(framesOf(parseInput(file("t.####.vdb"))), IoError);
}

TEST_F(Formats, RangesTakeSomeFramesOfASequence) {
  for (int n : {1, 2, 3, 4, 7, 8}) write("s.000" + std::to_string(n) + ".vdb");
  const auto numbersOf = [&](const std::string& text) {
    std::vector<int> numbers;
    for (const InputFrame& frame : framesOf(parseInput(file(text)))) numbers.push_back(frame.number);
    return numbers;
  };
  EXPECT_EQ(numbersOf("s.####.vdb@1-4x2"), (std::vector<int>{1, 3}));
  EXPECT_EQ(numbersOf("s.####.vdb@8,2-3"), (std::vector<int>{2, 3, 8}));
  EXPECT_EQ(numbersOf("s.####.vdb@2:fog"), (std::vector<int>{2}));
  EXPECT_EQ(parseInput(file("s.####.vdb@2:fog")).selection, "fog");
  EXPECT_EQ(parseInput(file("s.####.vdb:fog@2")).range, "2");
  EXPECT_EQ(filesOfInput(parseInput(file("s.####.vdb@3-4"))).size(), 2u);
  try {
    numbersOf("s.####.vdb@3-8");
    ADD_FAILURE() << "frames are missing";
  } catch (const IoError& error) {
    EXPECT_NE(std::string(error.what()).find("frames 5-6 are missing"), std::string::npos) << error.what();
  }
  for (const char* wrong : {"@", "@4-1", "@1-", "@-3", "@x", "@1-3x0", "@1,,2", "@1-2000000"})
    EXPECT_THROW(parseInput(file("s.####.vdb") + wrong), InputError) << wrong;
  // The mark may be in a name, and means nothing where there is no sequence.
  EXPECT_TRUE(parseInput(file("a.####@home.vdb")).range.empty());
  EXPECT_EQ(parseInput(file("a@3.vdb")).path, file("a@3.vdb"));
}

TEST_F(Formats, BracesPlaceAnInput) {
  const InputSpec spec = parseInput(file("a.vdb:fog{scale=0.5, upright=z}"));
  EXPECT_EQ(spec.path, file("a.vdb"));
  EXPECT_EQ(spec.selection, "fog");
  EXPECT_EQ(spec.placing.scale, 0.5);
  EXPECT_EQ(spec.placing.upright, 'z');
  EXPECT_TRUE(spec.isGrids());
  const std::string named = write("b{1}.obj");
  EXPECT_EQ(parseInput(named).path, named);
  for (const char* wrong : {"{}", "{scale=-1}", "{scale=1e999}", "{upright=q}", "{fit=tight}", "{turn=3}"})
    EXPECT_THROW(parseInput(file("a.obj") + wrong), InputError) << wrong;
  write("s.0001.vdb");
  // Frames are parsed again by their texts.
  const InputSpec frame = framesOf(parseInput(file("s.####.vdb{scale=2}")))[0].input;
  EXPECT_EQ(parseInput(frame.text).placing.scale, 2);
}

// ---------------------------------------------------------------- the table

TEST_F(Formats, EveryRowIsComplete) {
  std::set<std::string> names;
  for (const FormatSummary& format : knownFormats()) {
    EXPECT_TRUE(names.insert(format.name).second) << format.name;
    EXPECT_FALSE(format.help.empty()) << format.name;
    EXPECT_NE(format.contents, Contents::kUnknown) << format.name;
    for (const auto* extensions : {&format.reads, &format.writes})
      for (const std::string& extension : *extensions) {
        EXPECT_EQ(extension[0], '.') << extension;
        EXPECT_EQ(std::count_if(extension.begin(), extension.end(), ::isupper), 0) << extension;
      }
  }
}

TEST_F(Formats, ListsNameWhatThereIs) {
  EXPECT_EQ(readableList(Contents::kGrids), ".vdb");
  // Meshes: at least these, so that this line need not change for a new format.
  const std::string meshes = readableList(Contents::kMesh, ", ");
  EXPECT_EQ(meshes.substr(0, 28), ".obj, .ply, .stl, .off, .glb");
  EXPECT_EQ(writableList(Contents::kMesh).substr(0, 19), ".obj .ply .stl .glb");
  EXPECT_EQ(readableList(Contents::kImage),
            ".nii .nii.gz .hdr .hdr.gz .img .img.gz .nrrd .nhdr .mha .mhd, a DICOM folder, "
            "name.####.tif|png|exr");
  EXPECT_EQ(writableList(Contents::kImage), ".nii .nii.gz .nrrd .mha");
  EXPECT_EQ(readableList(Contents::kContours), ".csl, a DICOM RT structure set");
}

/// For an unknown extension the message lists all formats that can be read; for contours it says
/// what they are.
TEST_F(Formats, MessagesListTheTable) {
  try {
    loadObject(write("x.doc"));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.note().about, file("x.doc"));
    for (Contents contents : {Contents::kGrids, Contents::kMesh})
      EXPECT_NE(error.note().text.find(readableList(contents, ", ")), std::string::npos) << error.what();
    EXPECT_NE(error.note().text.find(readableList(Contents::kImage)), std::string::npos) << error.what();
  }
  try {
    loadObject(write("x.csl", "CSLC"));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(error.note().text.find("contours"), std::string::npos) << error.what();
  }
}

// ---------------------------------------------------------------- plug-ins

/// The variable is read when a plug-in is first needed, so this test has to come before others that need one.
TEST_F(Formats, AMissingPluginIsNamedWithThePlacesLookedAt) {
  const std::string image = write("x.nrrd");
  ::setenv("SLICEMORPH_PLUGINS", file("nowhere").c_str(), 1);
  try {
    readImage(image);
    ADD_FAILURE();
  } catch (const IoError& error) {
    EXPECT_EQ(error.note().about, "libslicemorph_itk.so");
    EXPECT_NE(error.note().text.find("looked in " + file("nowhere") + ";"), std::string::npos)
        << error.what();
  }
  ::mkdir(file("nowhere").c_str(), 0700);
  write("nowhere/libslicemorph_itk.so", "no library");
  try {
    readImage(image);
    ADD_FAILURE();
  } catch (const IoError& error) {
    EXPECT_EQ(error.note().about, file("nowhere/libslicemorph_itk.so"));
  }
  ::unsetenv("SLICEMORPH_PLUGINS");
  try {
    readImage(image);
    ADD_FAILURE();
  } catch (const IoError& error) {  // the plug-in was loaded and found no image
    EXPECT_EQ(error.note().about, image);
  }
}

}  // namespace
}  // namespace slicemorph
