#include "tools/job/option_table.h"

#include "io/exr/exr_slice_writer.h"
#include "io/points/position_file.h"
#include "slicemorph/io/formats.h"
#include "tools/job/survey_job.h"

#include <utility>

namespace slicemorph {
namespace {

using Rows = std::vector<OptionRow>;
using J = JobOptions;

/// The field that a chain of members leads to: at<&JobOptions::plan, &MorphOptions::slices>.
template <auto... Members>
OptionField at(JobOptions& options) {
  return &(options.*....*Members);
}

/// Builds a row by a chain of calls for what differs from the defaults.
class Row {
 public:
  Row(unsigned commands, const std::string& name, OptionField (*field)(JobOptions&), const std::string& form,
      const std::string& help) {
    row_.commands = commands, row_.name = name, row_.field = field, row_.form = form, row_.help = help;
    JobOptions options;
    const OptionType types[] = {OptionType::kTables, OptionType::kFlag, OptionType::kInteger,
                                OptionType::kNumber, OptionType::kText, OptionType::kTexts};
    row_.type = types[field ? field(options).index() : 0];
  }
  operator OptionRow() const { return row_; }

  Row& as(OptionType type) { return row_.type = type, *this; }
  Row& positional(const std::string& name) { return row_.positional = name, *this; }
  Row& of(unsigned commands) { return row_.commands = commands, *this; }
  Row& unit(const std::string& unit) { return row_.unit = unit, *this; }
  Row& range(double least, double most) { return row_.range = {least, most, false}, *this; }
  Row& above(double least) { return row_.range.least = least, row_.range.open = true, *this; }
  Row& atLeast(double least) { return row_.range.least = least, *this; }
  Row& oneOf(std::vector<std::string> choices) { return row_.choices = std::move(choices), *this; }
  Row& braced() { return row_.braces = true, *this; }
  Row& fallback(const std::string& text) { return row_.fallback = text, *this; }
  Row& excludes(std::vector<std::string> names) { return row_.excludes = std::move(names), *this; }
  Row& silencedBy(std::vector<std::string> names) { return row_.silencedBy = std::move(names), *this; }
  Row& needs(bool MethodTraits::*can) { return row_.needs = can, *this; }
  Row& target(OptionTarget target) { return row_.target = target, *this; }
  Row& basic() { return row_.basic = true, *this; }
  Row& required() { return row_.required = row_.basic = true, *this; }
  Row& notInFiles() { return row_.inFiles = row_.inFrames = false, *this; }
  Row& notInFrames() { return row_.inFrames = false, *this; }

 private:
  OptionRow row_;
};

constexpr unsigned kMatchers = kMorph | kApply | kPick | kSurvey;
constexpr unsigned kVoxelisers = kMatchers | kSlice | kConvert | kRender | kCompare;

std::string readableShapes() {
  return readableList(Contents::kGrids) + " (file.vdb:grid picks a grid) " + readableList(Contents::kMesh);
}

std::string readableImages() {
  return readableList(Contents::kImage) + " (file:N for a volume, folder:N for a series)";
}

std::string writableShapes() { return writableList(Contents::kGrids) + " " + writableList(Contents::kMesh); }

Rows inputRows() {
  const std::string shapes = readableShapes(), images = readableImages();
  return {
      Row(kMorph, "inputs", at<&J::inputs>, "",
          "Two or more shapes or fog volumes: " + shapes + ", name.####.vdb for a sequence; or images: " +
              images + "; more than two follow each other in time")
          .positional("INPUT")
          .basic(),
      Row(kDemo, "inputs", at<&J::inputs>, "",
          "Two shapes, as for `morph`; none for those that come with the program")
          .positional("INPUT")
          .basic(),
      Row(kRender, "inputs", at<&J::inputs>, "",
          "Shapes and fog; name.####.vdb stands for all files of that name that are there")
          .positional("INPUT")
          .basic(),
      Row(kConvert, "input", at<&J::input>, "", "Shape: " + shapes + "; image: " + images)
          .positional("INPUT")
          .required(),
      Row(kInfo, "input", at<&J::input>, "", "File: " + shapes + "; or an image: " + images)
          .positional("INPUT")
          .required(),
      Row(kSlice, "input", at<&J::input>, "",
          "Volume: .vdb (all grids; file.vdb:grid one) " + readableList(Contents::kMesh) +
              "; or an image: " + images)
          .positional("INPUT")
          .required(),
      Row(kReconstruct, "input", at<&J::input>, "",
          "Label map in which slices are empty, or a stack with --between: " +
              readableList(Contents::kImage) + "; contours: " + readableList(Contents::kContours) +
              " (file:NAME for one structure); slices of a volume as `slice` writes them: name.####.exr, or "
              "one file")
          .positional("INPUT")
          .required(),
      Row(kRetime, "input", at<&J::input>, "",
          "Sequence of smoke, level sets or liquids: name.####.vdb, name.####.vdb@10-40x2 for some of the "
          "files, "
          "name.####.vdb:grid where the file holds several shapes")
          .positional("INPUT")
          .required(),
      Row(kCompare, "a", at<&J::input>, "", "Shape: " + shapes + "; image: " + images)
          .positional("A")
          .required(),
      Row(kCompare, "b", at<&J::other>, "", "Shape to compare with A").positional("B").required(),
      Row(kApply, "inputs", at<&J::inputs>, "",
          "Two or more objects, as for `morph`, and then WHAT is to be carried from the one to the other: "
          "points, "
          "meshes, curves (" +
              positionList() + "; everything but positions is kept) or an image: " + images +
              "; with --field only the objects")
          .positional("INPUT")
          .basic(),
      Row(kPick, "inputs", at<&J::inputs>, "",
          "Two or more objects, as for `morph`; of a sequence its first file is shown")
          .positional("INPUT")
          .basic(),
      Row(kSurvey, "inputs", at<&J::inputs>, "",
          "Two or more objects, as for `morph`; more than two follow each other in time")
          .positional("INPUT")
          .basic(),
      Row(kMatchers, "upright", at<&J::upright>, "",
          "The inputs' axis that points up: objects are turned about it rather than laid down; none: they "
          "lie anyhow")
          .oneOf({"auto", "x", "y", "z", "none"})
          .fallback("as --glb-up says; none for images")
          .basic(),
      Row(kMorph | kPick | kSurvey, "fit", at<&J::fit>, "",
          "Inputs of different sizes are scaled to the first one's size, or also moved into its box; of one "
          "alone: "
          "file.obj{scale=0.001,upright=z,fit=box}; the transforms are in the report")
          .oneOf({"none", "size", "box"})
          .basic(),
      Row(kMorph, "glb-up", at<&J::glbUp>, "",
          "The inputs' axis that points up, for .glb, where it is Y, and .usda, which says so; of images in "
          ".usda it is z")
          .oneOf({"y", "z"}),
      Row(kMorph, "glb-unit", at<&J::unit>, "",
          "The inputs' unit, for .glb, which is in metres, and .usda, which says so; of images in .usda it "
          "is "
          "mm")
          .oneOf({"m", "cm", "mm"}),
  };
}

Rows shapeRows() {
  return {
      Row(kVoxelisers, "voxel-size", at<&J::load, &LoadOptions::voxelSize>, "H", "Edge of a voxel")
          .unit("world units")
          .above(0)
          .fallback("as --resolution says")
          .excludes({"resolution"})
          .basic(),
      Row(kReconstruct, "voxel-size", at<&J::load, &LoadOptions::voxelSize>, "H",
          "Edge of a voxel of surfaces, in millimetres, or of grids, in world units")
          .above(0)
          .fallback("found; for grids one pixel")
          .basic(),
      Row(kVoxelisers & ~kRender & ~kSurvey, "resolution", at<&J::load, &LoadOptions::resolution>, "N",
          "Voxels along the longest side of each object")
          .range(8, 4096)
          .fallback("256 for meshes; VDB inputs keep their voxel size")
          .excludes({"voxel-size"})
          .basic(),
      Row(kSurvey, "resolution", at<&J::load, &LoadOptions::resolution>, "N",
          "Voxels along the longest side of each object, also of VDB inputs")
          .range(8, 4096)
          .fallback(std::to_string(kSurveyResolution))
          .excludes({"voxel-size"})
          .basic(),
      Row(kRender, "resolution", at<&J::pictureResolution>, "WxH|N",
          "Pixels of a picture, as --size; or one number: voxels along the longest side of a mesh, 8 to 4096")
          .fallback("256 voxels for meshes")
          .basic(),
      Row(kVoxelisers, "shell", at<&J::load, &LoadOptions::shell>, "THICKNESS",
          "Thickness that sheets of a mesh get, which enclose nothing: a plane, a leaf, hair; two voxels at "
          "least")
          .unit("world units")
          .above(0)
          .fallback("they are left out"),
      Row(kVoxelisers | kRetime, "iso", at<&J::iso>, "V[,V...][/V...]",
          "Value of the surface in a VDB grid or a grey image; further ones of an image help to match; a "
          "slash parts those of one input from the next's")
          .as(OptionType::kNumbers)
          .fallback("0 in level sets, else found from the values")
          .basic(),
      Row(kRender, "surface", at<&J::fogAsSurface>, "", "Fog is drawn as the shape in it, at --iso"),
      Row(kMorph, "method", at<&J::method>, "NAME{PARAMETER=VALUE,...}", methodHelp())
          .oneOf(methodNames())
          .braced()
          .basic(),
      Row(kSurvey, "method", at<&J::methods>, "NAME{PARAMETER=VALUE,...}",
          "Only this method of `morph`; may be given again")
          .fallback("all; those that cannot take the inputs say why on the page")
          .basic(),
  };
}

Rows matchingRows() {
  return {
      Row(kMatchers, "slices", at<&J::plan, &MorphOptions::slices>, "N", "Slices per object").range(8, 1024),
      Row(kMatchers, "samples", at<&J::plan, &MorphOptions::samples>, "N", "Points per contour")
          .range(16, 4096),
      Row(kMatchers, "axis", at<&J::axis>, "auto|x|y|z|DX,DY,DZ", "Slicing direction of the first input"),
      Row(kMatchers, "spine", at<&J::spine>, "", "Line that the slices follow")
          .oneOf({"auto", "straight", "curved"}),
      Row(kMatchers, "align", at<&J::align>, "", "none keeps world positions and directions")
          .oneOf({"auto", "none"})
          .basic(),
      Row(kMatchers, "interpolation", at<&J::interpolation>, "",
          "Path of the contours: straight, by cubics that leave and reach them at right angles, or by edge "
          "lengths and turning angles")
          .oneOf({"linear", "hermite", "intrinsic"})
          .needs(&MethodTraits::guided),
      Row(kMatchers, "landmarks", at<&J::landmarks>, "FILE,FILE[,...]",
          "Positions to be carried onto each other: a file of points per input, or in a job file "
          "[[[x,y,z],[x,y,z]], ...]")
          .as(OptionType::kLandmarks)
          .needs(&MethodTraits::features),
      Row(kMorph, "check-landmarks", at<&J::checkLandmarks>, "FILE,FILE[,...]",
          "Positions that are only measured, for the report")
          .as(OptionType::kLandmarks)
          .notInFrames(),
      Row(kMorph, "feature", nullptr, "", "").needs(&MethodTraits::features),
      Row(kMorph, "region", nullptr, "", "").needs(&MethodTraits::guided),
  };
}

Rows outputRows() {
  return {
      Row(kMorph, "output", at<&J::output>, "OUTPUT",
          "Result: " + writableShapes() + ", pictures .png .exr, slices .exr, of images also " +
              writableList(Contents::kImage) +
              "; #### stands for the frame number; a .glb or .usda without #### holds all frames, animated")
          .fallback("beside the first input, of .vdb files or images; plan has none")
          .basic(),
      Row(kApply, "output", at<&J::output>, "OUTPUT",
          "Result: a copy of WHAT with other positions, with its extension; of an image: " +
              writableList(Contents::kImage) + "; of --field also " + writableList(Contents::kGrids))
          .fallback("beside WHAT, with its extension")
          .basic(),
      Row(kPick, "output", at<&J::output>, "PAGE.html",
          "Page that shows the inputs side by side, to point at places that belong together; it makes a job "
          "file for "
          "`morph --config`")
          .required(),
      Row(kSurvey, "output", at<&J::output>, "PAGE.html",
          "Page with the score of every method, its frames, time and memory, and curves of all")
          .required(),
      Row(kSurvey, "csv", at<&J::tableFile>, "FILE.csv",
          "The figures as a table, too, a line a frame of each method")
          .fallback("no table")
          .basic(),
      Row(kSurvey, "truth", at<&J::truths>, "t=T:FILE",
          "The true shape at a time between 0 and 1, at which there is a frame; may be given again. The "
          "score is then the "
          "distance to it")
          .fallback("none; the score is made of several figures")
          .basic(),
      Row(kPick, "no-plan", at<&J::noPlan>, "",
          "Show the shapes at once, without matching them: no colours tell what meets what"),
      Row(kRetime, "output", at<&J::output>, "OUTPUT",
          "Result: name.####.vdb, or name.usda for these and a USD stage that shows them; a frame that shows "
          "a "
          "file is that file, but for the velocities' length")
          .fallback("beside the input")
          .basic(),
      Row(kApply, "field", at<&J::field>, "",
          "Write the map itself: at the points of time --from the displacement to where they are at --to, in "
          "world units "
          "(LPS millimetres); " +
              writableList(Contents::kGrids) + ": a vec3s grid `displacement`")
          .basic(),
      Row(kSlice, "output", at<&J::output>, "OUTPUT",
          "Images: name.####.exr, one a slice from 1, or name.exr, one file of several parts")
          .fallback("beside the input, one file a slice")
          .basic(),
      Row(kReconstruct, "output", at<&J::output>, "OUTPUT",
          "Result: " + writableList(Contents::kImage) +
              " (a dense label map or grey image; with #### a mask of each label); " +
              writableList(Contents::kMesh) + " (surfaces, #### stands for the label); " +
              writableList(Contents::kGrids) + " (a level set per label; of EXR slices all their grids); " +
              structureList() + " (named structures)")
          .fallback("beside the input: .vdb of EXR slices, else an image")
          .basic(),
      Row(kConvert, "output", at<&J::output>, "OUTPUT",
          "Result: " + writableList(Contents::kGrids) +
              " (a level set; of an image its values, with --iso the surface beside them), " +
              writableList(Contents::kMesh) + " (the surface), " + writableList(Contents::kImage) +
              " (an image; of a shape 1 inside), " + structureList() +
              " (labels, or the shape, as structures)")
          .required(),
      Row(kDemo, "output", at<&J::output>, "FOLDER",
          "Folder of the results, of each pair of shapes in one of its own, which must not be there yet")
          .fallback("slicemorph-demo in the current folder")
          .basic(),
      Row(kRender, "output", at<&J::output>, "OUTPUT",
          "Pictures: .png, .exr (with mask, Z and N); #### stands for the number; a preview: .gif, .mp4 "
          "(needs ffmpeg)")
          .fallback(".png beside the first input; none with --contact-sheet")
          .basic(),
      Row(kReconstruct, "report", at<&J::reports>, "FILE.json|FILE.csv",
          "Volume, area and extents of every label")
          .notInFrames()
          .basic(),
      Row(kCompare, "report", at<&J::reports>, "FILE.json|FILE.csv",
          "All figures; of label maps a line a label: volumes, Dice, distances (mean, 95 %, largest), "
          "centroids")
          .notInFrames()
          .basic(),
      Row(kCompare | kInfo, "json", at<&J::json>, "", "Print JSON").basic(),
  };
}

/// Times and weights of frames.
Rows timeRows() {
  return {
      Row(kMorph, "frames", at<&J::frames>, "N", "Frames 1 to N, the first input at 1, the last at N")
          .range(1, 1000000)
          .fallback("24; as many as input sequences have")
          .excludes({"at", "weights"})
          .basic(),
      Row(kSurvey, "frames", at<&J::frames>, "N",
          "Frames of each method, the first input at 1, the last at N")
          .range(2, 65)
          .fallback(std::to_string(kSurveyFrames))
          .basic(),
      Row(kMorph, "at", at<&J::at>, "T[,T...]", "Only these times, 0 to 1")
          .as(OptionType::kNumbers)
          .excludes({"frames", "weights"})
          .basic(),
      Row(kMorph, "start", at<&J::start>, "N", "Number of the first frame, in names and metadata")
          .range(-1000000, 100000000)
          .basic(),
      Row(kMorph | kRetime, "range", at<&J::range>, "A-B[xN][,...]",
          "Make only these frames, numbered as --start says: 1005-1012, 1-100x5, 1-3,5,7-20:2; they are the "
          "same bytes as in the whole sequence")
          .as(OptionType::kNumbers)
          .fallback("all")
          .notInFrames()
          .basic(),
      Row(kRetime, "factor", at<&J::factor>, "F",
          "So many times as slow, below 1 faster: F frames for one from a file's number to the next")
          .above(0)
          .fallback("1, which fills in missing numbers")
          .excludes({"frames", "curve"})
          .basic(),
      Row(kRetime, "frames", at<&J::frames>, "N", "So many frames, from the first file to the last")
          .range(1, 1000000)
          .fallback("as --factor says")
          .excludes({"factor", "curve"})
          .basic(),
      Row(kRetime, "curve", at<&J::curve>, "\"FRAME@FILE FRAME@FILE ...\"",
          "Frames of the output, each with the number of the file that it shows: 1001@6 1024@8.5 1040@10")
          .excludes({"factor", "frames", "start"})
          .basic(),
      Row(kRetime, "timing", at<&J::timing>, "",
          "Between the frames of --curve: at even speed, stopping at each, or smoothly through all")
          .oneOf({"linear", "smoothstep", "catmull-rom"}),
      Row(kRetime, "start", at<&J::start>, "N", "Number of the first frame")
          .range(-1000000, 100000000)
          .fallback("the first file's")
          .basic(),
      Row(kMorph, "weights", at<&J::weights>, "W,W[,W...]",
          "One blend of all inputs: a weight per input, of sum 1")
          .as(OptionType::kNumbers)
          .excludes({"frames", "at"})
          .silencedBy({"keys"})
          .basic(),
      Row(kMorph, "keys", at<&J::keys>, "\"a@0 b@0.5 c@1\"",
          "Inputs by time, 0 to 1: by file name, number or letter; in a job file also [{at = 0, input = "
          "\"a\"}, {at = 1, weights = [0.5, 0.5]}]")
          .as(OptionType::kTables)
          .fallback("one after the other, evenly")
          .silencedBy({"weights"})
          .needs(&MethodTraits::anyTime),
      Row(kMorph, "timing", at<&J::timing>, "",
          "Between keys: at even speed, stopping at each, or smoothly through all")
          .oneOf({"linear", "smoothstep", "catmull-rom"})
          .silencedBy({"weights"})
          .needs(&MethodTraits::anyTime),
      Row(kMorph, "ease", at<&J::ease>, "linear|in|out|in-out|X1,Y1,X2,Y2",
          "Of the whole sequence: slow in, slow out, or a curve as CSS's cubic-bezier")
          .as(OptionType::kNumbers)
          .silencedBy({"weights"})
          .needs(&MethodTraits::anyTime),
      Row(kMorph | kRetime, "fps", at<&J::framesPerSecond>, "F",
          "Frames per second, for velocities and metadata")
          .above(0)
          .basic(),
      Row(kRender, "fps", at<&J::framesPerSecond>, "F", "Pictures per second of a preview").above(0),
      Row(kApply, "from", at<&J::fromTime>, "T", "Time at which WHAT is: 0 the first object, 1 the last")
          .range(0, 1)
          .basic(),
      Row(kApply, "to", at<&J::toTime>, "T", "Time to which it is carried").range(0, 1).basic(),
      Row(kSlice, "t", at<&J::sliceTime>, "T", "Time of the volume in its morph, for the attribute sliceT")
          .range(0, 1)
          .fallback("none"),
  };
}

/// Content of a frame.
Rows contentRows() {
  return {
      Row(kMorph, "grids", at<&J::grids>, "NAME[,NAME...]",
          "Grids of VDBs, slices and pictures, `surface` for the shape's level set")
          .fallback("all; the surface where no input is fog")
          .basic(),
      Row(kSlice, "grids", at<&J::grids>, "NAME[,NAME...]", "Only these grids").fallback("all").basic(),
      Row(kReconstruct, "grids", at<&J::grids>, "NAME[,NAME...]", "Of EXR slices only these grids")
          .fallback("all"),
      Row(kMorph, "conserve", at<&J::conserve>, "",
          "Thin and thicken fog so that its total goes straight from the one to the other"),
      Row(kRetime, "grids", at<&J::grids>, "NAME[,NAME...]", "Only these grids").fallback("all").basic(),
      Row(kRetime, "velocity", at<&J::velocity>, "NAME|none",
          "Name of the velocity grid where the files have none; none: without"),
      Row(kMorph, "velocity", at<&J::velocity>, "NAME|none",
          "Name of the velocity grid of VDB outputs; none: without")
          .fallback("vel; none for images"),
      Row(kMorph | kRetime, "velocity-unit", at<&J::velocityUnit>, "", "World units per second or per frame")
          .oneOf({"second", "frame"}),
      Row(kMorph | kRetime, "velocity-half", at<&J::velocityHalf>, "",
          "Velocities in 16-bit floats, also where the inputs have 32"),
      Row(kMorph, "add-velocity", at<&J::addVelocity>, "",
          "Add the inputs' own velocities (vel, v, velocity; world units per second), morphed"),
      Row(kMorph, "report", at<&J::reports>, "FILE.json|FILE.csv|FILE.html",
          "Measure every frame and write the figures; .csv: of every label or shape a line a frame; .html: a "
          "page with a 3D player, curves, pictures")
          .notInFrames()
          .basic(),
      Row(kMorph, "dump-slices", at<&J::sliceFolder>, "DIR",
          "Draw the slices with their contours and pairs, one SVG each")
          .needs(&MethodTraits::guided)
          .notInFrames(),
  };
}

Rows imageRows() {
  constexpr unsigned kReaders = kVoxelisers | kReconstruct | kInfo;
  return {
      Row(kVoxelisers | kReconstruct, "image", at<&J::imageKind>, "",
          "What an image's values are; auto: labels where whole numbers are mostly like their neighbours")
          .oneOf({"auto", "grey", "labels"}),
      Row(kReaders, "spacing", at<&J::spacing>, "X,Y,Z",
          "Of image stacks, and of DICOM files that do not tell it: pixel width, pixel height, gap between "
          "pictures")
          .as(OptionType::kNumbers)
          .unit("millimetres"),
      Row(kReaders, "force", at<&J::force>, "",
          "Read images all the same whose geometry is not certain (no positions, directions, spacing, gaps, "
          "mixed "
          "slices), as well as can be told; warnings say what is assumed"),
      Row(kMorph, "like", at<&J::like>, "IMAGE", "Put in-between images on the voxels of this one")
          .fallback("those of the first input, and more where shapes reach beyond"),
      Row(kApply, "like", at<&J::like>, "IMAGE", "Put the image or field on the voxels of this one")
          .fallback("the image's at that time, else WHAT's own; of a field those of 96 along the objects' "
                    "longest side"),
      Row(kConvert, "like", at<&J::like>, "IMAGE", "Put an image on the voxels of another one"),
      Row(kReconstruct, "like", at<&J::like>, "IMAGE", "Put the dense image on the voxels of this one"),
      Row(kReconstruct | kConvert, "source", at<&J::source>, "SERIES",
          "DICOM series (a folder, folder:2, a file) that structures are of: " + structureList() +
              " belong to its patient and name its images; surfaces and outlines are put on its slices")
          .fallback("none: patient and frame of reference of their own"),
      Row(kReconstruct | kConvert, "space", at<&J::space>, "",
          "Coordinates of meshes: LPS as everything, or RAS; auto: LPS, and scans' meshes say so (SPACE=LPS)")
          .oneOf({"auto", "LPS", "RAS"}),
      Row(kReconstruct | kConvert, "names", at<&J::names>, "N=NAME[,N=NAME...]",
          "Names of labels in " + structureList())
          .fallback("the structures' own, else label_N"),
      Row(kReconstruct, "axis", at<&J::axis>, "", "Array axis that the slices follow each other along")
          .oneOf({"auto", "i", "j", "k"}),
      Row(kReconstruct, "every", at<&J::every>, "N", "Every n-th slice is given, also where it is empty")
          .range(2, 10000)
          .fallback("found")
          .excludes({"between", "given"})
          .basic(),
      Row(kReconstruct, "given", at<&J::givenSlices>, "K,K[,K...]",
          "Numbers of the slices that are given, from 0; the others are filled in")
          .as(OptionType::kNumbers)
          .fallback("found")
          .excludes({"between", "every"})
          .basic(),
      Row(kReconstruct, "between", at<&J::between>, "N",
          "All slices are given; put N between every two of them")
          .range(1, 1000)
          .fallback("none")
          .excludes({"every", "given"})
          .basic(),
  };
}

Rows cameraRows() {
  constexpr unsigned kCameras = kMorph | kRender;
  const auto row = [&](const std::string& name, OptionField (*field)(JobOptions&), const std::string& form,
                       const std::string& help) {
    return Row(kCameras, name, field, form, help).target(OptionTarget::kPictures);
  };
  const auto numbers = OptionType::kNumbers;
  return {
      row("size", at<&J::picture, &PictureOptions::size>, "WxH", "Width and height of a picture")
          .unit("pixels")
          .basic(),
      row("view", at<&J::picture, &PictureOptions::view>, "DX,DY,DZ",
          "Direction from the camera into the scene")
          .as(numbers)
          .fallback("-0.55,-0.3,-1")
          .of(kCameras | kSurvey),
      row("up", at<&J::picture, &PictureOptions::up>, "x|y|z|DX,DY,DZ",
          "Direction that is up in the picture, and the turntable's axis")
          .as(numbers)
          .fallback("y")
          .of(kCameras | kSurvey),
      row("camera", at<&J::picture, &PictureOptions::camera>, "X,Y,Z", "Position of the camera")
          .as(numbers)
          .unit("world units")
          .fallback("where all is seen whole")
          .excludes({"view"}),
      row("look-at", at<&J::picture, &PictureOptions::lookAt>, "X,Y,Z", "Point that --camera looks at")
          .as(numbers)
          .unit("world units")
          .fallback("middle of all that is to be seen"),
      row("fov", at<&J::picture, &PictureOptions::fov>, "DEG", "Angle seen from bottom to top")
          .unit("degrees")
          .range(1, 170)
          .excludes({"ortho"}),
      row("ortho", at<&J::picture, &PictureOptions::ortho>, "", "Parallel rays, no perspective")
          .excludes({"fov"}),
      row("light", at<&J::picture, &PictureOptions::light>, "DX,DY,DZ",
          "Direction in which the main light shines")
          .as(numbers)
          .fallback("from the camera's upper left"),
      row("light-intensity", at<&J::picture, &PictureOptions::render, &RenderOptions::intensity>, "F",
          "Of the main light")
          .atLeast(0),
      row("extinction", at<&J::picture, &PictureOptions::extinction>, "F", "Of fog, at density 1")
          .unit("per world unit")
          .above(0)
          .fallback("its thickest is just opaque"),
      row("albedo", at<&J::picture, &PictureOptions::albedo>, "A|R,G,B",
          "Of fog: share of the light that is scattered, 0 to 1")
          .as(numbers)
          .fallback("0.85"),
      row("emission", at<&J::picture, &PictureOptions::emission>, "F",
          "Of fog: strength of the glow of its flame or temperature")
          .atLeast(0),
      row("transparent", at<&J::picture, &PictureOptions::transparent>, "", "No background"),
  };
}

Rows pictureRows() {
  return {
      Row(kMorph, "usd", at<&J::usd>, "",
          "What a .usda shows: VDB files beside it, name.####.vdb, as a volume, or all frames as one mesh")
          .oneOf({"auto", "volume", "mesh"})
          .fallback("mesh where all inputs are meshes, or of name.####.usda, else volume")
          .notInFrames(),
      Row(kMorph, "exr", at<&J::exrContent>, "",
          "What .exr frames hold: a rendered picture, or slices of all grids, one part each")
          .oneOf({"picture", "slices"}),
      Row(kRender, "contact-sheet", at<&J::contactSheet>, "FILE",
          "All pictures on one sheet, with captions: .png or .exr")
          .basic(),
      Row(kRender, "columns", at<&J::columns>, "N", "Columns of the contact sheet; 0: about as wide as high")
          .range(0, 1000),
      Row(kRender, "samples", at<&J::picture, &PictureOptions::render, &RenderOptions::samples>, "N",
          "Rays per pixel; of surfaces only where these end or turn")
          .range(1, 64),
      Row(kRender, "turntable", at<&J::turntable>, "N",
          "Pictures of a full turn around the up axis, during which a sequence plays once")
          .range(1, 100000)
          .fallback("no turn")
          .basic(),
  };
}

/// Where slices are cut and how they are written. For `morph` the names of options of the first kind
/// have a prefix.
Rows sliceRows(Command command, const std::string& prefix) {
  const auto row = [&](const std::string& name, OptionField (*field)(JobOptions&), const std::string& form,
                       const std::string& help) {
    return Row(command, name, field, form, help).target(OptionTarget::kExrSlices);
  };
  const std::string axis = prefix + "axis", spine = prefix + "spine", plane = prefix + "plane",
                    planes = prefix + "planes";
  Rows rows = {
      row(prefix + "slices", at<&J::slices, &SliceOptions::section, &SectionOptions::count>, "N", "Slices")
          .range(1, 100000)
          .excludes({plane, planes}),
      row(axis, at<&J::slices, &SliceOptions::axis>, "auto|x|y|z|DX,DY,DZ",
          "Slicing direction; auto: the volume's longest")
          .excludes({spine, plane, planes}),
      row(spine, at<&J::slices, &SliceOptions::spine>, "",
          "Slices lean: they stand across the shape's own curved axis")
          .excludes({axis, plane, planes}),
      row(plane, at<&J::slices, &SliceOptions::planes>, "OX,OY,OZ/NX,NY,NZ",
          "Slice here: a point and a normal; may be given again")
          .unit("world units")
          .excludes({axis, spine}),
      row(planes, at<&J::slices, &SliceOptions::planeFile>, "FILE",
          "Slice on the planes of a text or CSV file: ox oy oz nx ny nz a line")
          .excludes({axis, spine}),
      row("pixel-size", at<&J::slices, &SliceOptions::section, &SectionOptions::pixelSize>, "H",
          "Edge of a slice's pixel")
          .unit("world units")
          .above(0)
          .fallback("one voxel"),
      row("half", at<&J::slices, &SliceOptions::exr, &SliceExrOptions::halfFloat>, "",
          "Slices in 16-bit floats; whole numbers keep 32 bits"),
      row("compression", at<&J::slices, &SliceOptions::exr, &SliceExrOptions::compression>, "",
          "Of the slices' EXR files; from pxr24 on values lose precision")
          .oneOf(exrCompressions()),
      row("tiles", at<&J::slices, &SliceOptions::exr, &SliceExrOptions::tile>, "N",
          "Slices in tiles of N x N")
          .unit("pixels")
          .range(8, 65536)
          .fallback("scan lines"),
  };
  for (OptionRow& each : rows) each.basic = command == kSlice && each.name != "tiles";
  return rows;
}

Rows farmRows() {
  constexpr unsigned kWorkers =
      kDemo | kMatchers | kRetime | kSlice | kReconstruct | kConvert | kRender | kCompare;
  return {
      Row(kWorkers, "threads", at<&J::threads>, "N", "Threads to use; the result is the same")
          .range(1, 1024)
          .fallback("all")
          .notInFrames()
          .basic(),
      Row(kWorkers | kInfo, "memory", at<&J::memory>, "LIMIT",
          "Memory that may be taken, as 4G, 500M or 50% of what is free; what would need more ends with a "
          "message")
          .fallback("80% of what is free")
          .notInFrames(),
      Row(kMorph, "plan", at<&J::planFile>, "FILE.plan",
          "Take inputs, matching and the options that decide it from a file that `slicemorph plan` wrote; "
          "frames are the "
          "same bytes; name.####.plan for inputs that are sequences")
          .needs(&MethodTraits::guided)
          .notInFiles()
          .basic(),
      Row(kApply, "plan", at<&J::planFile>, "FILE.plan",
          "Take objects, matching and the options that decide it from a file that `slicemorph plan` wrote; "
          "then only "
          "WHAT is named")
          .basic(),
      Row(kMorph | kRetime, "resume", at<&J::resume>, "",
          "Go on with an interrupted sequence of the same settings")
          .notInFrames()
          .basic(),
      Row(kWorkers, "quiet", at<&J::quiet>, "", "Print nothing but errors")
          .excludes({"verbose"})
          .notInFrames()
          .basic(),
      Row(kWorkers, "verbose", at<&J::verbose>, "", "Print, too, how decisions were reached")
          .excludes({"quiet"})
          .notInFrames()
          .basic(),
      Row(kPick, "config", at<&J::config>, "FILE.toml",
          "Job file of `morph`, whose features are shown and whose options go on into the page's; the "
          "command line wins")
          .notInFiles()
          .basic(),
      Row(kSurvey, "config", at<&J::config>, "FILE.toml",
          "Job file of `morph`, of which inputs, matching, features and regions count; the command line wins")
          .notInFiles()
          .basic(),
      Row(kMorph, "config", at<&J::config>, "FILE.toml",
          "Take options from a file (key = value, keys as the long options, inputs, output; tables "
          "[[feature]] and [[region]]); the command line wins")
          .notInFiles()
          .basic(),
      Row(kMorph, "print-config", at<&J::printConfig>, "",
          "Print all options as such a file, and do nothing else")
          .notInFiles()
          .basic(),
  };
}

/// All rows, by groups in the order of the help.
Rows allRows() {
  const std::vector<std::pair<OptionGroup, Rows>> parts = {
      {OptionGroup::kInputs, inputRows()},
      {OptionGroup::kShape, shapeRows()},
      {OptionGroup::kMatching, matchingRows()},
      {OptionGroup::kOutputs, outputRows()},
      {OptionGroup::kOutputs, timeRows()},
      {OptionGroup::kOutputs, contentRows()},
      {OptionGroup::kImages, imageRows()},
      {OptionGroup::kPictures, pictureRows()},
      {OptionGroup::kPictures, cameraRows()},
      {OptionGroup::kPictures, sliceRows(kMorph, "exr-")},
      {OptionGroup::kPictures, sliceRows(kSlice, "")},
      {OptionGroup::kFarm, farmRows()}};
  Rows all;
  for (const auto& [group, rows] : parts)
    for (OptionRow row : rows) row.group = group, all.push_back(std::move(row));
  return all;
}

}  // namespace

const std::vector<OptionRow>& optionTable() {
  static const Rows rows = allRows();
  return rows;
}

}  // namespace slicemorph
