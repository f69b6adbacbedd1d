// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#pragma once

#include <apps/common/random_stream.h>
#include <apps/simulation/surface_model.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <vector>

/// What scenes are built of. Every part stands with its foot at the origin, its back towards -y, its front to +y.
namespace pcl_ssfr::simulation::parts {

/// What things are made of; reflectances at about 905 nm are rounded values of common materials.
enum class Stuff {
  Plaster,
  Wood,
  DarkWood,
  Asphalt,
  Glass,
  DarkCloth,
  LightCloth,
  Metal,
  Concrete,
  Foliage,
  Brick,
  Tile,
  WhitePlastic,
  BlackPlastic,
  Carpet,
  Paper,
  DarkPaint,
  LightPaint,
  Rubber,
  Stone,
  Skin
};

/// The index of a material in the model, added when it is new.
std::uint16_t
paint(SurfaceModel& model, Stuff stuff);

/// Pose of something that stands on \p foot, rotated by \p yaw [rad] about the vertical.
Eigen::Isometry3d
standAt(const Eigen::Vector3d& foot, double yaw = 0);

/// A rectangle along the axes [m].
struct Rect {
  double x0 = 0;
  double y0 = 0;
  double x1 = 0;
  double y1 = 0;

  double
  width() const
  {
    return x1 - x0;
  }
  double
  depth() const
  {
    return y1 - y0;
  }
  Eigen::Vector2d
  centre() const
  {
    return {(x0 + x1) / 2, (y0 + y1) / 2};
  }
  Rect
  grown(double by) const
  {
    return {x0 - by, y0 - by, x1 + by, y1 + by};
  }
};

/// What fills an opening of a wall.
enum class Filling {
  None,   ///< a passage
  Window, ///< a pane in a frame
  Shut,   ///< a door that is never opened
  Door    ///< a leaf of its own: Scene::doors
};

/// A rectangular opening of a wall.
struct Opening {
  double centre = 0; ///< along the wall [m]
  double width = 1;  ///< [m]
  double bottom = 0; ///< above the foot of the wall [m]
  double top = 2.1;  ///< [m]
  Filling filling = Filling::None;
  int side = 1;              ///< Door: opens to the left (1) or right (-1) of the wall's direction
  bool hinge_at_end = false; ///< Door
};

/// A straight upright wall; its line runs in the middle of its thickness.
struct Wall {
  Eigen::Vector2d from = Eigen::Vector2d::Zero(); ///< [m]
  Eigen::Vector2d to = Eigen::Vector2d::Zero();   ///< [m]
  double thickness = 0.12;                        ///< [m]
  std::vector<Opening> openings;                  ///< apart from each other
  Stuff stuff = Stuff::Plaster;
};

/// The wall from height \p z to \p z + \p height; longer by half its thickness at both ends, so that corners close.
void
addWall(SurfaceModel& model, const Wall& wall, double z, double height);
/// A horizontal slab whose upper face is at \p top, with rectangular holes.
void
addSlab(SurfaceModel& model,
        const Rect& outline,
        double top,
        double thickness,
        const std::vector<Rect>& holes,
        Stuff stuff);
/// A straight flight of solid steps that climbs to +y from the origin, with its middle on x = 0.
SurfaceModel
makeStairs(double width, int steps, double rise, double tread, Stuff stuff);
/// Posts, a handrail and bars between two points of the same height.
void
addRailing(SurfaceModel& model, const Eigen::Vector3d& from, const Eigen::Vector3d& to, double height);
/// A tube between two points.
void
addPipe(SurfaceModel& model, const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius, Stuff stuff);
/// A flat disc with \p sides triangles.
void
addDisc(SurfaceModel& model,
        const Eigen::Vector3d& centre,
        const Eigen::Vector3d& normal,
        double radius,
        int sides,
        Stuff stuff);
/// An upright ellipsoid of triangles, its surface moved along the radius by noise of height \p bump [m].
void
addBlob(SurfaceModel& model,
        const Eigen::Vector3d& centre,
        const Eigen::Vector3d& radii,
        int rings,
        double bump,
        std::uint64_t seed,
        Stuff stuff);
/// A hexahedron: four corners below and four above, each counter-clockwise seen from above.
void
addHexahedron(SurfaceModel& model,
              const std::vector<Eigen::Vector3d>& below,
              const std::vector<Eigen::Vector3d>& above,
              Stuff stuff);
/// A flat convex polygon with any number of corners.
void
addConvexPolygon(SurfaceModel& model, const std::vector<Eigen::Vector3d>& corners, std::uint16_t material);

/// Smooth noise in about [-1, 1] with features of about 1 m; twice continuously differentiable.
double
smoothNoise(const Eigen::Vector3d& point, std::uint64_t seed);

// Furniture. Sizes vary with the random numbers.
SurfaceModel
makeTable(RandomStream& random, double width, double depth);
SurfaceModel
makeChair(RandomStream& random);
SurfaceModel
makeOfficeChair(RandomStream& random);
SurfaceModel
makeDesk(RandomStream& random);
SurfaceModel
makeShelf(RandomStream& random, double width, double height);
SurfaceModel
makeCupboard(RandomStream& random, double width, double depth, double height);
SurfaceModel
makeBed(RandomStream& random, double width);
SurfaceModel
makeSofa(RandomStream& random, double width);
SurfaceModel
makeKitchenRow(RandomStream& random, double width);
SurfaceModel
makeBathTub();
SurfaceModel
makeToilet();
SurfaceModel
makeWashBasin(RandomStream& random);
SurfaceModel
makeRadiator(double width);
SurfaceModel
makePlant(RandomStream& random);
SurfaceModel
makeBox(RandomStream& random);
SurfaceModel
makeBench(RandomStream& random);
SurfaceModel
makePicture(RandomStream& random);
/// Hangs from the ceiling: the origin is the point of suspension.
SurfaceModel
makePendantLamp(RandomStream& random);
/// A flat lamp under a ceiling: the origin is on the ceiling.
SurfaceModel
makePanelLamp(double length);

// Out of doors.
SurfaceModel
makeCar(RandomStream& random);
SurfaceModel
makeTree(RandomStream& random);
SurfaceModel
makeLampPost(RandomStream& random);
SurfaceModel
makeSign(RandomStream& random);
SurfaceModel
makeBin(RandomStream& random);

/// A standing person, 1.55 to 1.95 m, within 0.3 m of its middle.
SurfaceModel
makePerson(RandomStream& random);

} // namespace pcl_ssfr::simulation::parts
