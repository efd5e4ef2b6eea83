#include "slicemorph/io/formats.h"

#include "io/contours/csl_reader.h"
#include "io/contours/rtstruct_reader.h"
#include "io/format.h"
#include "io/image/image_formats.h"
#include "io/mesh/mesh_reader.h"
#include "io/paths.h"
#include "io/structures/seg_nrrd.h"
#include "io/structures/structure_data.h"
#include "io/vdb/nvdb_writer.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/vdb_writer.h"

#include <algorithm>

namespace slicemorph {

// Reader and writer of a mesh format are declared here and defined in a file of its own in io/mesh. A new
// format needs that file, a row below and a test.
StoredMesh readObj(const std::string& path, std::string_view bytes);
StoredMesh readPly(const std::string& path, std::string_view bytes);
StoredMesh readStl(const std::string& path, std::string_view bytes);
StoredMesh readOff(const std::string& path, std::string_view bytes);
StoredMesh readGlb(const std::string& path, std::string_view bytes);
void writeObj(const std::string& path, const Mesh& mesh, MeshSpace space);
void writePly(const std::string& path, const Mesh& mesh, MeshSpace space);
void writeStl(const std::string& path, const Mesh& mesh, MeshSpace space);
void writeStillGlb(const std::string& path, const Mesh& mesh, MeshSpace space);
void writeVtp(const std::string& path, const Mesh& mesh, MeshSpace space);
void writeUsda(const std::string& path, const Mesh& mesh, MeshSpace space);

namespace {

bool has(const std::vector<std::string>& extensions, const std::string& path) {
  return std::any_of(extensions.begin(), extensions.end(), [&](const std::string& extension) {
    return fullExtensionOf(path) == extension || endsWith(path, extension);
  });
}

/// A row of a format that is recognised by its extension.
Format row(const char* name, Contents contents, std::vector<std::string> reads,
           std::vector<std::string> writes, const char* help) {
  Format format;
  format.name = name;
  format.contents = contents;
  format.reads = std::move(reads), format.writes = std::move(writes);
  format.help = help;
  return format;
}

Format mesh(const char* extension, MeshReader read, MeshWriter write, const char* help) {
  Format format = row(extension + 1, Contents::kMesh, {}, {}, help);
  if (read) format.reads = {extension};
  if (write) format.writes = {extension};
  format.readMesh = read, format.writeMesh = write;
  return format;
}

Format grids(Format format, GridWriter write) {
  format.writeGrids = write;
  return format;
}

Format image(Format format, ImageReader read, SliceOpener open, VoxelHeader head) {
  format.readImage = read, format.openSlices = open, format.voxelHead = head;
  return format;
}

Format dicom() {
  Format format = row("dicom", Contents::kImage, {".dcm"}, {}, "DICOM series, a folder or one of its files");
  format.listed = "a DICOM folder";
  format.recognise = isDicomImage;
  format.readImage = readDicomImage, format.listImages = listDicomImages;
  return format;
}

Format stack() {
  Format format = row("stack", Contents::kImage, {".tif", ".tiff", ".png", ".exr"}, {},
                      "numbered pictures or a .tif of several pages");
  format.listed = "name.####.tif|png|exr";
  format.recognise = isImageStack;
  format.readImage = readStackImage, format.listImages = listStackImages;
  format.openSlices = openStackSlices;
  return format;
}

Format contours(Format format, Recogniser recognise, ContourReader read) {
  format.recognise = recognise, format.readContours = read;
  return format;
}

/// A row of named structures, which is only written.
Format structures(Format format, StructureWriter write) {
  format.writeStructures = write;
  return format;
}

/// The order matters: formats with extensions of their own come before those that look into files and
/// folders, and RT structure sets, which are DICOM too, before DICOM images.
std::vector<Format> makeFormats() {
  using C = Contents;
  std::vector<Format> rows;
  rows.push_back(
      grids(row("vdb", C::kGrids, {".vdb"}, {".vdb"}, "OpenVDB: level sets, fog volumes and other grids"),
            writeVdb));
  rows.push_back(
      grids(row("nvdb", C::kGrids, {}, {".nvdb"}, "NanoVDB: grids for graphics cards"), writeNvdb));
  rows.push_back(mesh(".obj", readObj, writeObj, "Wavefront OBJ, colours of points or materials"));
  rows.push_back(mesh(".ply", readPly, writePly, "PLY, colours of points or faces"));
  rows.push_back(mesh(".stl", readStl, writeStl, "STL, text or binary"));
  rows.push_back(mesh(".off", readOff, nullptr, "Object File Format"));
  rows.push_back(mesh(".glb", readGlb, writeStillGlb, "glTF 2.0, colours of points and materials"));
  rows.back().reads.push_back(".gltf");
  rows.push_back(mesh(".vtp", nullptr, writeVtp, "VTK XML PolyData, colours of points"));
  rows.push_back(
      mesh(".usda", nullptr, writeUsda, "USD as text, colours of points; of `morph` also volumes"));
  rows.push_back(image(row("nifti", C::kImage, {".nii", ".nii.gz", ".hdr", ".hdr.gz", ".img", ".img.gz"},
                           {".nii", ".nii.gz"}, "NIfTI-1 and -2, Analyze 7.5"),
                       readNiftiImage, openNiftiSlices, niftiHead));
  rows.push_back(structures(row("segnrrd", C::kStructures, {}, {".seg.nrrd"}, "segmentation of 3D Slicer"),
                            writeSegNrrd));
  rows.push_back(structures(row("segmentation", C::kStructures, {}, {".seg.dcm"}, "DICOM segmentation"),
                            writeDicomStructures));
  rows.push_back(image(row("nrrd", C::kImage, {".nrrd", ".nhdr"}, {".nrrd"}, "NRRD, attached or detached"),
                       readNrrdImage, openNrrdSlices, nrrdHead));
  rows.push_back(image(row("metaimage", C::kImage, {".mha", ".mhd"}, {".mha"}, "MetaImage"),
                       readMetaImageFile, openMetaImageSlices, metaImageHead));
  rows.push_back(contours(row("csl", C::kContours, {".csl"}, {}, "contours on planes of any direction"),
                          nullptr, readCsl));
  rows.push_back(contours(row("rtstruct", C::kContours, {}, {".rt.dcm"}, "DICOM RT structure set"),
                          isRtStructureSet, readRtStructureSet));
  rows.back().listed = "a DICOM RT structure set", rows.back().writeStructures = writeDicomStructures;
  rows.push_back(dicom());
  rows.push_back(stack());
  rows.push_back(row("exr", C::kSlices, {".exr"}, {".exr"}, "slices as `slicemorph slice` writes them"));
  return rows;
}

std::string joined(const std::vector<std::string>& words, const std::string& between) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : between) + word;
  return text;
}

}  // namespace

const std::vector<Format>& formats() {
  static const std::vector<Format> table = makeFormats();
  return table;
}

const Format* formatToRead(const std::string& path) {
  for (const Format& format : formats())
    if (format.recognise ? format.recognise(path) : has(format.reads, path)) return &format;
  return nullptr;
}

const Format* formatToWrite(const std::string& path) {
  for (const Format& format : formats())
    if (has(format.writes, path)) return &format;
  return nullptr;
}

std::vector<FormatSummary> knownFormats() {
  std::vector<FormatSummary> summaries;
  for (const Format& f : formats()) summaries.push_back({f.name, f.contents, f.reads, f.writes, f.help});
  return summaries;
}

std::string readableList(Contents contents, const std::string& between) {
  // Formats that are described in words are separated by commas.
  std::vector<std::string> extensions, inWords;
  for (const Format& format : formats()) {
    if (format.contents != contents) continue;
    if (!format.listed.empty())
      inWords.push_back(format.listed);
    else
      extensions.insert(extensions.end(), format.reads.begin(), format.reads.end());
  }
  const std::string first = joined(extensions, between), second = joined(inWords, ", ");
  return first + (first.empty() || second.empty() ? "" : ", ") + second;
}

std::string writableList(Contents contents, const std::string& between) {
  std::vector<std::string> extensions;
  for (const Format& format : formats())
    if (format.contents == contents)
      extensions.insert(extensions.end(), format.writes.begin(), format.writes.end());
  return joined(extensions, between);
}

std::string structureList(const std::string& between) {
  std::vector<std::string> extensions;
  for (const Format& format : formats())
    if (format.writeStructures)
      extensions.insert(extensions.end(), format.writes.begin(), format.writes.end());
  return joined(extensions, between);
}

void refuseAsShape(const InputSpec& input) {
  sizeOfInput(input.path);  // says so where the file is missing or a folder, which helps more
  if (input.contents == Contents::kContours)
    throw InputError(input.path, "holds contours, no shape; `slicemorph reconstruct` makes surfaces of them");
  throw InputError(input.path, "cannot read the extension '" + extensionOf(input.path) + "'; use " +
                                   readableList(Contents::kGrids, ", ") + ", " +
                                   readableList(Contents::kMesh, ", ") +
                                   ", or an image: " + readableList(Contents::kImage));
}

}  // namespace slicemorph
