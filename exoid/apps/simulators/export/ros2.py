"""A ROS 2 package: the identified machine as an inverse dynamics solver, which controllers load as a plugin.

    src/            the C of the format `c`, and a class of the documented interface `inverse_dynamics_solver` around it
                    (https://docs.ros.org/en/rolling/p/inverse_dynamics_solver): inertia, Coriolis, gravity, friction
    urdf/           the URDF of the format `urdf` with a <ros2_control> section
    config/         controllers that ask the solver, and what solves by KDL from the URDF alone, to be compared with it
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape, quoteattr

from exoid.ground.text import filled, in_comment
from exoid.workbench.bodies import base_name, gravity_of, link_names
from exoid.workbench.export import c, urdf
from exoid.workbench.identified import ExportError, Options, Ready

HELP = "a ROS 2 package: inverse dynamics with friction as a plugin of ros2_control's controllers, URDF, parameters"
ON_REQUEST = True
"""Written only where it is named: it is a folder, and for ROS 2 alone."""
FREQUENCY = 1.0
"""Hz: natural frequency of the gains proposed, critically damped; slow enough for any drive to begin with."""
MOST_UNEQUAL = 1e-9
"""N·m, relative to the largest torque: by more than rounding the friction differs between two postures."""
SOLVER, CONTROLLER = "inverse_dynamics_solver", "gravity_compensation_pd_controller"


def write(ready: Ready, options: Options) -> dict[str, str]:
    """Return {place in the package: text}; ExportError where the interface of solvers cannot carry the model."""
    _check(ready)
    package = options.name.lower()
    model, sources = ready.model, c.write(ready, options)
    middle = [repr(value) for value in _middle(ready)]
    forces = len(model.channels)
    solver = filled(Path(__file__).parents[1].joinpath("ros2_solver.cpp.in").read_text("utf-8"), {
        "TITLE": in_comment(model.name), "PLUGIN": _plugin(package), "JOINTS": ", ".join(model.joint_names),
        "NAME": options.name, "PACKAGE": package, "SIZE": len(model.joints), "MIDDLE": ", ".join(middle),
        "FORCE": f"    const double force[{forces}] = {{}};  // measured ones are not known here\n" if forces else "",
        "GIVEN": "force, " if forces else "",
    })  # fmt: skip
    files = {
        **{f"src/{file}": text for file, text in sources.items()}, "src/solver.cpp": solver,
        "package.xml": _package(package, model.name), "CMakeLists.txt": _cmake(package, options.name),
        "plugins.xml": _plugins(package, model.name), f"config/{package}.yaml": _parameters(ready, package),
        f"urdf/{package}.urdf": _urdf(ready, options),
    }  # fmt: skip
    return {f"{package}_ros2/{place}": text for place, text in files.items()}


def notes(ready: Ready, options: Options) -> tuple[str, ...]:
    """Return notes that a user has to know before the package is run."""
    said = ["ros2: the URDF allows no effort, and its hardware is a mock: put in your drives' own"]
    if ready.model.channels:
        said.append("ros2: measured forces are taken for zero, which solvers are not told")
    if _unequal(ready):
        said.append(
            "ros2: friction of this model depends on more than velocity; getFrictionVector is that of the middle of "
            "the range, and with `friction: true` getTorques has all of it"
        )
    return tuple(said)


def _check(ready: Ready) -> None:
    if ready.memories:
        raise ExportError(
            "a ROS 2 solver is asked out of order, and this model has an effect with memory",
            remedy="export it as c or fmu, or without this effect",
        )
    if ready.model.moving_base:
        raise ExportError(
            "a ROS 2 solver is not told how the base moves", remedy="export it as c or fmu, which take the base"
        )


def _plugin(package: str) -> str:
    return f"{package}/InverseDynamicsSolver"


def _middle(ready: Ready) -> list[float]:
    """Return the middle of each joint's range, 0 where it has none."""
    limits = ready.model.motion_limits
    found = [0.5 * sum(limits[name].angle) if name in limits else 0.0 for name in ready.model.joint_names]
    return [value if math.isfinite(value) else 0.0 for value in found]


def _torque(ready: Ready, q: Any, dq: Any, ddq: Any, function: Any = None) -> Any:
    """Return the torque (J,), or another function of the model, at t = 0 without measured forces."""
    import numpy as np

    outside = [np.zeros(len(ready.model.channels))] if ready.model.channels else []
    return np.asarray((function or ready.torque)(0.0, q, dq, ddq, np.sign(dq), [], *outside).full().ravel())


def _inertia(ready: Ready, q: Any) -> Any:
    """Return the inertia matrix (J, J), rotors included."""
    import numpy as np

    still = np.zeros(len(ready.model.joints))
    return np.column_stack([_torque(ready, q, still, row) for row in np.eye(len(still))]) - _held(ready, q)[:, None]


def _held(ready: Ready, q: Any) -> Any:
    import numpy as np

    still = np.zeros(len(ready.model.joints))
    return _torque(ready, q, still, still)


def _friction(ready: Ready, q: Any, dq: Any, ddq: Any) -> Any:
    """Return the rest of the torque beside inertia, Coriolis and what holds the machine."""
    import numpy as np

    size = len(ready.model.joints)
    matrix = _torque(ready, q, dq, ddq, ready.coriolis).reshape(size, size)
    return np.asarray(_torque(ready, q, dq, ddq) - _held(ready, q) - _inertia(ready, q) @ ddq - matrix @ dq)


def _unequal(ready: Ready) -> bool:
    """True if friction in other postures and accelerations is not that of the middle of the range."""
    import numpy as np

    middle, rng = np.array(_middle(ready)), np.random.default_rng(0)
    for _ in range(8):
        dq, ddq, aside = rng.normal(size=(3, len(middle)))
        gap = _friction(ready, middle, dq, 0.0 * ddq) - _friction(ready, middle + 0.3 * aside, dq, ddq)
        if np.abs(gap).max() > MOST_UNEQUAL * max(1.0, np.abs(_torque(ready, middle, dq, ddq)).max()):
            return True
    return False


def _package(package: str, title: str) -> str:
    needed = "\n".join(f"  <depend>{name}</depend>" for name in ("eigen", SOLVER, "pluginlib", "rclcpp"))
    return f"""<?xml version="1.0"?>
<package format="3">
  <name>{package}</name>
  <version>0.0.1</version>
  <description>Inverse dynamics of {escape(title)}, identified by exoid.</description>
  <maintainer email="nobody@example.com">nobody yet</maintainer>
  <license>yours</license>
  <buildtool_depend>ament_cmake</buildtool_depend>
{needed}
  <export><build_type>ament_cmake</build_type></export>
</package>
"""


def _cmake(package: str, name: str) -> str:
    return f"""cmake_minimum_required(VERSION 3.8)
project({package} C CXX)
find_package(ament_cmake REQUIRED)
find_package(Eigen3 REQUIRED)
find_package({SOLVER} REQUIRED)
find_package(pluginlib REQUIRED)
find_package(rclcpp REQUIRED)
add_library(${{PROJECT_NAME}} SHARED src/solver.cpp src/{name}.c)
target_compile_features(${{PROJECT_NAME}} PUBLIC c_std_99 cxx_std_17)
target_include_directories(${{PROJECT_NAME}} PRIVATE ${{{SOLVER}_INCLUDE_DIRS}})
target_link_libraries(${{PROJECT_NAME}} Eigen3::Eigen pluginlib::pluginlib rclcpp::rclcpp)
pluginlib_export_plugin_description_file({SOLVER} plugins.xml)
install(TARGETS ${{PROJECT_NAME}} ARCHIVE DESTINATION lib LIBRARY DESTINATION lib RUNTIME DESTINATION bin)
install(DIRECTORY config urdf DESTINATION share/${{PROJECT_NAME}})
ament_package()
"""


def _plugins(package: str, title: str) -> str:
    kind = f"{SOLVER}::InverseDynamicsSolver"
    return f"""<library path="{package}">
  <class name="{_plugin(package)}" type="{package}::InverseDynamicsSolver" base_class_type="{kind}">
    <description>Inverse dynamics with friction of {escape(title)}, identified by exoid.</description>
  </class>
</library>
"""


def _ends(ready: Ready) -> tuple[str, str]:
    """Return the links at which the machine begins and ends; where it branches, one of its ends."""
    names = link_names(ready)
    return base_name(names), names[-1]


def _parameters(ready: Ready, package: str) -> str:
    """Return the parameters of the controllers."""
    import numpy as np

    own = np.maximum(np.diag(_inertia(ready, _middle(ready))), 0.0)
    turns = 2.0 * math.pi * FREQUENCY
    stiff, damp = (", ".join(f"{value:.3f}" for value in factor * own) for factor in (turns**2, 2.0 * turns))
    joints, (root, tip) = ", ".join(ready.model.joint_names), _ends(ready)
    solver = f"      root: {root}\n      tip: {tip}\n      gravity: [{', '.join(map(repr, gravity_of(ready)))}]"
    return f"""# Gains: {FREQUENCY:g} Hz and critically damped with the identified inertia, to begin with.
controller_manager:
  ros__parameters:
    update_rate: 1000
    joint_state_broadcaster:
      type: joint_state_broadcaster/JointStateBroadcaster
    {package}_controller:
      type: {CONTROLLER}/GravityCompensationPDController

{package}_controller:
  ros__parameters:
    joints: [{joints}]
    p_gains: [{stiff}]
    d_gains: [{damp}]
    compensate_gravity: true
    dynamics_solver:
      # Without friction and effects, from the URDF alone: kdl_{SOLVER}/InverseDynamicsSolverKDL
      dynamics_solver_plugin: {_plugin(package)}
{solver}
      # true: getTorques has friction as well, for controllers that do not ask for it by itself
      friction: false
"""


def _urdf(ready: Ready, options: Options) -> str:
    """Return the URDF, with a section in which ros2_control finds the joints."""
    text = urdf.write(ready, options)[f"{options.name}.urdf"]
    joints = "\n".join(
        f'    <joint name={quoteattr(joint.name)}>\n      <command_interface name="effort"/>\n'
        f'      <state_interface name="position"><param name="initial_value">{value!r}</param></state_interface>\n'
        '      <state_interface name="velocity"/>\n      <state_interface name="effort"/>\n    </joint>'
        for joint, value in zip(ready.model.joints, _middle(ready), strict=True)
    )
    section = f"""  <ros2_control name="{options.name.lower()}" type="system">
    <hardware><plugin>mock_components/GenericSystem</plugin></hardware>
{joints}
  </ros2_control>
"""
    return text.replace("</robot>", f"{section}</robot>")
