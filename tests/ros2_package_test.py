# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, pcl_ssfr contributors
"""examples/ros2: what can be said of the package without ROS: its files agree with each other."""
import ast
import pathlib
import re
import unittest
import xml.etree.ElementTree

ROOT = pathlib.Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "examples" / "ros2"
NO_ROS = {"PCL": "libpcl-all-dev"}  # found by CMake -> name in package.xml


class Package(unittest.TestCase):
    """Build files, node, launch file and page."""

    def setUp(self):
        self.cmake = (PACKAGE / "CMakeLists.txt").read_text()
        self.node = (PACKAGE / "src" / "registration_node.cpp").read_text()
        self.xml = xml.etree.ElementTree.parse(PACKAGE / "package.xml").getroot()
        self.launch = ast.parse((PACKAGE / "launch" / "registration.launch.py").read_text())

    def constants(self):
        """The dictionaries of the launch file; types by name."""
        found = {}
        for statement in self.launch.body:
            if isinstance(statement, ast.Assign):
                keys = [key.value for key in statement.value.keys]
                values = [value.elts[1].id if isinstance(value, ast.Tuple) else value.value for value in statement.value.values]
                found[statement.targets[0].id] = dict(zip(keys, values))
        return found

    def test_package_file(self):
        self.assertEqual(self.xml.get("format"), "3")
        self.assertEqual(self.xml.findtext("export/build_type"), "ament_cmake")
        self.assertIn(f"project({self.xml.findtext('name')} ", self.cmake)
        version = re.search(r"project\(pcl_ssfr VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text()).group(1)
        self.assertEqual(self.xml.findtext("version"), version)

    def test_what_cmake_finds_is_a_dependency(self):
        found = {NO_ROS.get(name, name) for name in re.findall(r"find_package\((\w+)", self.cmake)}
        declared = {e.text for e in self.xml if e.tag in ("depend", "buildtool_depend")}
        self.assertEqual(found, declared)
        linked = re.search(r"ament_target_dependencies\(registration_node ([^)]*)\)", self.cmake).group(1).split()
        self.assertEqual(set(linked), found - {"ament_cmake", "pcl_ssfr", "libpcl-all-dev"})

    def test_what_the_node_includes_is_linked(self):
        included = {name for name in re.findall(r"#include <(\w+)/", self.node)} - {"pcl_ssfr_ros2"}
        declared = {e.text for e in self.xml if e.tag == "depend"}
        self.assertTrue(included)
        self.assertLessEqual(included, declared)

    def test_files_that_cmake_names_are_there(self):
        for name in re.findall(r"src/\w+\.cpp", self.cmake):
            self.assertTrue((PACKAGE / name).is_file(), name)
        sources = {f"src/{path.name}" for path in (PACKAGE / "src").iterdir()}
        self.assertEqual(sources, set(re.findall(r"src/\w+\.cpp", self.cmake)))

    def test_parameters_agree(self):
        types = {"int": "int", "double": "float", "bool": "bool", "std::string": "str"}
        declared = {name: types[kind] for kind, name in re.findall(r'declare_parameter<([\w:]+)>\(\s*"(\w+)"', self.node)}
        self.assertEqual(len(declared), 9)
        self.assertEqual(self.constants()["PARAMETERS"], declared)
        page = (ROOT / "docs" / "ROS2.md").read_text()
        for name in declared:
            self.assertIn(f"| `{name}` |", page)

    def test_topics_agree(self):
        used = set(re.findall(r'create_(?:subscription|publisher)<[\w:]+>\(\s*"(\w+)"', self.node))
        self.assertEqual(set(self.constants()["TOPICS"]), used)

    def test_the_core_knows_no_ros(self):
        for path in [*PACKAGE.rglob("*.h"), *(p for p in PACKAGE.rglob("*.cpp") if p.name != "registration_node.cpp")]:
            headers = re.findall(r"#include <([\w/]+)", path.read_text())
            self.assertFalse([h for h in headers if re.match(r"rclcpp|tf2|sensor_msgs|geometry_msgs|std_msgs", h)], path)


if __name__ == "__main__":
    unittest.main()
