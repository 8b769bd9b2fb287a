"""Where recordings come from: our bench, MuJoCo, and equations written down here; a file each."""
