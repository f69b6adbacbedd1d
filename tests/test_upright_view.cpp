// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/map/upright_view.h>

#include <synthetic_scene.h>

#include <gtest/gtest.h>

namespace pcl_ssfr::test_upright_view {
namespace {

using apps::uprightView;

/// A hall of 20 x 12 x 4 m in a rotated frame: points on its faces, and their normals.
struct Hall {
  std::vector<Eigen::Vector3d> points, normals;
  std::vector<double> weights;

  explicit Hall(const Eigen::Matrix3d& R)
  {
    const Eigen::Vector3d half(10, 6, 2);
    for (int axis = 0; axis < 3; ++axis)
      for (const double side : {-1.0, 1.0}) {
        normals.emplace_back(R * (-side * Eigen::Vector3d::Unit(axis)));
        weights.push_back(axis == 2 ? 3 : 1);
        for (double u = -0.9; u < 1; u += 0.2)
          for (double v = -0.9; v < 1; v += 0.2) {
            Eigen::Vector3d p;
            p[axis] = side;
            p[(axis + 1) % 3] = u;
            p[(axis + 2) % 3] = v;
            points.emplace_back(R * p.cwiseProduct(half));
          }
      }
  }
};

/// Axes go onto axes, in any order and sign.
void
expectAxes(const Eigen::Matrix3d& M)
{
  EXPECT_GT(M.cwiseAbs().rowwise().maxCoeff().minCoeff(), 0.9999) << M;
  EXPECT_NEAR(M.determinant(), 1, 1e-9);
}

TEST(UprightView, aHallInAnyFrame)
{
  testing::Random random(4);
  for (int round = 0; round < 50; ++round) {
    const Eigen::Matrix3d R = testing::randomRotation(random);
    const Hall hall(R);
    std::vector<Eigen::Vector3d> axes;
    for (int i = 0; i < 6; ++i)
      axes.emplace_back(testing::randomRotation(random).col(2));
    const Eigen::Matrix3d view = uprightView(hall.points, hall.normals, hall.weights, axes);
    expectAxes(view * R);
    EXPECT_GT(std::abs((view * R)(2, 2)), 0.9999); // the least extent is the height
  }
}

TEST(UprightView, levelScansDecideAgainstTheExtents)
{
  // The same hall as a tower: its longest extent is the height, and its scans are nearly level.
  const Eigen::Matrix3d R = Eigen::AngleAxisd(1.5707963267948966, Eigen::Vector3d::UnitY()).toRotationMatrix();
  const Hall hall(R);
  const std::vector<Eigen::Vector3d> axes = {Eigen::Vector3d(0.05, 0, 1).normalized(),
                                             Eigen::Vector3d(-0.02, 0.04, 1).normalized()};
  const Eigen::Matrix3d view = uprightView(hall.points, hall.normals, hall.weights, axes);
  EXPECT_GT(view(2, 2), 0.9999);
  expectAxes(view * R);
}

TEST(UprightView, nothingIsDrawnAsItIs)
{
  EXPECT_TRUE(uprightView({}, {}, {}, {}).isIdentity(1e-12));
  const Eigen::Matrix3d one = uprightView({Eigen::Vector3d(1, 2, 3)}, {}, {}, {Eigen::Vector3d::UnitZ()});
  EXPECT_TRUE(one.isIdentity(1e-12));
}

} // namespace
} // namespace pcl_ssfr::test_upright_view
