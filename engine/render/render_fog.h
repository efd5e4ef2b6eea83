#pragma once

#include "engine/render/film.h"

#include <vector>

/// Pictures of fog: OpenVDB's ray tracer finds where a ray meets it; absorption, light and glow
/// are computed here.
namespace slicemorph {

/// The grids of a fog; each may have its own linear transform.
struct Fog {
  FloatGrid::ConstPtr density;
  FloatGrid::ConstPtr heat;             ///< flame or temperature; null: nothing glows
  openvdb::Vec3SGrid::ConstPtr colour;  ///< of the fog, linear light; null: FogLook::albedo
};

/// Measures of a fog from which its look is chosen.
struct FogMeasure {
  openvdb::BBoxd box;    ///< world, of the active voxels of density and heat; empty: there are none
  double thickness = 0;  ///< world units: edge of the cube that would hold the fog at its mean density
  double density = 0;    ///< mean of the density, weighted by the density
  double hottest = 0;    ///< largest heat
};

/// Throws InputError for transforms that are not linear.
FogMeasure measureFog(const Fog& fog);

/// The appearance of a fog.
struct FogLook {
  double extinction = 1;               ///< per world unit, at density 1
  Colour albedo{0.85f, 0.85f, 0.85f};  ///< scattered share of the incoming light, 0 to 1
  double hottest = 0;                  ///< heat drawn as a black body of 2200 K; 0: nothing glows
  double emission = 0;  ///< per world unit, at `hottest`; proportional to the fourth power of the heat
};

/// One look for a whole sequence: the thickest fog is just opaque, and the hottest point of all is brightest.
/// Fogs without density are ignored.
FogLook lookOf(const std::vector<FogMeasure>& measures);

/// A picture of a fog lit by the key light (single scattering, with an estimate of multiple scattering) and
/// the sky. Depth is the mean over the pixel, weighted by the opacity that each part adds; normals are
/// zero. The camera may be inside the fog. Throws InputError for options out of range and transforms that
/// are not linear.
Picture renderFog(const Fog& fog, const FogLook& look, const Camera& camera,
                  const RenderOptions& options = {});

}  // namespace slicemorph
