#include "engine/volume/repair_mesh.h"

#include "engine/volume/agree_on_winding.h"
#include "engine/volume/mesh_measures.h"
#include "engine/volume/repair_note.h"
#include "engine/volume/triangulate_faces.h"
#include "engine/volume/turn_outwards.h"
#include "engine/volume/weld_points.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <sstream>

namespace slicemorph {
namespace {

using openvdb::Vec3I;
using openvdb::Vec3s;

/// The counts of what cleaning changes, beside the topology.
struct Changes {
  const WeldedPoints& welded;
  const TriangulatedFaces& faces;
  const AgreedWinding& winding;
  const BoundaryLoops& boundary;
};

Notes notesOf(const Changes& c) {
  Notes notes;
  const auto say = [&](size_t count, const char* code, const std::string& before, const std::string& noun,
                       const std::string& after = "") {
    if (count > 0) notes.push_back(repairNote(code, Severity::kNote, before + countOf(count, noun) + after));
  };
  say(c.faces.polygons, "mesh.triangulated", "triangulated ", "polygon");
  say(c.welded.merged, "mesh.welded", "welded ", "duplicate point");
  say(c.welded.unused, "mesh.unused-points", "dropped ", "point", " that no face uses");
  say(c.faces.degenerate, "mesh.degenerate-faces", "dropped ", "degenerate face");
  say(c.faces.duplicate, "mesh.duplicate-faces", "dropped ", "duplicate face");
  say(c.winding.turned, "mesh.faces-turned", "turned ", "face", " wound against the neighbours");
  say(c.winding.nonManifold, "mesh.not-manifold", "", "edge",
      " with more than two faces: kept, the inside is what cannot be reached from outside");
  say(c.boundary.strays, "mesh.slits", "left ", "open edge",
      " beside those as they are: voxels close such slits");
  return notes;
}

CleanedMesh clean(const PolygonMesh& input) {
  CleanedMesh c;
  WeldedPoints welded = weldPoints(input);
  TriangulatedFaces faces = triangulateFaces(input, welded);
  c.mesh.points = std::move(welded.points);
  c.mesh.triangles = std::move(faces.triangles);
  MeshTopology& found = c.found;
  found.weldedPoints = welded.merged;
  found.unusedPoints = welded.unused;
  found.diagonal = c.mesh.points.empty() ? 0 : boundsOf(c.mesh.points).extents().length();
  for (const Vec3I& t : c.mesh.triangles) {
    found.signedVolume += signedVolume(c.mesh.points, t, Vec3d(c.mesh.points[c.mesh.triangles[0][0]]));
  }
  AgreedWinding winding = agreeOnWinding(std::move(c.mesh.triangles));
  c.mesh.triangles = std::move(winding.triangles);
  c.boundary = findBoundary(c.mesh.triangles, c.mesh.points.size());
  found.shells = winding.shells;
  found.nonManifoldEdges = winding.nonManifold;
  found.twistedEdges = winding.twisted;
  found.boundaryEdges = c.boundary.edges;
  std::vector<double> lengths;
  for (const PointLoop& loop : c.boundary.loops) lengths.push_back(loopLength(c.mesh.points, loop));
  if (c.boundary.strays > 0) lengths = boundaryParts(c.mesh);
  found.boundaryLoops = lengths.size();
  for (double length : lengths) found.longestLoop = std::max(found.longestLoop, length);
  c.notes = notesOf({welded, faces, winding, c.boundary});
  c.patch = std::move(winding.patch);
  c.piece = std::move(winding.piece);
  c.shell = std::move(winding.shell);
  return c;
}

/// Boundary edges that form no loop, as beside edges with more than two faces, are slits where they are short: nothing
/// is filled there, and voxels close them. Length in the bounding box's diagonals; the faces of a scanned animal are
/// .01.
constexpr double kLongestSlit = 0.05;

bool tooLarge(const CleanedMesh& c) {
  return c.found.longestLoop > (c.boundary.strays > 0 ? kLongestSlit : kLargestHole) * c.found.diagonal;
}

void noteTurned(const TurnedParts& turned, Notes& notes) {
  if (turned.insideOut)
    notes.push_back(repairNote("mesh.inside-out", Severity::kNote,
                               "turned " + countOf(turned.insideOut, "inside-out shell") + " outwards"));
  if (turned.cavities)
    notes.push_back(repairNote(
        "mesh.cavities-filled", Severity::kWarning,
        turned.cavities == 1
            ? "1 shell is a cavity inside another: filled as solid"
            : std::to_string(turned.cavities) + " shells are cavities inside others: filled as solid"));
}

}  // namespace

CleanedMesh cleanMesh(const PolygonMesh& input) {
  CleanedMesh c = clean(input);
  if (c.mesh.triangles.empty()) throw GeometryError("the mesh has no faces; a closed surface is needed");
  return c;
}

std::string whyNotClosed(const CleanedMesh& c) {
  const MeshTopology& f = c.found;
  if (f.twistedEdges == 0 && !tooLarge(c)) return "";
  std::ostringstream why;
  why << (f.twistedEdges > 0 ? "the surface is not orientable" : "the surface is open") << ": "
      << countOf(f.boundaryEdges, "boundary edge") << " in " << countOf(f.boundaryLoops, "loop");
  if (f.boundaryLoops > 0) {
    why << ", the longest " << withDigits(f.longestLoop, 4) << " long ("
        << withDigits(f.longestLoop / f.diagonal, 4) << " of the bounding box's diagonal of "
        << withDigits(f.diagonal, 4) << ")";
  }
  why << ", " << countOf(f.nonManifoldEdges, "edge") << " with more than two faces, "
      << countOf(f.twistedEdges, "edge") << " where no winding agrees, " << countOf(f.shells, "shell");
  return why.str();
}

RepairedMesh closeMesh(CleanedMesh c) {
  RepairedMesh result;
  result.notes = std::move(c.notes);
  for (const PointLoop& loop : c.boundary.loops) fillHole(c.mesh, loop);
  if (!c.boundary.loops.empty()) {
    result.notes.push_back(repairNote("mesh.holes-filled", Severity::kNote,
                                      "filled " + countOf(c.boundary.loops.size(), "hole") + " (" +
                                          countOf(c.boundary.edges - c.boundary.strays, "edge") + ")"));
  }
  AgreedWinding winding = agreeOnWinding(std::move(c.mesh.triangles));
  c.mesh.triangles = std::move(winding.triangles);
  TurnedParts turned = turnOutwards(c.mesh, winding.patch);
  noteTurned(turned, result.notes);
  result.turned = std::move(turned.triangles);
  result.mesh = std::move(c.mesh);
  result.found = c.found;
  return result;
}

RepairedMesh repairMesh(const PolygonMesh& input) {
  CleanedMesh c = cleanMesh(input);
  const std::string why = whyNotClosed(c);
  if (why.empty()) return closeMesh(std::move(c));
  std::ostringstream needed;
  needed << why << "; needed is a closed surface that has an inside: ";
  if (c.boundary.strays > 0)
    needed << "slits beside edges with more than two faces may be " << kLongestSlit
           << " of the diagonal long";
  else
    needed << "holes up to " << kLargestHole
           << " of the diagonal are filled, larger ones must be closed first";
  throw GeometryError(needed.str());
}

MeshTopology inspectMesh(const PolygonMesh& mesh) { return clean(mesh).found; }

}  // namespace slicemorph
