"""The names of the ways from angles to accelerations; the ways are in `exoid.measurement.signals.derivatives`."""

BUTTERWORTH, SAVGOL, FOURIER = DERIVATIVES = "butterworth", "savgol", "fourier"
