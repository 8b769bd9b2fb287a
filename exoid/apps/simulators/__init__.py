"""Models for simulators and ROS 2: Functional Mock-up Units and a solver of inverse dynamics."""
