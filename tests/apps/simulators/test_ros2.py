"""The ROS 2 package: what a controller asks of its solver is the model's torque; the rest is what ROS reads.

ROS itself is not needed: the class is compiled against the few declarations of it that it uses.
"""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from exoid.apps.simulators.export import ros2
from exoid.symbolic.joints import Joint
from exoid.symbolic.model import Model
from exoid.symbolic.model_file import Numbers
from exoid.symbolic.motion import Motion
from exoid.workbench.export import urdf
from exoid.workbench.identified import ExportError, Options, ready
from tests.workbench.test_export import expected, variant
from tests.workbench.test_export_machines import MACHINES, numbers

COMPILER = next((name for name in ("c++", "g++", "clang++") if shutil.which(name)), None)
STAND_INS = {
    "pluginlib/class_list_macros.hpp": "#define PLUGINLIB_EXPORT_CLASS(kind, base) using Exported = kind;\n",
    "rclcpp/parameter.hpp": "#pragma once\nnamespace rclcpp {\n"
    "struct Parameter { bool value = false; bool as_bool() const { return value; } };\n}\n",
    "rclcpp/node_interfaces/node_parameters_interface.hpp": """#pragma once
#include <memory>
#include <string>
#include <rclcpp/parameter.hpp>
namespace rclcpp::node_interfaces {
struct NodeParametersInterface {
  using ConstSharedPtr = std::shared_ptr<const NodeParametersInterface>;
  bool get_parameter(const std::string & name, rclcpp::Parameter & found) const {
    found.value = name == "solver.friction";
    return found.value;
  }
};
}
""",
    "inverse_dynamics_solver/inverse_dynamics_solver.hpp": """#pragma once
#include <Eigen/Core>
#include <rclcpp/node_interfaces/node_parameters_interface.hpp>
namespace inverse_dynamics_solver {
struct InverseDynamicsSolver {
  using V = Eigen::VectorXd;
  virtual ~InverseDynamicsSolver() {}
  virtual void initialize(rclcpp::node_interfaces::NodeParametersInterface::ConstSharedPtr,
                          const std::string & = "", const std::string & = "") = 0;
  virtual Eigen::MatrixXd getInertiaMatrix(const V &) const = 0;
  virtual V getCoriolisVector(const V &, const V &) const = 0;
  virtual V getGravityVector(const V &) const = 0;
  virtual V getFrictionVector(const V &) const = 0;
  virtual V getTorques(const V & q, const V & dq, const V & ddq) const {
    return getInertiaMatrix(q) * ddq + getCoriolisVector(q, dq) + getGravityVector(q);
  }
};
}
""",
}
ASKS = """#include "solver.cpp"
#include <cstdio>
#include <iostream>
int main() {
  const Eigen::Index size = SIZE_;
  Eigen::VectorXd q(size), dq(size), ddq(size);
  auto parameters = std::make_shared<const rclcpp::node_interfaces::NodeParametersInterface>();
  Exported plain, whole;
  plain.initialize(nullptr, "", "");
  whole.initialize(parameters, "solver", "");
  auto read = [&](Eigen::VectorXd & x) { for (Eigen::Index j = 0; j < size; ++j) std::cin >> x[j]; };
  for (;;) {
    read(q), read(dq), read(ddq);
    if (!std::cin) break;
    const Eigen::VectorXd rows[] = {whole.getTorques(q, dq, ddq), plain.getTorques(q, dq, ddq),
                                    plain.getFrictionVector(dq), plain.getGravityVector(q)};
    for (const auto & row : rows) for (Eigen::Index j = 0; j < size; ++j) std::printf("%.17g ", row[j]);
    std::printf("\\n");
  }
  try { plain.getGravityVector(Eigen::VectorXd::Zero(size + 1)); } catch (const std::invalid_argument &) { return 0; }
  return 1;
}
"""


def written(model: Model, given: Numbers, folder: Path, name: str = "my_leg") -> Path:
    """Write the package and return its folder."""
    for place, text in ros2.write(ready(model, given), Options(name)).items():
        (folder / place).parent.mkdir(parents=True, exist_ok=True)
        (folder / place).write_text(text, encoding="utf-8")
    return folder / f"{name}_ros2"


def asked(package: Path, on: Motion) -> np.ndarray:
    """Return whole torque, torque without friction, friction and gravity (4, N, J) from the compiled class."""
    casadi = pytest.importorskip("casadi")
    eigen = Path(casadi.__file__).parent / "include" / "eigen3"
    if COMPILER is None or not eigen.is_dir():
        pytest.skip("needs a C++ compiler and Eigen")
    source, size = package / "src", on.q.shape[1]
    for place, text in STAND_INS.items():
        (source / place).parent.mkdir(parents=True, exist_ok=True)
        (source / place).write_text(text, encoding="utf-8")
    (source / "asks.cpp").write_text(ASKS.replace("SIZE_", str(size)), encoding="utf-8")
    strict = ["-Wall", "-Wextra", "-Werror", "-O0", "-I.", "-isystem", str(eigen)]
    c_file = next(source.glob("*.c")).name
    for command in (
        [COMPILER, "-x", "c++", "-std=c++17", *strict, "-c", "asks.cpp", "-o", "asks.o"],
        [shutil.which("cc") or "gcc", "-std=c99", "-c", c_file, "-o", "model.o"],
        [COMPILER, "asks.o", "model.o", "-lm", "-o", "asks"],
    ):
        made = subprocess.run(command, cwd=source, capture_output=True, text=True, check=False)
        assert made.returncode == 0, made.stderr
    given = "\n".join(" ".join(map(repr, map(float, row))) for row in np.hstack([on.q, on.dq, on.ddq]))
    told = subprocess.run([source / "asks"], input=given, capture_output=True, text=True, check=True)
    rows = np.array([line.split() for line in told.stdout.splitlines()], dtype=float)
    return rows.reshape(len(on), 4, size).transpose(1, 0, 2)


def motion(size: int) -> Motion:
    q, dq, ddq = np.random.default_rng(4).uniform(-1.2, 1.2, (3, 12, size))
    return Motion(np.zeros(12), q, dq, ddq)


@pytest.mark.slow
def test_friction_that_is_of_the_velocity_completes_the_torque(tmp_path):
    model, given = variant("stribeck", "knee")
    model = model.with_effect("joint_spring", "hip").with_effect("rotor_inertia", "knee")
    given = Numbers({**{p.name: 0.4 for p in model.parameters}, **given.linear}, given.shape, None)
    on = motion(2)
    whole, frictionless, friction, _ = asked(written(model, given, tmp_path), on)
    np.testing.assert_allclose(whole, expected(model, given, on), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(frictionless + friction, whole, rtol=1e-9, atol=1e-9)
    assert not any("depends on more" in note for note in ros2.notes(ready(model, given), Options()))


@pytest.mark.slow
def test_friction_that_depends_on_more_is_in_the_whole_torque_and_is_said(tmp_path):
    chain = (Joint("lift", "prismatic", length=0.3), Joint("arm"))
    model = Model("lift", limits={}, joints=chain).with_effect("load_friction:arm")
    given, on = numbers(model), motion(2)
    whole, frictionless, friction, gravity = asked(written(model, given, tmp_path), on)
    np.testing.assert_allclose(whole, expected(model, given, on), rtol=1e-9, atol=1e-9)
    assert np.abs(frictionless + friction - whole).max() > 1e-3
    still = Motion(on.t, on.q, 0.0 * on.q, 0.0 * on.q)
    np.testing.assert_allclose(gravity, expected(model, given, still), rtol=1e-9, atol=1e-9)
    assert any("depends on more" in note for note in ros2.notes(ready(model, given), Options()))


def test_the_urdf_is_the_same_machine_and_names_its_interfaces():
    model, given = variant("stribeck", "hip")
    one, options = ready(model, given), Options("my_leg")
    text = ros2.write(one, options)["my_leg_ros2/urdf/my_leg.urdf"]
    root = ElementTree.fromstring(text)
    section = root.find("ros2_control")
    assert section is not None and [j.get("name") for j in section.iter("joint")] == list(model.joint_names)
    assert {i.get("name") for i in section.iter("command_interface")} == {"effort"}
    root.remove(section)
    alone = ElementTree.fromstring(urdf.write(one, options)["my_leg.urdf"])
    assert [e.attrib for e in root.iter()] == [e.attrib for e in alone.iter()]


def test_plugin_parameters_and_build_speak_of_the_same_solver():
    model, given = variant("stribeck", "hip")
    files = ros2.write(ready(model, given), Options("My_Leg"))  # packages of ROS are in small letters
    shown = ElementTree.fromstring(files["my_leg_ros2/plugins.xml"])
    found = shown.find("class")
    assert found is not None and found.get("type") == "my_leg::InverseDynamicsSolver"
    parameters = files["my_leg_ros2/config/my_leg.yaml"]
    assert f"dynamics_solver_plugin: {found.get('name')}\n" in parameters and "joints: [hip, knee]" in parameters
    assert f"src/{'My_Leg'}.c" in files["my_leg_ros2/CMakeLists.txt"] and "my_leg_ros2/src/My_Leg.c" in files
    assert ElementTree.fromstring(files["my_leg_ros2/package.xml"]).findtext("name") == shown.get("path") == "my_leg"


@pytest.mark.parametrize("name, why", [("hka", "memory"), ("legs", "base")])
def test_what_the_interface_cannot_carry_is_refused(name, why):
    with pytest.raises(ExportError, match=why):
        ros2.write(ready(MACHINES[name], numbers(MACHINES[name])), Options(sample_time=0.01))
