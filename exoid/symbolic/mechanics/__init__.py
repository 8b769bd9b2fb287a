"""From links and joints to equations of motion and base parameters."""
