#include "engine/volume/solid_of_mesh.h"

#include "engine/volume/agree_on_winding.h"
#include "engine/volume/face_outwards.h"
#include "engine/volume/find_sheets.h"
#include "engine/volume/mesh_measures.h"
#include "engine/volume/repair_note.h"
#include "engine/volume/small_components.h"
#include "engine/volume/surface_samples.h"
#include "engine/volume/thin_parts.h"
#include "engine/volume/turn_outwards.h"
#include "engine/volume/voxelise.h"
#include "engine/volume/winding_solid.h"
#include "slicemorph/errors.h"

#include <openvdb/tools/ChangeBackground.h>
#include <openvdb/tools/Composite.h>
#include <openvdb/tools/Prune.h>
#include <openvdb/tools/SignedFloodFill.h>
#include <openvdb/tree/LeafManager.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>

namespace slicemorph {
namespace {

using openvdb::Vec3I;
using Index = std::uint32_t;

/// Thickness of a sheet, voxels: the least that has a voxel inside wherever the lattice lies (its diagonal), and the
/// one that is proposed.
constexpr double kLeastShell = 1.75, kGoodShell = 2.5;
/// How closely a surface is looked at to tell whether winding numbers disagree, voxels: the spacing of points on it,
/// and how far beside it. What is thinner is lost in voxels anyhow.
constexpr double kCheckSpacing = 3, kCheckBeside = 1.5;
constexpr size_t kMostChecks = 1 << 20;

/// Two digits, which is as exact as a proposal needs to be.
std::string roughly(double value) { return withDigits(value, 2); }

/// Faces the patches of a mesh outwards and takes its sheets out.
void sortOut(SolidMesh& solid, const CleanedMesh& clean) {
  Mesh& mesh = solid.mesh;
  const std::vector<std::vector<Index>> shells = trianglesOfSets(clean.shell);
  auto winding = std::make_unique<WindingNumber>(mesh);
  size_t turned = faceOutwards(mesh, clean.patch, *winding);
  if (clean.piece != clean.patch) turned += facePiecesOutwards(mesh, clean.piece, *winding);
  if (turned > 0) {
    solid.notes.push_back(
        repairNote("mesh.patches-turned", Severity::kNote,
                   "turned " + countOf(turned, "face") + " of patches seen from their backs"));
    winding = std::make_unique<WindingNumber>(mesh);
  }
  const std::vector<size_t> sheets = findSheets(mesh, shells, *winding);
  winding.reset();
  solid.shells = shells.size();
  solid.sheetShells = sheets.size();
  if (sheets.empty()) return;
  std::vector<char> isSheet(mesh.triangles.size(), 0);
  for (size_t s : sheets)
    for (Index t : shells[s]) isSheet[t] = 1;
  std::vector<Vec3I> kept;
  for (size_t t = 0; t < mesh.triangles.size(); ++t)
    (isSheet[t] ? solid.sheets.triangles : kept).push_back(mesh.triangles[t]);
  solid.sheets.points = mesh.points;
  mesh.triangles = std::move(kept);
}

openvdb::BBoxd boxOf(const Mesh& mesh) {
  openvdb::BBoxd box;
  for (const Vec3I& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) box.expand(Vec3d(mesh.points[t[k]]));
  return box;
}

/// World points beside triangles that, as a level set has it, are no wall between inside and outside.
std::vector<Vec3d> doubtfulPoints(const FloatGrid& grid, const Mesh& mesh) {
  const double h = grid.voxelSize()[0];
  std::vector<Index> all(mesh.triangles.size());
  std::iota(all.begin(), all.end(), Index(0));
  const double count = areaOf(mesh) / (kCheckSpacing * kCheckSpacing * h * h);
  const FloatGrid::ConstAccessor values = grid.getConstAccessor();
  const auto valueAt = [&](const Vec3d& p) {
    return values.getValue(grid.transform().worldToIndexNodeCentered(p));
  };
  std::vector<Vec3d> doubtful;
  for (const SurfacePoint& s :
       sampleSurface(mesh, all, size_t(std::clamp(count, 1.0, double(kMostChecks))))) {
    const Vec3d aside = kCheckBeside * h * s.normal;
    const double front = valueAt(s.point + aside), back = valueAt(s.point - aside);
    if ((front < 0) != (back < 0)) continue;
    if (std::abs(front) > h) doubtful.push_back(s.point + aside);
    if (std::abs(back) > h) doubtful.push_back(s.point - aside);
  }
  return doubtful;
}

/// Whether winding numbers say that what a level set has inside is outside, or the other way round.
bool isContradicted(const FloatGrid& grid, const std::vector<Vec3d>& points, const WindingNumber& winding) {
  const FloatGrid::ConstAccessor values = grid.getConstAccessor();
  return std::any_of(points.begin(), points.end(), [&](const Vec3d& p) {
    return (values.getValue(grid.transform().worldToIndexNodeCentered(p)) < 0) != (winding.at(p) > 0.5);
  });
}

/// A mesh with several shells that is closed: its inside is what cannot be reached from outside, but for cavities and
/// pockets.
FloatGrid::Ptr voxeliseClosed(SolidMesh& solid, double voxelSize) {
  FloatGrid::Ptr grid = voxelise(solid.mesh, voxelSize);
  // One clean shell has nothing that could disagree, and costs nothing more.
  if (solid.found.shells == 1 && solid.found.nonManifoldEdges == 0) return grid;
  const std::vector<Vec3d> doubtful = doubtfulPoints(*grid, solid.mesh);
  if (doubtful.empty()) return grid;
  turnOver(solid.mesh, solid.turned);  // as found, and then outwards but for cavities
  AgreedWinding agreed = agreeOnWinding(solid.mesh.triangles);
  solid.mesh.triangles = std::move(agreed.triangles);
  auto winding = std::make_unique<WindingNumber>(solid.mesh);
  if (faceOutwards(solid.mesh, agreed.patch, *winding) > 0)
    winding = std::make_unique<WindingNumber>(solid.mesh);
  if (!isContradicted(*grid, doubtful, *winding)) return grid;
  grid = windingLevelSet(solid.mesh, *winding, voxelSize);
  Notes& notes = solid.notes;
  notes.erase(std::remove_if(notes.begin(), notes.end(),
                             [](const Note& n) { return n.code == "mesh.cavities-filled"; }),
              notes.end());
  notes.push_back(repairNote("mesh.by-winding", Severity::kNote,
                             "its " + countOf(solid.found.shells, "shell") +
                                 " have cavities or pockets between them: kept, the inside is where the "
                                 "winding number is above 1/2"));
  return grid;
}

/// Level set of all points within half of `thickness` of a mesh.
FloatGrid::Ptr thickened(const Mesh& sheets, double voxelSize, double thickness) {
  const float background = float(kHalfWidth * voxelSize), half = float(thickness / 2);
  FloatGrid::Ptr grid = unsignedDistance(sheets, voxelSize, thickness / 2 / voxelSize + kHalfWidth + 1);
  openvdb::tree::LeafManager<openvdb::FloatTree>(grid->tree()).foreach ([&](auto& leaf, size_t) {
    for (auto value = leaf.beginValueOn(); value; ++value) {
      const float d = *value - half;
      value.setValue(std::clamp(d, -background, background));
      if (std::abs(d) >= background) value.setValueOff();
    }
  });
  openvdb::tools::changeBackground(grid->tree(), background);
  openvdb::tools::signedFloodFill(grid->tree());
  openvdb::tools::pruneLevelSet(grid->tree());
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  return grid;
}

/// The same points as `mesh` in one grid with sheets of a thickness.
FloatGrid::Ptr withSheets(FloatGrid::Ptr solid, const SolidMesh& mesh, double voxelSize, double thickness) {
  if (mesh.sheets.triangles.empty() || thickness == 0) return solid;
  FloatGrid::Ptr sheets = thickened(mesh.sheets, voxelSize, thickness);
  if (!solid) return sheets;
  openvdb::tools::csgUnion(*solid, *sheets);
  return solid;
}

void noteSheets(SolidMesh& mesh, const SolidOptions& options) {
  if (options.shell > 0 && mesh.sheets.triangles.empty())
    mesh.notes.push_back(
        repairNote("mesh.no-sheets", Severity::kNote, "--shell is not needed: no shell is a mere sheet"));
  if (mesh.sheets.triangles.empty()) return;
  std::ostringstream text;
  const double voxelSize = voxelSizeOf(mesh, options);
  const bool one = mesh.sheetShells == 1, all = mesh.sheetShells == mesh.shells;
  if (all)
    text << (one ? "its only shell" : "all its " + countOf(mesh.shells, "shell"));
  else
    text << mesh.sheetShells << " of " << countOf(mesh.shells, "shell");
  text << (one ? " is a sheet that encloses nothing" : " are sheets that enclose nothing") << " (area "
       << roughly(areaOf(mesh.sheets)) << "): ";
  if (options.shell > 0)
    text << "made " << options.shell << " thick";
  else
    text << "left out; --shell " << roughly(kGoodShell * voxelSize) << " makes them solid";
  mesh.notes.push_back(
      repairNote("mesh.sheets", options.shell > 0 ? Severity::kNote : Severity::kWarning, text.str()));
}

/// What walls thinner than a voxel lose of the area is told from this share on. Chosen by hand.
constexpr double kLostWorthTelling = 0.01;

/// The level set of a mesh with walls thinner than a voxel made thicker where their loss would sever its parts, as a hoof
/// from a leg that is crumpled flat.
FloatGrid::Ptr unsevered(FloatGrid::Ptr levelSet, SolidMesh& mesh) {
  const double lost = lostShare(mesh.mesh, *levelSet);
  const int pieces = lost > 0 ? countPieces(*levelSet) : 1;
  FloatGrid::Ptr thick = pieces > 1 ? withThinWalls(*levelSet, mesh.mesh) : nullptr;
  const bool severed = thick && countPieces(*thick) < pieces;
  if (!severed && lost < kLostWorthTelling) return levelSet;
  std::ostringstream text;
  text << (lost < kLostWorthTelling ? "less than 1" : "about " + std::to_string(std::lround(100 * lost)))
       << " % of its surface bounds walls thinner than a voxel of " << roughly(levelSet->voxelSize()[0])
       << (severed ? ", which join its parts: they are made " + withDigits(kKeptWall, 2) + " voxels thick; "
                   : ", which are lost in part or wholly: ")
       << "smaller voxels (--resolution, --voxel-size) keep them" << (severed ? " as they are" : "");
  mesh.notes.push_back(repairNote("mesh.thin-walls", Severity::kNote, text.str()));
  return severed ? thick : levelSet;
}

}  // namespace

SolidMesh prepareSolid(const PolygonMesh& polygons) {
  CleanedMesh clean = cleanMesh(polygons);
  SolidMesh solid;
  solid.found = clean.found;
  solid.shells = clean.found.shells;
  solid.open = whyNotClosed(clean);
  solid.closed = solid.open.empty();
  if (solid.closed) {
    RepairedMesh closed = closeMesh(std::move(clean));
    solid.mesh = std::move(closed.mesh);
    solid.turned = std::move(closed.turned);
    solid.notes = std::move(closed.notes);
    return solid;
  }
  solid.notes = std::move(clean.notes);
  solid.mesh = std::move(clean.mesh);
  sortOut(solid, clean);
  if (!solid.mesh.triangles.empty())
    solid.notes.push_back(repairNote(
        "mesh.by-winding", Severity::kWarning,
        solid.open +
            ": its inside is where the winding number is above 1/2, which closes holes of any size"));
  return solid;
}

double voxelSizeOf(const SolidMesh& mesh, const SolidOptions& options) {
  if (options.voxelSize > 0) return options.voxelSize;
  openvdb::BBoxd box = boxOf(mesh.mesh);
  if (options.shell > 0 || mesh.mesh.triangles.empty()) box.expand(boxOf(mesh.sheets));
  const double longest =
      box.extents()[int(box.maxExtent())] + (mesh.sheets.triangles.empty() ? 0 : options.shell);
  return longest / options.resolution;
}

void refuseSheets(const SolidMesh& mesh, const SolidOptions& options) {
  std::ostringstream why;
  const double voxelSize = voxelSizeOf(mesh, options), shell = options.shell;
  if (!(shell >= 0) || !std::isfinite(shell)) {
    why << "--shell " << shell << " is no positive thickness in world units";
    throw InputError(why.str());
  }
  if (mesh.sheets.triangles.empty()) return;
  if (shell > 0 && shell < kLeastShell * voxelSize) {
    why << "--shell " << shell << " is less than " << kLeastShell << " voxels of " << voxelSize
        << ", too thin to be seen: use at least " << roughly(1.05 * kLeastShell * voxelSize)
        << " or smaller voxels";
    throw InputError(why.str());
  }
  if (shell > 0 || !mesh.mesh.triangles.empty()) return;
  const bool one = mesh.shells == 1;
  why << mesh.open
      << (one ? "; it is a sheet that encloses nothing" : "; they are sheets that enclose nothing")
      << ": --shell " << roughly(kGoodShell * voxelSize) << " makes " << (one ? "it a solid" : "them solids")
      << " of that thickness (" << kGoodShell << " voxels)";
  throw GeometryError(why.str());
}

Notes inOneLine(Notes notes) {
  if (notes.size() < 2) return notes;
  Note all("mesh.repaired", Severity::kNote, "", "");
  for (Note& note : notes) {
    all.text += (all.text.empty() ? "" : "; ") + note.text;
    all.severity = std::max(all.severity, note.severity);
    note.severity = Severity::kDetail;
  }
  notes.insert(notes.begin(), std::move(all));
  return notes;
}

MeshSolid solidOf(SolidMesh mesh, const SolidOptions& options) {
  refuseSheets(mesh, options);
  noteSheets(mesh, options);
  const double voxelSize = voxelSizeOf(mesh, options);
  MeshSolid solid;
  if (mesh.closed)
    solid.levelSet = voxeliseClosed(mesh, voxelSize);
  else if (!mesh.mesh.triangles.empty())
    solid.levelSet = windingLevelSet(mesh.mesh, WindingNumber(mesh.mesh), voxelSize);
  if (solid.levelSet) solid.levelSet = unsevered(std::move(solid.levelSet), mesh);
  solid.levelSet = withSheets(std::move(solid.levelSet), mesh, voxelSize, options.shell);
  solid.notes = inOneLine(std::move(mesh.notes));
  return solid;
}

}  // namespace slicemorph
