#pragma once

#include "slicemorph/io/image_file.h"
#include "slicemorph/io/structure_file.h"

#include <memory>
#include <string>
#include <vector>

namespace slicemorph {

/// Where structures are written, and on which planes.
struct StructuresJob {
  std::string input, output;
  std::string source;  ///< a DICOM series; empty: none
  std::string like;    ///< an image; empty: none
  std::string names;   ///< "1=Heart,2=Left lung"; empty: none
  ImageOptions image;
  std::vector<LabelName> labels = {};  ///< what the input calls its labels
};

/// As checkOutput, of commands that also write structures. Throws InputError for a name of several files, as one holds all,
/// and where `source` or `names` (see StructuresJob) are given for another output.
void checkStudyOutput(const std::string& path, const std::string& source, const std::string& names);

struct NamedSurface {
  int number = 1;
  std::string name;
  FloatGrid::ConstPtr grid;  ///< level set
};

/// Writes the labels of a map as structures on the map's own voxels; outlines (`.rt.dcm`) on the source's planes where
/// there is a source and no --like. Returns what is to be told. Throws InputError, IoError.
Notes writeLabelStructures(const StructuresJob& job, std::shared_ptr<const Image> labels);

/// Writes level sets as structures on the planes of --like, else of the source, else of a lattice. As above.
Notes writeSurfaceStructures(const StructuresJob& job, const std::vector<NamedSurface>& surfaces,
                             const ImageLattice& otherwise);

}  // namespace slicemorph
