#pragma once

#include "engine/render/film.h"

#include <vector>

/// Pictures of fog: OpenVDB's ray tracer finds where a ray meets it; absorption, light and glow are ours.
namespace slicemorph {

/// Grids on any linear transforms, each on its own.
struct Fog {
  FloatGrid::ConstPtr density;
  FloatGrid::ConstPtr heat;             ///< flame or temperature; null: it does not glow
  openvdb::Vec3SGrid::ConstPtr colour;  ///< of the fog, linear light; null: as the look says
};

/// What is measured of a fog to choose its look.
struct FogMeasure {
  openvdb::BBoxd box;    ///< world, of the active voxels of density and heat; empty: there are none
  double thickness = 0;  ///< world units: edge of the cube that holds as much fog of the mean density
  double density = 0;    ///< the mean over the fog itself
  double hottest = 0;    ///< the largest heat
};

/// Throws InputError for transforms that are not linear.
FogMeasure measureFog(const Fog& fog);

/// How a fog looks.
struct FogLook {
  double extinction = 1;               ///< per world unit, at density 1
  Colour albedo{0.85f, 0.85f, 0.85f};  ///< share of the light met that is scattered, 0 to 1
  double hottest = 0;                  ///< the heat that is drawn as a black body of 2200 K; 0: nothing glows
  double emission = 0;                 ///< per world unit, there; falls with the fourth power of the heat
};

/// The look that serves all of a sequence: the thickest fog is just opaque, the hottest place of all is
/// brightest. Fogs without density do not count.
FogLook lookOf(const std::vector<FogMeasure>& measures);

/// The picture of a fog, lit by the key light (single scattering, with an estimate of further) and the sky.
/// Depth is the mean over the pixel, weighted by what it adds to the opacity; normals are zero. The camera
/// may be inside. Throws InputError for options out of range and transforms that are not linear.
Picture renderFog(const Fog& fog, const FogLook& look, const Camera& camera,
                  const RenderOptions& options = {});

}  // namespace slicemorph
