// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include <apps/common/random_stream.h>
#include <apps/simulation/mesh_file.h>
#include <apps/simulation/ray_caster.h>
#include <apps/simulation/simulation_error.h>

#include <gmock/gmock.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace pcl_ssfr::simulation::test_mesh_file {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kQuadObj = "v 0 0 1\nv 2 0 1\nv 2 3 1\nv 0 3 1\nf 1 2 3 4\n";

class MeshFile : public ::testing::Test {
protected:
  void
  SetUp() override
  {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::path(::testing::TempDir()) / (std::string("pcl_ssfr_mesh_") + test->name());
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void
  TearDown() override
  {
    std::filesystem::remove_all(folder_);
  }
  std::string
  write(const std::string& name, const std::string& content) const
  {
    std::string path = (folder_ / name).string();
    std::ofstream(path, std::ios::binary) << content;
    return path;
  }
  static std::string
  errorOf(const std::string& path)
  {
    try {
      loadMesh(path);
    }
    catch (const SimulationError& error) {
      return error.what();
    }
    return "no error";
  }
  std::filesystem::path folder_;
};

double
areaOf(const SurfaceModel& model)
{
  double area = 0;
  for (const auto& t : model.mesh.triangles) {
    const Eigen::Vector3f a = model.mesh.vertices[t[0]];
    area += static_cast<double>((model.mesh.vertices[t[1]] - a).cross(model.mesh.vertices[t[2]] - a).norm()) / 2;
  }
  return area;
}

TEST_F(MeshFile, ReadsObjAndSplitsItsFaces)
{
  const SurfaceModel model = loadMesh(write("quad.obj", kQuadObj));
  EXPECT_EQ(model.mesh.triangles.size(), 2U);
  EXPECT_NEAR(areaOf(model), 6, 1e-6);
  ASSERT_EQ(model.materials.size(), 1U);
  EXPECT_EQ(model.materials[0].reflectance, 0.5);
  const RayCaster caster(model);
  EXPECT_NEAR(caster.cast({1, 1, 5}, -Eigen::Vector3d::UnitZ(), 100)->distance, 4, 1e-12);
}

TEST_F(MeshFile, ReadsAsciiPly)
{
  const SurfaceModel model = loadMesh(write("a.ply",
                                            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                                            "property float y\nproperty float z\nelement face 1\n"
                                            "property list uchar int vertex_indices\nend_header\n"
                                            "0 0 0\n4 0 0\n0 2 0\n3 0 1 2\n"));
  EXPECT_EQ(model.mesh.triangles.size(), 1U);
  EXPECT_NEAR(areaOf(model), 4, 1e-6);
  EXPECT_EQ(model.materials[model.mesh.material[0]].reflectance, 0.5);
}

TEST_F(MeshFile, ReadsAsciiAndBinaryStl)
{
  const SurfaceModel ascii = loadMesh(write("a.stl",
                                            "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
                                            "vertex 0 1 0\nendloop\nendfacet\nendsolid s\n"));
  EXPECT_EQ(ascii.mesh.triangles.size(), 1U);
  EXPECT_NEAR(areaOf(ascii), 0.5, 1e-6);

  std::string binary(80, ' ');
  const std::uint32_t count = 1;
  binary.append(reinterpret_cast<const char*>(&count), 4);
  const float facet[12] = {0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 2, 0};
  binary.append(reinterpret_cast<const char*>(facet), sizeof(facet));
  binary.append(2, '\0');
  const SurfaceModel model = loadMesh(write("b.stl", binary));
  EXPECT_EQ(model.mesh.triangles.size(), 1U);
  EXPECT_NEAR(areaOf(model), 2, 1e-6);
}

TEST_F(MeshFile, ColoursBecomeReflectances)
{
  write("m.mtl", "newmtl white\nKd 0.9 0.9 0.9\nnewmtl dark\nKd 0.1 0.1 0.1\nnewmtl black\nKd 0 0 0\n");
  const SurfaceModel model = loadMesh(write("c.obj",
                                            "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
                                            "usemtl white\nf 1 2 3\nusemtl dark\nf 1 2 4\nusemtl black\nf 1 3 4\n"));
  ASSERT_EQ(model.mesh.triangles.size(), 3U);
  std::vector<double> reflectances;
  for (const std::uint16_t material : model.mesh.material)
    reflectances.push_back(model.materials[material].reflectance);
  EXPECT_THAT(reflectances, ::testing::UnorderedElementsAre(0.9, 0.1, 0.05)); // nothing reflects nothing at all
}

TEST_F(MeshFile, TrianglesWithoutAreaAreDropped)
{
  const SurfaceModel model =
      loadMesh(write("d.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 4\nf 1 1 4\n"));
  EXPECT_EQ(model.mesh.triangles.size(), 1U);
}

TEST_F(MeshFile, BadFilesAreNamed)
{
  const std::string missing = (folder_ / "missing.obj").string();
  EXPECT_EQ(errorOf(missing), missing + ": no such file");
  EXPECT_THAT(errorOf(folder_.string()), HasSubstr("is a directory"));
  for (const auto& [name, content] : std::vector<std::pair<std::string, std::string>>{
           {"empty.obj", ""},
           {"empty.ply", ""},
           {"empty.stl", ""},
           {"points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n"},
           {"lines.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n"},
           {"flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"},
           {"points.ply",
            "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
            "end_header\n0 0 0\n1 1 1\n"},
           {"rubbish.stl", "this is no mesh at all"},
           {"strange.xyzzy", "1 2 3\n"},
           {"noending", "1 2 3 4"}}) {
    const std::string path = write(name, content);
    const std::string error = errorOf(path);
    EXPECT_THAT(error, AllOf(HasSubstr(path + ": "), Not(HasSubstr("\n")))) << name;
  }
}

TEST_F(MeshFile, CoordinatesMustBeFiniteAndNear)
{
  EXPECT_THAT(errorOf(write("nan.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n")),
              AllOf(HasSubstr("nan.obj: vertex 1"), HasSubstr("finite")));
  EXPECT_THAT(errorOf(write("inf.obj", "v 0 0 0\nv 1e39 0 0\nv 0 1 0\nf 1 2 3\n")), HasSubstr("inf.obj: "));
  EXPECT_THAT(errorOf(write("far.obj", "v 4e6 0 0\nv 4000001 0 0\nv 4e6 1 0\nf 1 2 3\n")),
              HasSubstr("near the origin"));
}

TEST_F(MeshFile, RubbishNeverCrashes)
{
  RandomStream random(1);
  const std::string quad = kQuadObj;
  for (int i = 0; i < 300; ++i) {
    std::string content = quad;
    for (int k = 0; k < 3; ++k)
      content[static_cast<std::size_t>(random.index(static_cast<int>(content.size())))] =
          static_cast<char>(random.index(256));
    if (i % 3 == 0)
      content.resize(static_cast<std::size_t>(random.index(static_cast<int>(content.size()))));
    for (const char* ending : {"r.obj", "r.ply", "r.stl"}) {
      const std::string path = write(ending, content);
      try {
        validate(loadMesh(path));
      }
      catch (const SimulationError& error) {
        ASSERT_THAT(error.what(), HasSubstr(path));
      }
    }
  }
}

} // namespace
} // namespace pcl_ssfr::simulation::test_mesh_file
