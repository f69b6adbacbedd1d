// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "multiway/pose_graph.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <Eigen/Eigenvalues>

#include <cmath>

namespace pcl_ssfr {

namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double kRobustScale = 3; ///< of Cauchy's loss, in standard deviations of a whole edge
/// No edge is better known: dense scans claim far more than they know.
constexpr double kLeastSigma = 0.002, kLeastSigmaRotation = 0.0005; ///< [m], [rad]
constexpr int kIterations = 50;

/// A pose as Ceres moves it.
struct Parameters {
  Eigen::Quaterniond rotation;
  Eigen::Vector3d translation;
};

/// A matrix whose product with a motion has the length that the information gives it, bounded by what edges can know.
Matrix6
squareRoot(const Matrix6& information)
{
  // In units in which both kinds of motion are bounded alike.
  Eigen::Matrix<double, 6, 1> units;
  units << Eigen::Vector3d::Constant(kLeastSigmaRotation), Eigen::Vector3d::Constant(kLeastSigma);
  const Matrix6 scaled = units.asDiagonal() * (0.5 * (information + information.transpose())) * units.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix6> solver(scaled);
  // Information l of a motion and the bound of 1 together: 1 / (1 / l + 1).
  const auto root = [](double l) { return l > 0 ? std::sqrt(l / (1 + l)) : 0.0; };
  const Eigen::Matrix<double, 6, 1> roots = solver.eigenvalues().unaryExpr(root);
  return roots.asDiagonal() * solver.eigenvectors().transpose() * units.cwiseInverse().asDiagonal();
}

struct EdgeError {
  Eigen::Matrix3d R_measured; ///< target from source
  Eigen::Vector3d t_measured;
  Matrix6 weight;

  template <typename T>
  bool
  operator()(const T* q_source, const T* t_source, const T* q_target, const T* t_target, T* residual) const
  {
    using Vector3 = Eigen::Matrix<T, 3, 1>;
    using Quaternion = Eigen::Quaternion<T>;
    const Eigen::Map<const Quaternion> qs(q_source), qt(q_target);
    const Eigen::Map<const Vector3> ts(t_source), tt(t_target);
    const Quaternion q = qt.conjugate() * qs;
    const Vector3 t = qt.conjugate() * (ts - tt);
    const Quaternion measured(Eigen::Quaterniond(R_measured).cast<T>());
    // The motion E with estimate = E measured.
    const Quaternion q_error = q * measured.conjugate();
    const T wxyz[4] = {q_error.w(), q_error.x(), q_error.y(), q_error.z()};
    Eigen::Matrix<T, 6, 1> motion;
    ceres::QuaternionToAngleAxis(wxyz, motion.data());
    motion.template tail<3>() = t - q_error * t_measured.cast<T>();
    Eigen::Map<Eigen::Matrix<T, 6, 1>>(residual, 6) = weight.cast<T>() * motion;
    return true;
  }
};

} // namespace

std::vector<Eigen::Isometry3d>
solvePoseGraph(std::vector<Eigen::Isometry3d> poses, const std::vector<PoseGraphEdge>& edges)
{
  std::vector<Parameters> parameters;
  parameters.reserve(poses.size());
  for (const Eigen::Isometry3d& pose : poses)
    parameters.push_back({Eigen::Quaterniond(pose.linear()).normalized(), pose.translation()});
  ceres::Problem::Options ownership;
  ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ownership.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::CauchyLoss loss(kRobustScale);
  ceres::EigenQuaternionManifold manifold;
  ceres::Problem problem(ownership);
  std::vector<char> has_edge(poses.size(), 0);
  for (const PoseGraphEdge& edge : edges) {
    auto* error =
        new EdgeError{edge.T_target_source.linear(), edge.T_target_source.translation(), squareRoot(edge.information)};
    Parameters& source = parameters[static_cast<std::size_t>(edge.source)];
    Parameters& target = parameters[static_cast<std::size_t>(edge.target)];
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<EdgeError, 6, 4, 3, 4, 3>(error),
                             &loss,
                             source.rotation.coeffs().data(),
                             source.translation.data(),
                             target.rotation.coeffs().data(),
                             target.translation.data());
    has_edge[static_cast<std::size_t>(edge.source)] = has_edge[static_cast<std::size_t>(edge.target)] = 1;
  }
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!has_edge[i])
      continue;
    problem.SetManifold(parameters[i].rotation.coeffs().data(), &manifold);
    if (i == 0) {
      problem.SetParameterBlockConstant(parameters[i].rotation.coeffs().data());
      problem.SetParameterBlockConstant(parameters[i].translation.data());
    }
  }
  if (edges.empty())
    return poses;
  ceres::Solver::Options solver;
  solver.linear_solver_type = poses.size() < 60 ? ceres::DENSE_NORMAL_CHOLESKY : ceres::SPARSE_NORMAL_CHOLESKY;
  solver.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE; // one thread, whatever BLAS is installed
  solver.num_threads = 1; // the order of sums, and so the bits, must not depend on the machine
  solver.max_num_iterations = kIterations;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  if (!summary.IsSolutionUsable())
    return poses;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!has_edge[i])
      continue;
    poses[i].linear() = parameters[i].rotation.normalized().toRotationMatrix();
    poses[i].translation() = parameters[i].translation;
  }
  return poses;
}

} // namespace pcl_ssfr
